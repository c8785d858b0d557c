"""How likely effects make the same runs, beside the whole covariance matrix of their readings."""

import copy
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from tasks.explain.explanation import CERTAIN
from tasks.review.carriers import (
    Carried,
    carried,
    chance,
    explains,
    gain_beside,
    is_of_a_spread,
    likeliest,
    other_names,
    scored,
    usual,
)
from tasks.review.hypotheses import Effect, Evidence, at_unit_information
from tasks.review.pool import Pool, ReviewedRun, pooled
from tasks.review.random_effects import BETWEEN_UNITS, IN_EVERY_RUN, Worth, spreads
from tasks.review.windows import Window, rows_of
from tests.tasks.review.fleet import NOTHING, ROWS, SIZES, fleet, of, place, statistics

UNITS, STATIONS = (0, 0, 1, 1, 2, 2, 3, 3), (0, 1, 0, 1, 0, 1, 1, 1)
HERE = Window("station", 0, 0, 3, 3)
TILT, ARM = "axis_tilt", "lever_arm"
CLOSE = 2e-3  # relative: correlations are kept in 16 bits


class Runs:
    """Runs of which the readings are known, not only their statistics."""

    def __init__(self, spread: float) -> None:
        rng = np.random.default_rng(4)
        own = spread * rng.standard_normal((4, SIZES[1]))
        self.columns, self.readings, found = list[np.ndarray](), list[np.ndarray](), []
        for day, (unit, station) in enumerate(zip(UNITS, STATIONS, strict=True)):
            columns = rng.standard_normal((ROWS, sum(SIZES))) / np.sqrt(ROWS)
            values = of(TILT, 4.0 * (station == 0))
            values[place(ARM)] = own[unit]
            noise = copy.deepcopy(rng).standard_normal(ROWS)
            carriers = {"unit": f"U{unit}", "station": f"S{station}"}
            run = ReviewedRun(f"r{day}", f"{day}", carriers)  # type: ignore[arg-type]
            found.append((run, statistics(rng, columns, values)))
            self.columns.append(columns)
            self.readings.append(columns @ values + noise)
        self.pool = pooled(found)

    def covariance(
        self, evidence: Evidence, name: str, tau: float, runs: Sequence[int]
    ) -> np.ndarray:
        """Of the readings of some runs: white noise, and an effect that units differ in."""
        own = [self.columns[r][:, place(name)] @ evidence.back for r in runs]
        stacked = np.concatenate(own)
        unit = np.repeat([UNITS[r] for r in runs], ROWS)
        variance = tau**2 * (unit[:, None] == unit) + IN_EVERY_RUN**2
        return np.eye(len(unit)) + variance * (stacked @ stacked.T)

    def nats(self, covariance: np.ndarray, name: str | None, runs: Sequence[int]) -> float:
        """ln p beyond white noise alone, with the best common value of an effect at station 0."""
        y = np.concatenate([self.readings[r] for r in runs])
        inverse = np.linalg.inv(covariance)
        found = 0.5 * (y @ y - y @ inverse @ y - np.linalg.slogdet(covariance)[1])
        if name is not None:
            x = np.concatenate([self.columns[r][:, place(name)] * (STATIONS[r] == 0) for r in runs])
            right = x.T @ inverse @ y
            found += 0.5 * right @ np.linalg.solve(x.T @ inverse @ x, right)
        return float(found)


def worth(pool: Pool, name: str, *windows: Window) -> Worth:
    """Of an effect in its form of the most parameters."""
    effect: Effect = max((e for e in pool.effects if e.name == name), key=lambda e: len(e.own))
    return Worth(effect, windows, at_unit_information(*pool.evidence(effect), pool.unit))


def here(pool: Pool, name: str) -> Carried:
    (one,) = carried(pool, worth(pool, name, HERE), (HERE,), 1)
    return one


EVERY, OTHERS = tuple(range(len(UNITS))), tuple(r for r in range(len(UNITS)) if STATIONS[r])


def test_an_effect_explains_runs_by_their_likelihood_given_the_others():
    runs = Runs(0.0)
    one = here(runs.pool, TILT)
    assert (one.spread.sigma, one.effect.name) == (0.0, TILT)
    expected = [
        runs.nats(runs.covariance(one.evidence, TILT, one.spread.tau, some), name, some)
        for some, name in ((EVERY, TILT), (OTHERS, None))
    ]
    found = explains(runs.pool, one, rows_of(runs.pool, HERE), one)
    assert found + one.price == pytest.approx(2.0 * (expected[0] - expected[1]), rel=CLOSE)


