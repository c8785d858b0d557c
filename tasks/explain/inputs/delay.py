"""A long delay of all time stamps, found before anything is linearised about none.

A motion that oscillates determines a delay by its phase only to within half a period; a fit that
begins at nothing ends on the wrong turn. So the slow motion is compared first, by means over long
windows, and what is faster over ever shorter ones: each determines the turn of the next.
"""

from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import Recording
from tasks.explain.inputs.full_rate import FullRate
from tasks.motion.smooth import interpolated

WIDTHS = (0.32, 0.16, 0.08, 0.04)  # s: windows of mean rates, from slow to fast
MAX_DELAY = 0.3  # s
MIN_DELAY = 0.01  # s: what is shorter a fit finds by itself
LAGS = 41  # within each span
CLEAR = 2.0  # times less misfit than without a delay
MIN_WINDOWS = 30
RANK = 1e-9


def coarse_delay(full: FullRate, until: float = np.inf) -> float:
    """Seconds by which all stamps are late, to a few milliseconds; 0 where no long one is clear.

    Integrals of the gyros beside those of the motion's rates; each gyro follows a straight line
    in the three rates, so that scale factors, cross coupling and biases do not matter.
    until: s, what is later is not used, such as stamps after samples were lost.
    """
    t = full.motion.t
    known = full.motion.known & np.isfinite(full.readings[:, :3]).all(axis=1) & (t < until)
    if known.sum() < 2:
        return 0.0
    turned = _integral(t, np.where(known[:, None], full.motion.rate, 0.0))
    read = _integral(t, np.where(known[:, None], full.readings[:, :3], 0.0))
    gaps = np.concatenate([[0.0], np.cumsum(~known)])[1:]
    delay, span = 0.0, MAX_DELAY
    for width in WIDTHS:
        edges = np.arange(t[0] + 2.0 * MAX_DELAY, t[-1] - 2.0 * MAX_DELAY, width)
        if len(edges) <= MIN_WINDOWS:
            return 0.0
        rates = np.diff(interpolated(edges, t, turned), axis=0) / width
        before, after = (np.interp(edges + reach, t, gaps) for reach in (-MAX_DELAY, MAX_DELAY))
        whole = after[1:] == before[:-1]  # windows without a gap within any delay
        if whole.sum() < MIN_WINDOWS:
            return 0.0
        basis = _basis(np.column_stack([rates, np.ones(len(rates))])[whole])
        windows = _Windows(t, read, edges, width, whole, basis)
        lags = delay + np.linspace(-span, span, LAGS)
        misfits = [windows.misfit(lag) for lag in lags]
        delay = float(lags[int(np.argmin(misfits))])
        span = 0.25 * width
    clear = MIN_DELAY <= abs(delay) <= MAX_DELAY and windows.misfit(0.0) > CLEAR * min(misfits)
    return delay if clear else 0.0


@dataclass(frozen=True)
class _Windows:
    """Windows of one width, between edges (k + 1,); whole: (k,) those without a gap.

    t, read: (n,), (n, 3) angles that the gyros read; basis: of the motion's mean rates and one.
    """

    t: np.ndarray
    read: np.ndarray
    edges: np.ndarray
    width: float
    whole: np.ndarray
    basis: np.ndarray

    def misfit(self, lag: float) -> float:
        """Sum of squares that straight lines in the rates leave of the gyros' means, read late."""
        angles = interpolated(self.edges + lag, self.t, self.read)
        means = np.diff(angles, axis=0)[self.whole] / self.width
        return float((means**2).sum() - ((self.basis.T @ means) ** 2).sum())


def advanced(recording: Recording, delay: float) -> Recording:
    """The recording with the unit's stamps `delay` seconds earlier."""
    return replace(recording, imu=replace(recording.imu, t=recording.imu.t - delay))


def _integral(t: np.ndarray, rates: np.ndarray) -> np.ndarray:
    steps = np.diff(t)[:, None] * (rates[1:] + rates[:-1]) / 2.0
    return np.vstack([np.zeros((1, rates.shape[1])), np.cumsum(steps, axis=0)])


def _basis(columns: np.ndarray) -> np.ndarray:
    """Orthonormal columns that span the same."""
    left, size, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(left[:, size > RANK * size[0]])
