"""A long delay of all stamps, found before the model is linearised without one.

A motion that oscillates determines a delay by its phase only to within half a period; a fit that
begins at nothing ends on the wrong turn. So the slow motion is compared first, by means over long
windows, and what is faster over ever shorter ones: each determines the turn of the next.
"""

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import orth

from tasks.explain.inputs.blocks import FullRate
from tasks.motion.samples import interpolated

WIDTHS = (0.32, 0.16, 0.08, 0.04)  # s: windows of mean rates, from slow to fast
MAX_DELAY = 0.3  # s
MIN_DELAY = 0.01  # s: what is shorter a fit finds by itself
LAGS = 41  # within each span
CLEAR = 2.0  # times less misfit than without a delay
MIN_WINDOWS = 30
RANK = 1e-9


def coarse_delay(full: FullRate, until: float = np.inf) -> float:
    """Seconds by which all stamps are late, to a few milliseconds; 0 where no long one is clear.

    Of poses any delay, however short: half a frame is usual, and known better than a frame.

    Integrals of the gyros beside those of the motion's rates; each gyro follows a straight line
    in the three rates, so that scale factors, cross coupling and biases do not matter.
    until: s, what is later is not used, such as stamps after samples were lost.
    """
    t = full.motion.t
    known = full.motion.felt[:, 0] & np.isfinite(full.readings[:, :3]).all(axis=1) & (t < until)
    if known.sum() < 2:
        return 0.0
    turned, read = (
        cumulative_trapezoid(np.where(known[:, None], rates, 0.0), t, axis=0, initial=0)
        for rates in (full.motion.rate, full.readings[:, :3])
    )
    gaps = np.cumsum(~known)
    delay, span = 0.0, MAX_DELAY
    # Windows shorter than the interval of a slow unit's rows show straight lines between them.
    widths = [width for width in WIDTHS if width >= full.motion.interval]
    if not widths:
        return 0.0
    for width in widths:
        edges = np.arange(t[0] + 2.0 * MAX_DELAY, t[-1] - 2.0 * MAX_DELAY, width)
        if len(edges) <= MIN_WINDOWS:
            return 0.0
        before, after = (np.interp(edges + reach, t, gaps) for reach in (-MAX_DELAY, MAX_DELAY))
        whole = after[1:] == before[:-1]  # windows without a gap within any delay
        if whole.sum() < MIN_WINDOWS:
            return 0.0
        lags = delay + np.linspace(-span, span, LAGS)
        without, *misfits = _misfits(np.append(0.0, lags), t, turned, read, edges, whole)
        best = int(np.argmin(misfits))
        delay = float(lags[best])
        span = 0.25 * width
    if full.motion.tracking is not None:
        return delay + (lags[1] - lags[0]) * _vertex(misfits, best)
    clear = MIN_DELAY <= abs(delay) <= MAX_DELAY and without > CLEAR * min(misfits)
    return delay if clear else 0.0


def _vertex(misfits: list[float], best: int) -> float:
    """Where a parabola through the least misfit and its neighbours is least, in steps from it."""
    if not 0 < best < len(misfits) - 1:
        return 0.0
    before, least, after = misfits[best - 1 : best + 2]
    bend = before - 2.0 * least + after
    return 0.5 * (before - after) / bend if bend > 0 else 0.0


def _misfits(
    lags: np.ndarray, t: np.ndarray, turned: np.ndarray, read: np.ndarray, edges: np.ndarray,
    whole: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Sums of squares that straight lines in the motion's rates leave of the gyros', read late.

    turned, read: (n, 3) angles of the motion and of the gyros at t (n,). Rates are means over the
    windows between edges (k + 1,); whole: (k,) bool, those that count.
    """
    width = edges[1] - edges[0]
    rates = (np.diff(interpolated(edges, t, turned), axis=0) / width)[whole]
    basis = orth(np.column_stack([rates, np.ones(len(rates))]), rcond=RANK)
    misfits = []
    for lag in lags:
        means = (np.diff(interpolated(edges + lag, t, read), axis=0) / width)[whole]
        misfits.append((means**2).sum() - ((basis.T @ means) ** 2).sum())
    return np.array(misfits)
