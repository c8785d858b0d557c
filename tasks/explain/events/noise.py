"""The noise of a sample by the rate, and the level of a spectrum by the state of the motion.

A table in motion shakes what stands on it; what is left of the motion itself is largest where the
rate changes.
"""

import numpy as np

from tasks.motion.samples import in_blocks, interpolated
from tasks.motion.whole import Motion

BLOCK = 64  # rows, within which the noise is estimated
RATE_CLASSES = np.array(
    [0.0, 0.02, 0.1, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, np.inf]
)  # rad/s
MIN_BLOCKS = 3  # that the noise of a class of rates is estimated from
DEAD = 1e-10  # rad/s, m/s²: less scatter is the rounding of sums

REST, ROTATION, RATE_CHANGE = range(3)
STEADY = 0.02  # rad/s: how far the rate may move within a second where it counts as steady
SETTLING = 5.0  # s after a change of rate that still count to it
MIN_VALUES = 12  # that the level of a state is estimated from
MAX_MEDIAN_ROWS = 200  # evenly spread


def noise_by_rate(residual: np.ndarray, motion: Motion) -> np.ndarray:
    """Standard deviation (n, 6) of a sample at each row's rate: vibration grows with the rate.

    residual: (n, 6), NaN where unknown. The median over the blocks of a class of rates, so that
    a few disturbed blocks do not matter, linear in the rate between the classes.
    """
    if len(residual) < BLOCK:
        return np.full(residual.shape, np.nan)
    scatter = _block_scatter(residual)
    speed = np.linalg.norm(motion.rate, axis=1)
    speeds = in_blocks(speed, BLOCK).mean(axis=1)
    return np.column_stack([_interpolated_noise(column, speeds, speed) for column in scatter.T])


def without_dead(noise: np.ndarray) -> np.ndarray:
    """The noise (n, 6), NaN in a channel that never scatters: it is dead."""
    return np.where(np.nan_to_num(noise).max(axis=0) > DEAD, noise, np.nan)


def _block_scatter(residual: np.ndarray) -> np.ndarray:
    """Standard deviation (blocks, 6) about a straight line within each whole block of rows."""
    cut = in_blocks(residual, BLOCK)
    line = np.linspace(-1.0, 1.0, BLOCK)
    about = cut - cut.mean(axis=1, keepdims=True)
    slope = np.einsum("bni,n->bi", about, line) / (line @ line)
    total = (about**2).sum(axis=1) - slope**2 * (line @ line)
    return np.sqrt(np.maximum(total, 0.0) / (BLOCK - 2))


def _interpolated_noise(scatter: np.ndarray, speeds: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Noise (n,) at each speed (n,), from the scatter and the mean speed of blocks (b,)."""
    good = np.isfinite(scatter) & np.isfinite(speeds)
    if not good.any():
        finite = scatter[np.isfinite(scatter)]
        return np.full(len(speed), np.median(finite) if len(finite) else np.nan)
    scatter, speeds = scatter[good], speeds[good]
    label = np.digitize(speeds, RATE_CLASSES)
    classes = [label == k for k in np.unique(label)]
    classes = [c for c in classes if c.sum() >= MIN_BLOCKS or c.all()]
    if not classes:
        return np.full(len(speed), np.median(scatter))
    at = [float(np.median(speeds[c])) for c in classes]
    return np.interp(np.nan_to_num(speed), at, [float(np.median(scatter[c])) for c in classes])


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
