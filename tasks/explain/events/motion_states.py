"""Motion states: rest, steady rotation and rate change, each with a noise level of its own."""

import numpy as np

from tasks.motion.smooth import interpolated
from tasks.motion.whole import Motion

REST, ROTATION, RATE_CHANGE = range(3)
STEADY = 0.02  # rad/s: how far the rate may move within a second where it counts as steady
SETTLING = 5.0  # s after a change of rate that still count to it
MIN_VALUES = 12  # that the level of a state is estimated from
MAX_MEDIAN_ROWS = 200  # evenly spread


def motion_states(motion: Motion, at: np.ndarray) -> np.ndarray:
    """The state (m,) at times at (m,) s, rising. Unknown motion counts as a change of rate."""
    rate = interpolated(at, motion.t, np.nan_to_num(motion.rate))
    step = float(np.median(np.diff(at))) if len(at) > 1 else 1.0
    half = max(1, round(0.5 / step))
    padded = np.pad(rate, ((half, half), (0, 0)), mode="edge")
    changes = np.abs(padded[2 * half :] - padded[: -2 * half]).max(axis=1) > STEADY
    changes = changes | (np.interp(at, motion.t, motion.known.astype(float)) < 1)
    changes = changes | (np.diff(at, prepend=-np.inf) > 1.5 * step)
    latest = np.maximum.accumulate(np.where(changes, at, -np.inf))
    steady = np.where(np.linalg.norm(rate, axis=1) > STEADY, ROTATION, REST)
    return np.where(at - latest < SETTLING, RATE_CHANGE, steady)


def median_by_state(power: np.ndarray, state: np.ndarray) -> np.ndarray:
    """The median (m, k) of power (m, k) over each motion state; infinite in a short one."""
    level = np.ones(power.shape, power.dtype)
    for number in np.unique(state):
        rows = state == number
        level[rows] = _median(power[rows]) if rows.sum() >= MIN_VALUES else np.inf
    return level


def equalised(power: np.ndarray, state: np.ndarray, min_rows: int) -> np.ndarray:
    """Power (m, k), divided down where one interval is louder than its motion state as a whole.

    An interval lies between two changes of state. One of fewer than `min_rows` rows stays as it
    is: the transient that is looked for may fill it.
    """
    usual = {number: _median(power[state == number]) for number in np.unique(state)}
    even = power.copy()
    edges = np.flatnonzero(np.diff(state)) + 1
    for start, stop in zip(np.append(0, edges), np.append(edges, len(state)), strict=True):
        if stop - start >= min_rows:
            own, among = _median(power[start:stop]), usual[state[start]]
            louder = np.divide(own, among, out=np.ones_like(own), where=among > 0)
            even[start:stop] /= np.maximum(louder, 1.0)
    return even


def _median(power: np.ndarray) -> np.ndarray:
    """The median (k,) of power (m, k), over evenly spread rows where there are many."""
    return np.asarray(np.median(power[:: len(power) // MAX_MEDIAN_ROWS + 1], axis=0))
