"""Signals at the unit's rows: readings, their noise, and what was recorded beside."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from schemas.recording import Recording, Segment
from tasks.model.fit import plain_prediction
from tasks.motion.pose import band_edge, derivative_gain, derivatives
from tasks.motion.samples import NORMAL_QUANTILES, bridged, noise_by_differences
from tasks.motion.whole import Motion
from tasks.readings.lattice import quantiser_of
from tasks.readings.robust import deviation

# Signals recorded beside the readings, interpolated to the unit's rows.

MEAN_WIDTH = 5.0  # s: a unit's temperature does not change faster
MIN_MEANS = 6
MAX_EXCESS = 1.3  # times what scatters from mean to mean
JUMP = 10.0  # times what a signal usually changes by from sample to sample
MIN_JUMP = 0.3  # of a signal's range
MAX_UNKNOWN = 0.02  # of the rows: a signal that jumps more often is interpolated
MAX_DEGREE = 60  # of the polynomial: cycles of a minute in a run of half an hour


def recorded_signals(
    recording: Recording, t: np.ndarray, segments: tuple[Segment, ...]
) -> dict[str, np.ndarray]:
    """What sensors of unit and room recorded, at the unit's rows, and which fixing it was."""
    recorded = {}
    if "temperature" in recording.imu.columns:
        recorded["temperature"] = recording.imu.columns["temperature"]
    if (room := recording.environment) is not None:
        for name, signal in room.columns.items():
            key = "air_temperature" if name == "temperature" else name
            recorded[key] = np.interp(t, room.t, signal)
    if "temperature" in recorded:
        filled = bridged(recorded["temperature"][:, None])[:, 0]
        recorded["temperature"], recorded["temperature_rate"] = _smoothed(t, filled)
    recorded["fixing"] = _fixings(recording, t, segments)
    recorded["steady_turn"] = np.zeros(len(t))
    for segment in segments:
        if segment.kind == "rate":
            recorded["steady_turn"][recording.imu.rows(segment.t_start, segment.t_end)] = 1.0
    return recorded


def within_jumps(recording: Recording, t: np.ndarray) -> np.ndarray:
    """(n,) bool: rows between two samples of a room's signal between which it jumps.

    The time of the jump is not known to the row, so no law of the signal can be tested on these
    readings: a jump of the unit itself, whose time is fitted, would always fit better.
    """
    unknown = np.zeros(len(t), bool)
    if (room := recording.environment) is None:
        return unknown
    for signal in room.columns.values():
        change = np.abs(np.diff(signal))
        if len(change) < MIN_MEANS or not np.isfinite(change).all():
            continue
        least = max(JUMP * float(np.quantile(change, 0.9)), MIN_JUMP * float(np.ptp(signal)))
        jumps = np.concatenate([[False], change > least, [False]])
        rows = jumps[np.searchsorted(room.t, t)]
        if rows.mean() < MAX_UNKNOWN:
            unknown |= rows
    return unknown


