"""Noise and quantisation step of single samples, and the level of the unit's vibration."""

from dataclasses import replace

import numpy as np

from tasks.model.fit import plain_prediction
from tasks.motion.samples import NORMAL_QUANTILES
from tasks.motion.whole import Motion
from tasks.readings.lattice import quantiser_of

KEPT, MEAN_OF_KEPT = 0.98, 0.8734  # of the squares; their mean for standard normal ones
MAX_READINGS = 50_000  # that the output's step is read off
TIE = 1e-9
MIN_ROWS, MAX_ROWS = 30, 4000  # of a segment
DITHERED = 0.5  # of the readings differ from the one before: noise is larger than the step
AT_REST = 1e-3  # rad/s
STEADY = 0.02  # of the speed: a segment that scatters more is a ramp
EFFECTIVE_ROWS = 1.3  # samples of three axes: what their second differences are worth for each row
MIN_SPEEDS = 2  # that determine a power of the speed
EXPONENTS = np.round(np.arange(0.5, 6.01, 0.1), 1)  # of the vibration's power by the speed
WHOLE_BONUS = 4.0  # chi-squared
MAX_CHI2 = 3.0  # per segment


def noise_by_segment(
    readings: np.ndarray, motion: Motion, segment: np.ndarray, count: int
) -> np.ndarray:
    """(count + 1, 2) variance of a sample's noise in each segment, by triad; last: between them.

    segment: (n,) index of each row, −1 between them.

    From second differences, the largest left out, so that neither motion nor single bad samples
    count: of what a straight-line fit leaves, or of the readings themselves where that is less, as
    it is where the reference is noisier than the unit.
    """
    # Readings keep their noise where the motion is not known: there it is taken to be none.
    moved = motion.translation
    still = replace(
        motion,
        up=np.nan_to_num(motion.up),
        rate=np.nan_to_num(motion.rate),
        acceleration=np.nan_to_num(motion.acceleration),
        translation=None if moved is None else np.nan_to_num(moved),
    )
    left = readings - plain_prediction(readings, still, ~motion.felt, own_squared_rate=True)
    variances = [_by_segment(course, segment, count) for course in (left, readings)]
    return np.fmin(*variances)


def _by_segment(course: np.ndarray, segment: np.ndarray, count: int) -> np.ndarray:
    """(count + 1, 2) by the second differences of a course (n, 6)."""
    rough = np.full_like(course, np.nan)
    rough[1:-1] = np.diff(course, 2, axis=0) ** 2 / 6.0
    if np.bincount(segment + 1, minlength=count + 1)[1:].max(initial=0) < MIN_ROWS:
        return _together(rough, segment, count)
    variance = np.full((count + 1, 2), np.nan)
    for k in range(-1, count):
        rows = np.flatnonzero(segment == k)
        if len(rows) < MIN_ROWS:
            continue
        rows = rows[:: 1 + len(rows) // MAX_ROWS]
        for triad in range(2):
            part = rough[rows, 3 * triad : 3 * triad + 3]
            part = part[np.isfinite(part)]
            if len(part):
                # Quantised readings tie at the quantile, where rounding must not choose.
                part = part[part <= np.quantile(part, KEPT) * (1.0 + TIE)]
                variance[k, triad] = part.mean() / MEAN_OF_KEPT
    return variance


def _together(rough: np.ndarray, segment: np.ndarray, count: int) -> np.ndarray:
    """The same where no segment has enough rows: of all of them together, by the median."""
    inside = (segment >= 0) & (np.roll(segment, 1) == segment) & (np.roll(segment, -1) == segment)
    variance = np.full((count + 1, 2), np.nan)
    for triad in range(2):
        part = rough[inside, 3 * triad : 3 * triad + 3]
        part = part[np.isfinite(part)]
        if len(part) >= MIN_ROWS:
            variance[:count, triad] = np.median(part) / NORMAL_QUANTILES[0.5] ** 2
    return variance


def output_steps(readings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(6,) steps of the outputs, 0 if there are none, and whether the noise exceeds them."""
    steps, dithered = np.zeros(6), np.ones(6, bool)
    for channel, reading in enumerate(readings.T):
        known = reading[np.isfinite(reading)][:MAX_READINGS]
        quantiser = quantiser_of(known)
        if quantiser is not None:
            steps[channel] = quantiser.step
            dithered[channel] = np.mean(np.diff(known) != 0.0) > DITHERED
    return steps, dithered


def vibration(variance: np.ndarray, segment: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """(n,) mean square of the accelerometers' noise beyond that at rest, by the speed it has.

    variance: (segments + 1, 2); segment: (n,) index of each row; speed: (n,) rad/s. A power of
    the speed where one describes it, which has less noise than single segments; else between them.
    """
    known = [k for k in range(len(variance) - 1) if np.isfinite(variance[k, 1])]
    if not known:
        return np.zeros(len(segment))
    speeds = np.array([float(np.median(speed[segment == k])) for k in known])
    resting = speeds < AT_REST
    at_rest = float(np.median(variance[known, 1][resting if resting.any() else slice(None)]))
    steady = np.array([float(np.std(speed[segment == k])) for k in known]) < STEADY * speeds
    turning = ~resting & steady if (~resting & steady).any() else ~resting
    beyond = (variance[known, 1] - at_rest)[turning]
    rows = np.array([np.count_nonzero(segment == k) for k in known])[turning]
    u = variance[known, 1][turning] * np.sqrt(2.0 / (EFFECTIVE_ROWS * np.maximum(rows, 1)))
    law = _power_law(speeds[turning], beyond, u)
    if law is not None:
        return law[0] * speed ** law[1]
    order = np.argsort(speeds[turning])
    at, level = speeds[turning][order], np.maximum(beyond[order], 0.0)
    return np.interp(speed, np.append(0.0, at), np.append(0.0, level))


def _power_law(speeds: np.ndarray, beyond: np.ndarray, u: np.ndarray) -> tuple[float, float] | None:
    """Factor and exponent of c·speed^n; a whole n where it does as well. None: it is no power."""
    if len(np.unique(np.round(speeds, 2))) < MIN_SPEEDS or not (u > 0.0).all():
        return None
    powers = speeds[:, None] ** EXPONENTS / u[:, None]
    factors = (powers * (beyond / u)[:, None]).sum(axis=0) / (powers**2).sum(axis=0)
    cost = ((beyond / u)[:, None] - factors * powers) ** 2
    cost = np.where(factors > 0, cost.sum(axis=0), np.inf)
    whole = np.isclose(EXPONENTS, np.round(EXPONENTS))
    best = int(np.argmin(cost + WHOLE_BONUS * ~whole))
    if not cost[best] < MAX_CHI2 * len(speeds):
        return None
    return float(factors[best]), float(EXPONENTS[best])
