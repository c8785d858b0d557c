"""What a trial consists of."""

from collections import Counter

from tests.proof.plant.effects import CATALOGUE, OUTSIDE
from tests.proof.plant.procedures import plan_of
from tests.proof.trial.draw import MOST_ROWS, OF_ITS_OWN, draw


def test_full_form_has_120_clean_cases_and_every_effect_at_every_z() -> None:
    cases = draw(3)
    assert len(cases) >= 406
    assert sum(each.kind == "clean" for each in cases) == 120
    alone = Counter(
        (each.case.effects[0].name, each.z) for each in cases if len(each.case.effects) == 1
    )
    for name in set(CATALOGUE) - set(OF_ITS_OWN):
        assert all(alone[name, z] == 2 for z in (10.0, 30.0, 100.0)), name
    for name in OUTSIDE:
        assert all(alone[name, z] == 1 for z in (30.0, 100.0)), name
    assert all(alone[name, None] for name in OF_ITS_OWN)
    together = Counter(len(each.case.effects) for each in cases)
    assert together[2] >= 20
    assert together[3] >= 10


def test_short_form_is_short_and_has_a_case_of_each_kind() -> None:
    cases = draw(3, short=True)
    assert len(cases) <= 32
    assert {each.kind for each in cases} == {"clean", "single", "faint", "several", "outside"}
    assert sum(each.kind == "clean" for each in cases) >= 0.2 * len(cases)


def test_seed_determines_the_cases() -> None:
    assert draw(5) == draw(5)
    assert draw(5) != draw(6)


def test_numbers_tell_nothing_of_the_kind() -> None:
    cases = draw(1)
    assert [each.number for each in cases] == list(range(1, len(cases) + 1))
    first, second = cases[: len(cases) // 2], cases[len(cases) // 2 :]
    clean = [sum(each.kind == "clean" for each in half) for half in (first, second)]
    assert min(clean) > 0.25 * sum(clean)


def test_runs_are_short_enough_to_be_explained_in_seconds() -> None:
    for each in draw(2):
        rows = plan_of(each.case).duration * each.case.rate_hz
        assert rows < 1.2 * MOST_ROWS, each.case


def test_conditions_are_spread() -> None:
    cases = [each.case for each in draw(1)]
    assert {each.grade for each in cases} == {"consumer", "industrial", "tactical"}
    assert {each.rate_hz for each in cases} == {50, 100, 200}
    assert len({each.procedure for each in cases}) == 6
    ahrs = [each for each in cases if each.procedure == "ahrs"]
    assert 0.02 * len(cases) < len(ahrs) < 0.1 * len(cases)
    assert {each.temperature_recorded for each in cases} == {True, False}
    assert {each.climate for each in cases} == {"room", "cycling"}


def test_ahrs_runs_hide_nothing_that_needs_moves_to_positions() -> None:
    outside = [each for seed in (1, 2, 3) for each in draw(seed) if each.kind == "outside"]
    assert all(each.case.procedure != "ahrs" for each in outside)
