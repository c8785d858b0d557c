"""A chamber that is set in the course of a run: its air, and what of it reaches the unit."""

from dataclasses import dataclass

import numpy as np

from tests.proof.plant.case import Case
from tests.proof.plant.seeds import generator

STATED_K_S = 4.0 / 60.0  # in the station file
STEP = 0.1  # s


@dataclass(frozen=True)
class Heating:
    """Beyond the room's: air K, of the unit K, and its change K/s, each (n,)."""

    air: np.ndarray
    unit: np.ndarray
    unit_rate: np.ndarray


def set_points(case: Case) -> list[tuple[float, float]]:
    """When (s) a case's procedure sets the chamber, and to what (°C)."""
    if case.procedure != "given":
        return []
    from tests.proof.plant.procedures import plan_of  # late: a plan's segments know no weather

    plan = plan_of(case)
    return [
        (float(begins), segment.chamber)
        for segment, begins in zip(plan.segments, plan.bounds, strict=False)
        if segment.chamber is not None
    ]


def heating(
    case: Case, t: np.ndarray, settings: list[tuple[float, float]], room: float, warm_up: float
) -> Heating:
    """At times t (n,) s.

    settings: (s, °C). room: °C before the first. warm_up: s, time constant of the unit's
    warming by its own heat; it follows the air in about the same, and the chamber is not quite as
    fast as it is said to be.
    """
    if not settings:
        return Heating(*np.zeros((3, len(t))))
    rng = generator(case.seed, "chamber")
    fastest, lag = STATED_K_S * rng.uniform(0.85, 1.1), warm_up * rng.uniform(0.8, 1.25)
    times = np.arange(0.0, float(t[-1]) + 2.0 * STEP, STEP)
    air, unit = np.zeros(len(times)), np.zeros(len(times))
    goals = np.zeros(len(times))
    for at, degc in settings:
        goals[times >= at] = degc - room
    for k in range(1, len(times)):
        air[k] = air[k - 1] + np.clip(goals[k] - air[k - 1], -fastest * STEP, fastest * STEP)
        unit[k] = unit[k - 1] + (air[k - 1] - unit[k - 1]) * STEP / lag
    change = (air - unit) / lag
    return Heating(*(np.interp(t, times, each) for each in (air, unit, change)))
