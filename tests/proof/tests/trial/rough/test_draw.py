"""What a rough trial consists of."""

from collections import Counter

import pytest

from tests.proof.plant.rough.effects import FORMS, KNOWN, catalogue_name
from tests.proof.trial.rough.draw import LOGGER, OTHER_FORMS, draw_rough


def test_full_form_has_200_recordings_of_every_kind_run_and_form() -> None:
    cases = draw_rough(3)
    assert len(cases) >= 200
    kinds = Counter(each.kind for each in cases)
    assert min(kinds.values()) >= 28
    assert set(kinds) == {"control", "listed", "form", "logger", "outside", "mixed"}
    assert min(Counter(each.rough.run for each in cases).values()) >= 50
    hidden = Counter(call.name for each in cases for call in each.rough.case.effects)
    assert all(hidden[form] for form in (*LOGGER, *OTHER_FORMS))
    assert all(name in KNOWN for name in hidden)
    assert set(LOGGER) | set(OTHER_FORMS) == {f for f in FORMS if not f.startswith("x_")}


def test_short_form_has_24_of_every_kind() -> None:
    cases = draw_rough(3, short=True)
    assert len(cases) == 24
    assert len({each.kind for each in cases}) == 6


def test_seed_determines_the_cases_and_numbers_tell_nothing() -> None:
    assert draw_rough(5) == draw_rough(5)
    assert draw_rough(5) != draw_rough(6)
    cases = draw_rough(5)
    first = [each.kind == "control" for each in cases[:100]]
    assert 0.25 * 42 < sum(first) < 0.75 * 42


@pytest.mark.parametrize("seed", [1, 2])
def test_references_are_as_rough_as_said(seed: int) -> None:
    cases = [each.rough for each in draw_rough(seed)]
    for encoder in (each.encoder for each in cases if each.encoder is not None):
        assert 0.01 <= encoder.step * 57.29578 <= 0.3
    for tracking in (each.tracking for each in cases if each.tracking is not None):
        assert 5e-5 <= tracking.position_noise <= 5e-4
        assert 0.02 <= tracking.attitude_noise * 57.29578 <= 0.2
        assert tracking.delay in (0.0, 0.5 / tracking.rate_hz)
    assert all((each.tracking is None) == (each.run != "hand") for each in cases)
    assert all(3.0 <= each.top_rate <= 5.0 for each in cases if each.run == "hand")


def test_what_is_outside_comes_two_or_three_at_once_and_strong_beside_listed_ones() -> None:
    for each in draw_rough(4):
        names = [catalogue_name(call.name) for call in each.rough.case.effects]
        outside = [name for name in names if name.startswith("x_")]
        assert len(names) == len(set(names))
        assert len(outside) in {"outside": (2, 3), "mixed": (1, 2)}.get(each.kind, (0,))
        assert len(names) - len(outside) == (each.kind not in ("outside", "control"))
