"""Units and equipment as they might be: drawn from what the uncertainty budgets claim."""

from dataclasses import dataclass

import numpy as np

from tasks.station.virtual.unit import UnitTruth, draw_unit
from tasks.uncertainty.distributions import draw
from tasks.uncertainty.equipment import Limit
from tasks.validation.journey import Site

GRAVITY, LATITUDE = 9.8015, float(np.radians(39.9))  # what the manifest says
NO_FLICKER = 0.25  # share of the units that have white noise alone
FLICKER_GRADES = (0.1, 10.0)  # times the unit's usual flicker, evenly in its logarithm


@dataclass(frozen=True)
class Case:
    """One simulated unit, its random numbers, and whether noise and equipment are ideal."""

    unit: UnitTruth
    random: np.random.Generator
    ideal: bool = False

    def error(self, *limits: Limit | None) -> float:
        """Sum of errors drawn from the limits' distributions, in their unit; 0 when ideal."""
        if self.ideal:
            return 0.0
        return float(sum(_error(limit, self.random) for limit in limits if limit is not None))

    def errors(self, count: int, *limits: Limit | None) -> np.ndarray:
        """Independent errors (count,)."""
        return np.array([self.error(*limits) for _ in range(count)])

    def site(self, gravity: Limit, latitude: Limit) -> Site:
        """Where it truly is; the manifest says GRAVITY and LATITUDE."""
        return Site(GRAVITY + self.error(gravity), LATITUDE + self.error(latitude))


def draw_case(seed: int, rate_hz: float, ideal: bool = False) -> Case:
    """A unit of the virtual station, with a grade of flicker of its own.

    A quarter of the units have white noise alone, as often as not in either triad.
    """
    unit = draw_unit(seed)
    random = np.random.default_rng(np.random.SeedSequence((seed, 2)))
    triads = {}
    for name in ("gyro", "accel"):
        triad = getattr(unit, name)
        low, high = np.log(FLICKER_GRADES)
        grade = float(np.exp(random.uniform(low, high))) * (random.random() >= NO_FLICKER)
        triads[name] = triad.model_copy(update={"flicker": triad.flicker * grade})
    return Case(unit.model_copy(update={**triads, "rate_hz": rate_hz}), random, ideal)


def _error(limit: Limit, random: np.random.Generator) -> float:
    return limit.u * float(draw(limit.distribution, 1, random)[0])
