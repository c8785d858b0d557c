"""Latitude and heading that no manifest tells, recovered from the runs of two stations."""

from dataclasses import replace

import numpy as np
import pytest

from schemas.discrepancy import EstimatedSite, RunStatistics
from tasks.review.pool import ReviewedRun, pooled, statistics_of
from tasks.review.report import K, sites_of
from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import simulate

TRUTH = {"ST-01": (39.9, 37.0), "ST-02": (-22.5, -120.0)}  # latitude, heading
RUNS = 4

Kept = dict[str, list[RunStatistics]]


def statistics(station: str, seed: int) -> RunStatistics:
    """Of a run whose manifest does not tell where it stands."""
    latitude, heading = TRUTH[station]
    case = Case(
        seed=seed, unit_seed=seed % 3, grade="tactical", procedure="rests", rate_hz=20,
        dwell_s=5.0, latitude_deg=latitude, heading_deg=heading, site_known=False,
        effects=(EffectCall(name="earth_rotation"),),
    )  # fmt: skip
    return statistics_of(simulate(case).recording)


@pytest.fixture(scope="module")
def kept() -> Kept:
    return {
        station: [statistics(station, seed) for seed in range(first, first + RUNS)]
        for first, station in enumerate(TRUTH, start=1)
    }


def estimates(kept: Kept) -> tuple[EstimatedSite, ...]:
    runs = [
        (ReviewedRun(f"{station} {k}", f"{k}", {"station": station, "unit": f"{k % 3}"}), each)
        for station, some in kept.items()
        for k, each in enumerate(some)
    ]
    return sites_of(pooled(runs))


def deviations(site: EstimatedSite) -> tuple[float, float]:
    """Of latitude and heading from the truth, in standard uncertainties."""
    latitude, heading = TRUTH[site.station]
    assert site.latitude_deg is not None
    assert site.latitude_expanded is not None
    assert site.heading_deg is not None
    assert site.heading_expanded is not None
    return (
        K * (site.latitude_deg - abs(latitude)) / site.latitude_expanded,
        K * (site.heading_deg - heading) / site.heading_expanded,
    )


def test_a_station_whose_runs_have_several_layouts_is_told_once(kept):
    first, *rest = kept["ST-01"]
    terms = tuple(
        term.model_copy(update={"rarity": term.rarity + 1.0}) for term in first.layout.terms
    )
    layout = first.layout.model_copy(update={"terms": terms})
    other = replace(first, layout=layout, layout_key=layout.key)
    assert len(estimates({"ST-01": [other, *rest]})) == 1


def test_each_station_gets_its_own_latitude_and_heading_within_u(kept):
    sites = estimates(kept)
    assert [site.station for site in sites] == list(TRUTH)
    for site in sites:
        assert max(map(abs, deviations(site))) < K
        assert "estimated from Earth's rotation" in site.statement.en
        assert f"in {RUNS} runs" in site.statement.en


@pytest.mark.rehearsal
def test_u_covers_the_truth_as_often_as_it_says_and_shrinks_with_runs(kept):
    alone = [site for k in range(RUNS) for site in estimates({s: [r[k]] for s, r in kept.items()})]
    off = np.array([deviations(site) for site in alone])
    assert (np.abs(off) < K).mean() >= 0.85
    assert 0.4 < float(np.sqrt((off**2).mean())) < 1.5
    for together in estimates(kept):
        own = [s.heading_expanded for s in alone if s.station == together.station]
        usual = float(np.median([each for each in own if each is not None]))
        assert together.heading_expanded == pytest.approx(usual / np.sqrt(RUNS), rel=0.3)
