"""The statistics of a run: they add up, and a file keeps all that they say."""

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.discrepancy import Review, RunStatistics
from schemas.recording import Recording
from storage import run_statistics as kept
from storage.home import Home
from tasks.review.pool import VERSION, Pool, ReviewedRun, pooled, statistics_of
from tasks.review.report import review_of
from tasks.review.search import search
from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import simulate

TILT = (2e-4, -3e-4)  # rad


def recording(seed: int, unit_seed: int) -> Recording:
    tilt = EffectCall(name="axis_tilt", parameters={"east": TILT[0], "north": TILT[1]})
    case = Case(
        seed=seed, unit_seed=unit_seed, procedure="rests", rate_hz=20, dwell_s=5.0, effects=(tilt,)
    )
    return simulate(case).recording


@pytest.fixture(scope="module")
def two() -> tuple[RunStatistics, RunStatistics]:
    return statistics_of(recording(1, 7)), statistics_of(recording(2, 8))


def pool(statistics: tuple[RunStatistics, ...]) -> Pool:
    runs = [ReviewedRun(f"r{k}", f"{k}", {"unit": f"{k}"}) for k in range(len(statistics))]
    return pooled(list(zip(runs, statistics, strict=True)))


def tilt_of(two: tuple[RunStatistics, ...]) -> tuple[np.ndarray, np.ndarray]:
    together = pool(two)
    effect = next(one for one in together.effects if one.name == "axis_tilt")
    score, information = together.evidence(effect)
    covariance = np.linalg.inv(information.sum(axis=0))
    return covariance @ score.sum(axis=0), np.sqrt(np.diag(covariance))


def test_the_sum_over_units_gives_what_they_have_in_common(
    two,
):
    value, u = tilt_of(two)
    assert value == pytest.approx(TILT, abs=4.0 * float(u.max()))
    assert (np.abs(value) > 5.0 * u).all()
    assert (u < tilt_of(two[:1])[1]).all()


def test_what_was_found_is_taken_off_every_score(two):
    together = pool(two)
    effect = next(one for one in together.effects if one.name == "axis_tilt")
    value, u = tilt_of(two)
    left, information = together.less(effect, value, np.array([True, True])).evidence(effect)
    assert np.abs(np.linalg.solve(information.sum(axis=0), left.sum(axis=0))) == pytest.approx(
        np.zeros(2), abs=0.05 * float(u.min())
    )


def test_runs_of_one_procedure_share_a_layout(two):
    assert two[0].layout_key == two[1].layout_key


def test_kept_statistics_are_those_that_were_made_and_small(
    two,
):
    content = kept.encoded(two[0], VERSION)
    again = kept.decoded(content, VERSION)
    assert again.layout == two[0].layout
    for name in ("correlation", "right", "scale", "left_over"):
        np.testing.assert_array_equal(getattr(again, name), getattr(two[0], name))
    assert len(content) < 100_000


def test_damaged_statistics_and_those_of_another_version_are_as_good_as_none(two, tmp_path):
    home = Home(tmp_path)
    kept.keep_statistics("d" * 64, VERSION, two[0], home)
    assert kept.load("d" * 64, VERSION + 1, home) is None
    path = home.path / kept.name_of("d" * 64)
    path.write_bytes(path.read_bytes()[:1000])
    assert kept.load("d" * 64, VERSION, home) is None
    kept.keep_statistics("d" * 64, VERSION, two[0], home)
    assert kept.load("d" * 64, VERSION, home) is not None


def test_a_recording_that_is_too_short_says_so():
    whole = recording(1, 7)
    short = Recording(whole.manifest, whole.imu.at(slice(0, 150)), whole.table)
    with pytest.raises(Unusable):
        statistics_of(short)


# Where single runs are strong, the linear forms of names that look alike decide nothing.

EFFECTS = {
    "SN1": EffectCall(name="lever_arm", parameters={"r": [0.012, -0.018, 0.007]}),
    "SN2": EffectCall(name="time_offset", parameters={"seconds": 0.006}),
    "SN3": None,
}


@pytest.fixture(scope="module")
def review() -> Review:
    """Of three units of a station, two of them with an effect of hundreds of its own u."""
    runs = []
    for seed, (unit, effect) in enumerate(EFFECTS.items(), start=1):
        case = Case(
            seed=seed, rate_hz=25, rates_deg_s=(30.0, 150.0), dwell_s=5.0,
            effects=(effect,) if effect else (),
        )  # fmt: skip
        who = ReviewedRun(unit, unit, {"unit": unit, "station": "S", "model": "M"})
        runs.append((who, statistics_of(simulate(case).recording)))
    pool = pooled(runs)
    return review_of(pool, *search(pool))


@pytest.mark.parametrize(
    ("unit", "effect", "alike"),
    [("SN1", "lever_arm", "size_effect"), ("SN2", "time_offset", "bandwidth")],
)
def test_the_simplest_name_stands_beside_those_that_it_cannot_be_told_from(
    review, unit, effect, alike
):
    (finding,) = (one for one in review.findings if one.carrier == unit)
    assert finding.effect == effect
    assert alike in finding.indistinguishable_from
