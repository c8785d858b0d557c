"""A run of the table as segments: hold, move to angles, change the rate, keep the rate."""

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Segment:
    """One segment of the run.

    label: further fields of the manifest's segment. fixing: which mounting of the unit it
    belongs to. goto: angles in rad to move to, one for each table axis, or None.
    ramp: (rate before, rate after) of the first axis in rad/s, or None; equal rates keep turning.
    turn: angle in rad by which the first axis turns from rest to rest, or None. chamber: °C to
    which the chamber is set as it begins, or None.
    """

    name: str
    kind: str
    duration: float
    fixing: int
    label: dict[str, Any]
    goto: tuple[float, ...] | None = None
    ramp: tuple[float, float] | None = None
    turn: float | None = None
    chamber: float | None = None


def follow(segment: Segment, start: np.ndarray, since: np.ndarray) -> np.ndarray:
    """Angles (axes, n) in rad at times `since` the segment's start, from the angles `start`."""
    angles = np.repeat(start[:, None], len(since), axis=1)
    share = since / segment.duration
    # minimum jerk: at rest, without acceleration, at both ends
    progress = share**3 * (10.0 + share * (-15.0 + 6.0 * share))
    if segment.goto is not None:
        angles += (arrival(segment, start) - start)[:, None] * progress
    if segment.turn is not None:
        angles[0] += segment.turn * progress
    if segment.ramp is not None:
        before, after = segment.ramp
        # the acceleration is one arch of 1 − cos: the rate's change, integrated once more
        grown = share**2 / 2.0 + (np.cos(2.0 * np.pi * share) - 1.0) / (4.0 * np.pi**2)
        angles[0] += segment.duration * (before * share + (after - before) * grown)
    return angles


def arrival(segment: Segment, start: np.ndarray) -> np.ndarray:
    """Where a move ends: its target, by the shortest way round."""
    target = np.asarray(segment.goto)
    return target + 2.0 * np.pi * np.round((start - target) / (2.0 * np.pi))
