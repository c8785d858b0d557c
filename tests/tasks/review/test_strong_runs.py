"""Where single runs are strong, the linear forms of names that look alike decide nothing."""

import pytest

from schemas.review import Review
from tasks.review.pool import ReviewedRun, pooled
from tasks.review.report import review_of
from tasks.review.run_statistics import statistics_of
from tasks.review.search import search
from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import simulate

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
            seed=seed, rate_hz=50, rates_deg_s=(30.0, 150.0), dwell_s=5.0,
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
    review: Review, unit: str, effect: str, alike: str
) -> None:
    (finding,) = (one for one in review.findings if one.carrier == unit)
    assert finding.effect == effect
    assert alike in finding.indistinguishable_from
