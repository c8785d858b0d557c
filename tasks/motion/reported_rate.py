"""Whether the rate that a table reports beside its angle is the rate of that angle.

A rate that the table's controller measured is quieter than any derivative of the angle and does
not round off the corners of a ramp. But many tables report the rate commanded, a filtered one, or
a difference of angles half an interval late; then the angle is what counts.
"""

import numpy as np

from schemas.recording import Stream
from tasks.motion.samples import in_blocks, noise_by_differences, running_on

STEADY = 0.02  # rad/s²: less of it is a dwell at rate
MOVING = 0.005  # rad/s
BLOCK = 16  # increments whose mean shows a slow difference beneath the encoder's noise
FEWEST_BLOCKS = 10  # of steady motion; fewer prove nothing
SCALE, LAG, ROUNDED = 1e-5, 2e-3, 0.03  # of the rate, of the interval, of the interval squared
AGREEING = 1.5  # of the noise expected: the rms of block means
NEGLIGIBLE = 1e-6  # rad/s: a difference that no unit on a table resolves
EVEN = 0.01  # of the interval: stamps that differ by more are not compared
# the angle's increment over one interval, by the rates at four samples around it
QUADRATURE = np.array([-1.0, 13.0, 13.0, -1.0]) / 24.0
ORDER = 3  # of the differences that the noise is read off


def reported_rate(table: Stream, axis: str) -> np.ndarray | None:
    """The rate (n,) rad/s that a table reports of an axis; None where it is not its angle's."""
    rate = table.columns.get(f"{axis}_rate")
    if rate is None:
        return None
    angle = running_on(table.columns[f"{axis}_angle"])
    return rate if is_rate_of(table.t, angle, rate) else None


def is_rate_of(t: np.ndarray, angle: np.ndarray, rate: np.ndarray) -> bool:
    """Whether a reported rate (n,) rad/s is that of the angle (n,) rad at even times (n,) s.

    Its integral must give the angle's increments: without a scale, without a lag, without
    rounded corners, and within the noise of both, at steady rates where there are any; and it
    must be quieter than the angle's differences.
    """
    if len(t) < 4 * BLOCK or not (np.isfinite(angle) & np.isfinite(rate)).all():
        return False
    interval = float(np.median(np.diff(t)))
    if np.abs(np.diff(t) - interval).max() > EVEN * interval:
        return False
    middle = np.convolve(rate, QUADRATURE, "valid")
    missed = np.diff(angle)[1:-1] / interval - middle
    change = (rate[2:-1] - rate[1:-2]) / interval
    bend = (rate[3:] - rate[2:-1] - rate[1:-2] + rate[:-3]) / 2.0
    moving = np.abs(middle) > MOVING
    regressors = np.column_stack([middle, change * interval, bend])
    of_angle = np.sqrt(2.0) * noise_by_differences(angle, ORDER, 0.5) / interval
    of_rate = noise_by_differences(rate, ORDER, 0.5)
    if of_rate > of_angle + NEGLIGIBLE:
        return False  # the angle's differences are the better rate
    steady = moving & (np.abs(change) < STEADY)
    compared = steady if steady.sum() >= 2 * FEWEST_BLOCKS * BLOCK else moving
    return _independent_of(regressors[moving], missed[moving]) and _agreeing(
        missed, compared, of_angle, of_rate
    )


def _independent_of(regressors: np.ndarray, missed: np.ndarray) -> bool:
    """Whether the misses follow neither the rate, its change nor its bend, beyond the limits."""
    if len(missed) < BLOCK or not regressors.any(axis=0).all():
        return False
    size = np.sqrt((regressors**2).mean(axis=0))
    normal = np.linalg.pinv((regressors / size).T @ (regressors / size))
    slopes = normal @ ((regressors / size).T @ missed)
    u = np.sqrt(np.diag(normal)) * np.std(missed)
    return bool((np.abs(slopes) <= size * np.array([SCALE, LAG, ROUNDED]) + 3.0 * u).all())


def _agreeing(missed: np.ndarray, compared: np.ndarray, of_angle: float, of_rate: float) -> bool:
    """Whether block means of the misses are no larger than the noise of both makes them."""
    means = in_blocks(missed, BLOCK).mean(axis=1)[in_blocks(compared, BLOCK).all(axis=1)]
    if len(means) < FEWEST_BLOCKS:
        return False
    expected = (of_angle / BLOCK) ** 2 + of_rate**2 / BLOCK + NEGLIGIBLE**2
    return bool((means**2).mean() <= AGREEING**2 * expected)
