"""A long delay of all stamps, told before anything is linearised about none.

A motion that oscillates tells a delay by its phase only to within half a period; a fit that begins
at nothing ends on the wrong turn. So the slow motion is compared first, by means over long
stretches, and what is faster within ever shorter ones: each tells the turn of the next.
"""

from dataclasses import replace

import numpy as np

from schemas.recording import Recording
from tasks.explain.inputs.full_rate import FullRate
from tasks.motion.smooth import interpolated

WIDTHS = (0.32, 0.16, 0.08, 0.04)  # s: means of rates, from slow to fast
MOST = 0.3  # s
LONG = 0.01  # s: what is shorter a fit finds by itself
TRIED = 41  # delays within each span
CLEAR = 2.0  # times less misfit than without a delay
FEWEST = 30  # means that are compared
RANK = 1e-9


def coarse_delay(full: FullRate, until: float = np.inf) -> float:
    """Seconds by which all stamps are late, to a few milliseconds; 0 where no long one is clear.

    Integrals of the gyros beside those of the motion's rates; each gyro follows a straight line
    in the three rates, so that scale factors, cross coupling and biases do not matter.
    until: s, what is later is not looked at, such as stamps after samples were lost.
    """
    known = full.motion.known & np.isfinite(full.readings[:, :3]).all(axis=1)
    known &= full.motion.t < until
    if known.sum() < 2:
        return 0.0
    t = full.motion.t
    turned, read = (
        _integral(t, np.where(known[:, None], each, 0.0))
        for each in (full.motion.rate, full.readings[:, :3])
    )
    gaps = np.concatenate([[0.0], np.cumsum(~known)])[1:]
    late, span = 0.0, MOST
    for width in WIDTHS:
        edges = np.arange(t[0] + 2.0 * MOST, t[-1] - 2.0 * MOST, width)
        if len(edges) <= FEWEST:
            return 0.0
        rates = np.diff(interpolated(edges, t, turned), axis=0) / width
        reach = np.interp(edges + MOST, t, gaps)[1:] - np.interp(edges - MOST, t, gaps)[:-1]
        whole = reach == 0.0
        if whole.sum() < FEWEST:
            return 0.0
        basis = _basis(np.column_stack([rates, np.ones(len(rates))])[whole])
        lags = late + np.linspace(-span, span, TRIED)
        misfits = [_misfit(lag, edges, whole, width, t, read, basis) for lag in lags]
        late = float(lags[int(np.argmin(misfits))])
        span = 0.25 * width
    without = _misfit(0.0, edges, whole, width, t, read, basis)
    clear = abs(late) >= LONG and abs(late) <= MOST and without > CLEAR * min(misfits)
    return late if clear else 0.0


def advanced(recording: Recording, late: float) -> Recording:
    """The recording with the unit's stamps `late` seconds earlier."""
    return replace(recording, imu=replace(recording.imu, t=recording.imu.t - late))


def _integral(t: np.ndarray, rates: np.ndarray) -> np.ndarray:
    steps = np.diff(t)[:, None] * (rates[1:] + rates[:-1]) / 2.0
    return np.vstack([np.zeros((1, rates.shape[1])), np.cumsum(steps, axis=0)])


def _basis(columns: np.ndarray) -> np.ndarray:
    turned, size, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(turned[:, size > RANK * size[0]])


def _misfit(
    lag: float,
    edges: np.ndarray,
    whole: np.ndarray,
    width: float,
    t: np.ndarray,
    read: np.ndarray,
    basis: np.ndarray,
) -> float:
    """Sum of squares that straight lines in the rates leave of the gyros' means, read late."""
    means = np.diff(interpolated(edges + lag, t, read), axis=0)[whole] / width
    return float((means**2).sum() - ((basis.T @ means) ** 2).sum())