def _smoothed(t: np.ndarray, signal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A polynomial (n,) through means of MEAN_WIDTH seconds, and its derivative.

    Its degree has the least Bayesian information criterion: a body warms smoothly, and the noise
    of a thermometer would otherwise hide a bias that follows either. The signal stays as it was
    read where the polynomial leaves more than that noise.
    """
    cell = ((t - t[0]) / MEAN_WIDTH).astype(int)
    counts = np.bincount(cell)
    filled = counts > 0
    means = np.bincount(cell, signal)[filled] / counts[filled]
    if filled.sum() < MIN_MEANS or not np.ptp(means):
        return signal, np.zeros(len(t))
    middles = np.bincount(cell, t - t[0])[filled] / counts[filled]
    half = 0.5 * max(float(t[-1] - t[0]), MEAN_WIDTH)
    columns = chebyshev.chebvander(middles / half - 1.0, min(MAX_DEGREE, filled.sum() // 3))
    root = np.sqrt(counts[filled])
    basis, triangle = np.linalg.qr(columns * root[:, None])
    rotated = basis.T @ (means * root)
    missed = float((means**2 * counts[filled]).sum()) - np.cumsum(rotated**2)
    degrees = np.arange(len(rotated))
    rounding = 1e-12 * float((means**2 * counts[filled]).sum())
    criterion = filled.sum() * np.log(np.maximum(missed, rounding)) + degrees * np.log(filled.sum())
    best = int(criterion.argmin()) + 1
    coefficients = np.linalg.solve(triangle[:best, :best], rotated[:best])
    inside = np.clip(t - t[0], middles[0], middles[-1])  # beyond, a polynomial runs away
    at = inside / half - 1.0
    slope = np.asarray(chebyshev.chebval(at, chebyshev.chebder(coefficients)) / half)
    left = np.std(means - columns[:, :best] @ coefficients)
    scatter = deviation(np.diff(means, 2)) / np.sqrt(6.0)
    if left > MAX_EXCESS * scatter:
        return signal, slope
    return np.asarray(chebyshev.chebval(at, coefficients) + slope * (t - t[0] - inside)), slope


def _fixings(recording: Recording, t: np.ndarray, segments: tuple[Segment, ...]) -> np.ndarray:
    """Number of the fixing at each row: blocks of the procedure between which a unit is re-fixed.

    If segments have mounts of their own, a fixing ends where the mount changes. Otherwise the
    positions on a table of several axes are one fixing, and each upright axis of the rates is
    another; a unit is re-fixed right after the last segment of a block, before the move to the
    next.
    """
    manifest = recording.manifest
    mounted = [(segment, segment.mount or manifest.mount) for segment in segments]
    ends = [now.t_start for (_, before), (now, mount) in pairwise(mounted) if mount != before]
    if not any(end <= t[-1] for end in ends):
        several = len(manifest.station.table_axes or ()) > 1
        upright = [
            (segment, "positions" if several and segment.item == "twelve_position" else segment.up)
            for segment in segments if segment.up is not None
        ]  # fmt: skip
        ends = [last.t_end for (last, block), (_, then) in pairwise(upright) if block != then]
    return np.searchsorted(np.sort(ends), t, side="right").astype(float)


# Noise and quantisation step of single samples, and the level of the unit's vibration.

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


# Angular acceleration of a tracked body from its own gyros, where these are less noisy.
#
# The second derivative of an attitude shares its noise with the specific force that the same
# poses predict; as a regressor it invents lever arms. The first derivative of a gyro does not.

GAP = 1.5  # intervals between two rows that belong together
FEWEST = 50  # rows
EXPLAINED = 0.9  # of the gyros' power by the poses' rates, at least: else they are not the same
INDEPENDENT = 1e-2  # least ratio of two principal gains of the triad
WIDER = 3.0  # times the band of the poses, at most: beyond, nothing is compared
ORDER = 6  # of the differences that the gyros' noise is read off


def with_gyro_acceleration(motion: Motion, readings: np.ndarray) -> Motion:
    """The motion with the gyros' acceleration where it has less noise than the poses'.

    readings: (n, 6) rad/s and m/s². The gyros are first fitted to the poses' rates, so that scale
    factors and turned axes do not matter, nor does their bias.
    """
    tracking, gyro = motion.tracking, readings[:, :3]
    if tracking is None:
        return motion
    known = motion.felt[:, 0] & np.isfinite(gyro).all(axis=1)
    if known.sum() < FEWEST:
        return motion
    columns = np.column_stack([motion.rate, np.ones(len(gyro))])[known]
    fitted = np.linalg.lstsq(columns, gyro[known], rcond=None)[0]
    left = gyro[known] - columns @ fitted
    gains = np.linalg.svd(fitted[:3], compute_uv=False)
    power = ((gyro[known] - gyro[known].mean(axis=0)) ** 2).sum()
    if (left**2).sum() > (1.0 - EXPLAINED) * power or gains[-1] < INDEPENDENT * gains[0]:
        return motion
    inverse, spans = np.linalg.inv(fitted[:3]), _spans(motion, known)
    angles = [np.cumsum(gyro[rows], axis=0) * motion.interval for rows in spans]
    if not spans:
        return motion
    edge = min(band_edge(angles, motion.interval), WIDER * tracking.attitude)
    noise = noise_by_differences(gyro[known], ORDER, 0.5) * np.linalg.norm(inverse, 2)
    own = noise**2 * derivative_gain(1, edge, motion.interval)
    if own >= tracking.acceleration_variance:
        return motion
    acceleration = motion.acceleration.copy()
    for rows in spans:
        _, slope, _ = derivatives(gyro[rows], motion.interval, edge)
        acceleration[rows] = slope @ inverse
    return replace(motion, acceleration=acceleration)


def _spans(motion: Motion, known: np.ndarray) -> list[np.ndarray]:
    """Rows without a gap between them that are known."""
    breaks = (np.diff(motion.t) > GAP * motion.interval) | (known[1:] != known[:-1])
    parts = np.split(np.arange(len(known)), np.flatnonzero(breaks) + 1)
    return [rows for rows in parts if known[rows[0]] and len(rows) >= FEWEST]
