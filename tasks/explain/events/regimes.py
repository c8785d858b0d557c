"""Where the motion is alike, so that what is left can be compared: rest, even turns, changes."""

import numpy as np

from tasks.explain.events.plain import read_at
from tasks.motion.whole import Motion

RESTS, TURNS, CHANGES = range(3)
STEADY = 0.02  # rad/s: how far the rate may move within a second where it counts as steady
SETTLES = 5.0  # s after a change of rate that still count to it
FEWEST = 12  # values that tell the level of a regime
MOST = 200  # values that a median is taken of


def regimes_at(motion: Motion, at: np.ndarray) -> np.ndarray:
    """The regime (m,) at times at (m,) s, rising. What is not known counts as a change."""
    speed = read_at(at, motion.t, np.nan_to_num(motion.rate))
    step = float(np.median(np.diff(at))) if len(at) > 1 else 1.0
    half = max(1, round(0.5 / step))
    padded = np.pad(speed, ((half, half), (0, 0)), mode="edge")
    changes: np.ndarray = np.asarray(
        np.abs(padded[2 * half :] - padded[: -2 * half]).max(axis=1) > STEADY
    )
    changes |= np.interp(at, motion.t, motion.known.astype(float)) < 1
    changes |= np.diff(at, prepend=-np.inf) > 1.5 * step
    latest = np.maximum.accumulate(np.where(changes, at, -np.inf))
    turns = np.linalg.norm(speed, axis=1) > STEADY
    regime = np.where(turns, TURNS, RESTS)
    return np.where(at - latest < SETTLES, CHANGES, regime)


def levels(power: np.ndarray, regime: np.ndarray) -> np.ndarray:
    """The median (m, k) of power (m, k) where the motion is alike."""
    level = np.ones(power.shape, power.dtype)
    for each in np.unique(regime):
        rows = regime == each
        level[rows] = _median(power[rows]) if rows.sum() >= FEWEST else np.inf
    return level


def without_louder(power: np.ndarray, regime: np.ndarray, fewest: int) -> np.ndarray:
    """Power (m, k) over that of its stretch, where that is louder than the others of its regime.

    A stretch is what lies between two changes of regime; of less than `fewest` values it tells no
    level, for what is looked for may fill it.
    """
    usual = {each: _median(power[regime == each]) for each in np.unique(regime)}
    even = power.copy()
    edges = np.flatnonzero(np.diff(regime)) + 1
    for start, stop in zip(np.append(0, edges), np.append(edges, len(regime)), strict=True):
        if stop - start >= fewest:
            own, among = _median(power[start:stop]), usual[regime[start]]
            louder = np.divide(own, among, out=np.ones_like(own), where=among > 0)
            even[start:stop] /= np.maximum(louder, 1.0)
    return even


def _median(power: np.ndarray) -> np.ndarray:
    """The median (k,) of power (m, k), of evenly spread rows where there are many."""
    return np.asarray(np.median(power[:: len(power) // MOST + 1], axis=0))