@pytest.mark.parametrize("spread", [0.0, 3.0])
def test_a_gain_beside_the_spread_of_another_effect_is_that_of_the_whole_covariance(spread):
    runs, tau = Runs(spread), 2.0
    one, other = here(runs.pool, TILT), worth(runs.pool, ARM)
    covariance = runs.covariance(other.evidence, ARM, tau, EVERY)
    expected = runs.nats(covariance, TILT, EVERY) - runs.nats(covariance, None, EVERY)
    beside = likeliest(other.evidence, (0.0,), (tau,))
    found = gain_beside(runs.pool, one, other.effect, beside)
    assert found == pytest.approx(2.0 * expected, rel=CLOSE)


def test_the_usual_spread_is_that_of_the_other_runs():
    none, much = (Runs(spread).pool for spread in (0.0, 3.0))
    nothing = usual(worth(none, ARM).evidence, rows_of(none, HERE))
    spread = usual(worth(much, ARM).evidence, rows_of(much, HERE))
    assert nothing is None
    assert spread is not None
    assert spread.tau in BETWEEN_UNITS[2:]


def test_a_spread_makes_a_value_uncertain_by_its_share_of_the_variance():
    """Of twelve units with one run each, and of forty runs of the first of them."""
    unit = np.concatenate([np.zeros(40, int), np.arange(1, 12)])
    evidence = at_unit_information(np.ones((51, 1)), np.ones((51, 1, 1)), unit)
    first = unit == 0
    narrow, wide = spreads(evidence, (0.0,), (0.05, 5.0))
    known = chance(evidence, likeliest(evidence, (0.0,), (0.0,)), 16.0, ~first)
    assert chance(evidence, narrow, 16.0, ~first) == pytest.approx(known, rel=0.1)
    assert chance(evidence, wide, 16.0, first) == pytest.approx(2.1e-3, rel=0.1)  # F(1, 11)


# What else explains the runs of a finding.

UNIT = 4
TRIED = 10_000
ALIKE = ("size_effect", "gyro_g2_sensitivity")
OWN = 2.0 * np.random.default_rng(13).standard_normal((12, SIZES[3]))


def with_spread(spread: float) -> Pool:
    """Each unit has something of its own of one effect, and one of them more."""

    def values(unit: int, station: int, day: int) -> np.ndarray:
        own = NOTHING.copy()
        own[place(ALIKE[1])] = spread * OWN[unit]
        return own + of(ALIKE[1], 3.0 * (unit == UNIT))

    return fleet(13, values, runs=160, alike=ALIKE)


def at_the_unit(pool: Pool, one: Worth) -> Carried:
    """The effect at the unit, as if units had no spread of it."""
    carrier = pool.names["unit"].index(f"U{UNIT}")
    count = int((pool.unit == carrier).sum())
    window = Window("unit", carrier, 0, count, count)
    rows = rows_of(pool, window)[None]
    (spread,) = spreads(one.evidence, (0.0,), (0.0,))
    gain = 2.0 * float(spread.gains(rows)[0])
    return scored(pool, one.effect, one.evidence, window, spread, gain, gain, 1)


@pytest.mark.parametrize(("spread", "is_usual"), [(1.0, True), (0.0, False)])
def test_a_unit_is_no_mismatch_by_what_all_have_of_an_effect_that_explains_it_as_well(
    spread, is_usual
):
    pool = with_spread(spread)
    one = at_the_unit(pool, worth(pool, ALIKE[0]))
    assert one.score > 20.0
    assert is_of_a_spread(pool, one, [worth(pool, ALIKE[1])], TRIED, 0.01) == is_usual


def test_a_name_is_not_excluded_for_what_it_costs_beforehand():
    pool = fleet(
        12, lambda unit, station, day: of(ALIKE[0], 2.0 * (station == 2)), runs=80, alike=ALIKE
    )
    count = int((pool.carrier["station"] == 2).sum())
    best, alike = (worth(pool, name, Window("station", 2, 0, count, count)) for name in ALIKE)
    many = replace(alike, effect=replace(alike.effect, trials=1000))
    (one,), others = (
        carried(pool, best, best.windows, TRIED),
        [carried(pool, each, each.windows, TRIED)[0] for each in (alike, many)],
    )
    assert others[0].score - others[1].score > CERTAIN
    for other in others:
        (named,) = other_names(pool, [other], one, one)
        assert named is other
