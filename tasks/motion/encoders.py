"""Angles that encoders recorded: their rates, their noise, and what smoothing leaves of both."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import comb

import numpy as np

from schemas.recording import ANGLE, GYRO, Recording, Stream
from tasks.motion.samples import (
    NORMAL_QUANTILES,
    SLOW,
    continuous,
    covered,
    in_blocks,
    interpolated,
    noise_by_differences,
    sample_interval,
)

# The rate of an encoder's angle, over as long a window as the motion at each sample permits.
#
# A window that is short enough for the ends of a ramp makes a coarse encoder's noise a hundred
# times larger than it need be at rests and held rates. So of polynomials fitted to longer and
# longer windows each sample takes the longest whose rate still agrees, within its noise, with
# those of all shorter ones (intersection of confidence intervals: Goldenshluger and Nemirovski,
# Math. Meth. Statist. 6, 1997), and then one half as long, whose bias is small beside its noise.
# A rest has the rate of all of it.

SIDE = 0.25  # s: means on both sides of a sample, whose difference shows a motion
SHORTEST_REST = 0.5  # s
AHEAD = 0.06  # s: means by which the end of a rest is found, and how far it stays before it
FEWEST_AHEAD = 3  # samples
MOVED, LEFT, SLOPING = 4.0, 2.5, 3.0  # standard deviations
SHAKING = 1.4  # times the noise: more is a motion
RATE_WINDOW = 0.05  # s: the shortest
LONGEST_HALF = 1.0  # s
FEWEST_HALF = 2  # samples on each side that a quartic needs
GROWTH, HALVED = np.sqrt(2.0), 2  # from window to window, and the windows that make one half
AGREEING = 3.0  # standard deviations
USUAL_WINDOWS = 3  # shortest windows over which a choice has to be usual
QUIET_RATE = 1e-4  # rad/s: noise of the shortest window that no longer one has to make smaller
ANGLE_ROUNDING = 1e-12  # rad: an angle that changes by less stands still


# Rests shown by a coarse encoder, each of which has one rate as a whole.
#
# A window about each sample is short beside the ends of a ramp, so that the encoder's noise makes
# rates there that nothing has; a unit that does not follow them seems to read small rates too small
# (attenuation by errors in the regressor; Fuller, Measurement Error Models, 1987). A rest is a
# stretch that a line of no slope fits, or of one by which it moves less than a sample's noise: that
# slope, by all of its samples, is the rate of each.


@dataclass(frozen=True)
class Rest:
    """Samples `first` to `last` (exclusive) of one angle; rate and its uncertainty u, rad/s."""

    first: int
    last: int
    rate: float
    u: float


@dataclass(frozen=True)
class EncoderRate:
    """Rate (n, k) rad/s of angles, and its variance.

    chosen: (n, k) which of the kernels; they are per sample, in symmetric order. interval: s.
    at_rest: (n, k) bool, the rate is that of a whole rest.
    """

    rate: np.ndarray
    variance: np.ndarray
    chosen: np.ndarray
    at_rest: np.ndarray
    kernels: tuple[np.ndarray, ...]
    interval: float

    def variance_of_mean(self, width: float) -> np.ndarray:
        """(n, k) of means over `width` s."""
        box = np.full(max(1, round(width / self.interval)), 1.0)
        gain = [
            (np.convolve(kernel, box / len(box)) ** 2).sum() / (kernel**2).sum()
            for kernel in self.kernels
        ]
        return np.asarray(self.variance * np.where(self.at_rest, 1.0, np.array(gain)[self.chosen]))


def encoder_rate(angle: np.ndarray, interval: float, variance: np.ndarray) -> EncoderRate:
    """Of angles (n, k) rad on an even grid, whose samples have variance (n, k) rad²."""
    from scipy.ndimage import median_filter, minimum_filter  # late: a quarter of a start

    kernels = _kernels(angle, interval, variance)
    rates, variances = [], []
    low, high = np.full(angle.shape, -np.inf), np.full(angle.shape, np.inf)
    chosen, agrees = np.zeros(angle.shape, int), np.ones(angle.shape, bool)
    row = np.arange(len(angle))[:, None]
    inside = np.minimum(row, row[::-1])  # samples to the nearer end
    for number, kernel in enumerate(kernels):
        rates.append(filtered(angle, kernel) / interval)
        variances.append(np.maximum(filtered(variance, kernel**2), 0.0) / interval**2)
        within = AGREEING * np.sqrt(variances[-1]) + ANGLE_ROUNDING / interval
        low, high = np.maximum(low, rates[-1] - within), np.minimum(high, rates[-1] + within)
        agrees &= (low <= high) & ((inside >= len(kernel) // 2) | (number == 0))
        chosen[agrees] = number
    # Chance ends a window at single samples, a corner of the motion at as many as it is long.
    chosen = median_filter(chosen, size=(USUAL_WINDOWS * (len(kernels[0]) // 2) * 2 + 1, 1))
    # Only where nothing ends the longest window all around is there no bias to keep small.
    unlimited = minimum_filter(chosen, size=(len(kernels[-1]) // 2, 1)) == len(kernels) - 1
    chosen = np.where(unlimited, chosen, np.maximum(chosen - HALVED, 0))
    rate, of_rate = (
        np.take_along_axis(np.array(every), chosen[None], axis=0)[0] for every in (rates, variances)
    )
    at_rest = np.zeros(angle.shape, bool)
    for k in range(angle.shape[1]) if len(kernels) > 1 else ():
        for rest in rests(angle[:, k], interval, variance[:, k]):
            rows = slice(rest.first, rest.last)
            rate[rows, k], of_rate[rows, k], at_rest[rows, k] = rest.rate, rest.u**2, True
    return EncoderRate(rate, of_rate, chosen, at_rest, kernels, interval)


def _kernels(angle: np.ndarray, interval: float, variance: np.ndarray) -> tuple[np.ndarray, ...]:
    """First derivatives of quartics, from the noisiest on; last the parabola, quieter by half."""
    half = half_window(RATE_WINDOW, interval, len(angle))
    if half < FEWEST_HALF:
        return (_slope(half, 2),)
    shortest = _slope(half, 4)
    noise = np.sqrt(variance.max(initial=0.0)) * np.linalg.norm(shortest) / interval
    if noise <= QUIET_RATE:
        return (shortest,)
    longest = min(LONGEST_HALF / interval, len(angle) / 8)
    count = 1 + max(0, int(np.log(longest / half) / np.log(GROWTH)))
    halves = np.unique(np.round(half * GROWTH ** np.arange(count)).astype(int)).tolist()
    return (*(_slope(each, 4) for each in halves), _slope(halves[-1], 2))


def _slope(half: int, degree: int) -> np.ndarray:
    place = np.arange(-half, half + 1.0) / half
    return np.asarray(np.linalg.pinv(np.vander(place, degree + 1, increasing=True))[1] / half)


def half_window(window: float, interval: float, count: int) -> int:
    """Samples on each side of one of `count`, for a window in s."""
    # Stamps are rounded: half a sample more or less must not depend on their last digit.
    wanted = round(0.5 * window / interval - 1e-6)
    return min(max(FEWEST_HALF, wanted), max(1, (count - 1) // 2))


def filtered(values: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """Correlation of each column with a kernel; the ends go on straight (odd reflection)."""
    half = len(kernel) // 2
    before = 2 * values[:1] - values[half:0:-1]
    after = 2 * values[-1:] - values[-2 : -half - 2 : -1]
    padded = np.concatenate([before, values, after])
    return np.column_stack([np.convolve(c, kernel[::-1], "valid") for c in padded.T])


def rests(angle: np.ndarray, interval: float, variance: np.ndarray) -> Iterator[Rest]:
    """The rests of one angle (n,) rad on an even grid, whose samples have variance (n,) rad²."""
    from scipy.ndimage import binary_erosion, uniform_filter1d  # late: see encoder_rate

    side = max(FEWEST_AHEAD, round(SIDE / interval))
    if len(angle) < 4 * side:
        return
    before, after = _means(angle, side)
    # A rest at the edge of a code flickers by more than codes err elsewhere.
    flicker = np.pad(np.diff(angle, 2) ** 2, 1) / 6.0
    noise = np.sqrt(np.maximum(variance, uniform_filter1d(flicker, 2 * side + 1)))
    still = np.abs(after - before) <= MOVED * noise * np.sqrt(2.0 / side)
    core = binary_erosion(still, np.ones(2 * side + 1))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], core, [False]]).astype(int)))
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if (last - first) * interval >= SHORTEST_REST:
            rest = _rest(angle, interval, noise, first, last)
            if rest is not None:
                yield rest


def _means(angle: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray]:
    """(n,) of `side` samples before each one, and from it on; NaN where there are fewer."""
    total = np.concatenate([[0.0], np.cumsum(angle - angle[0])])
    means = (total[side:] - total[:-side]) / side
    missing = np.full(side, np.nan)
    before = np.concatenate([missing, means])[: len(angle)]
    return before, np.concatenate([means, missing])[: len(angle)]


def _rest(
    angle: np.ndarray, interval: float, noise: np.ndarray, first: int, last: int
) -> Rest | None:
    """The rest around samples that stand still; None where they follow a slope, shake, or are too
    few to show it.
    """
    count = last - first
    if count < 2:  # of an encoder that is read slowly: one sample shows no slope
        return None
    place = np.arange(count) - 0.5 * (count - 1)
    spread = float((place**2).sum())
    slope = float(place @ angle[first:last]) / spread
    usual = float(np.sqrt((noise[first:last] ** 2).mean()))
    u = usual / spread**0.5
    scatter = float(np.std(angle[first:last] - slope * place))
    if abs(slope) > max(SLOPING * u, usual / count) or scatter > SHAKING * usual:
        return None
    near = 3 * max(FEWEST_AHEAD, round(SIDE / interval))  # more than what the core is short of
    start, end = max(0, first - near), min(len(angle), last + near)
    line = slope * (np.arange(start, end) - first - place[-1]) + angle[first:last].mean()
    off, own_noise = angle[start:end] - line, noise[start:end]
    ahead = max(FEWEST_AHEAD, round(AHEAD / interval))
    forward = _reach(off[last - start :], own_noise[last - start :], ahead)
    back = _reach(off[: first - start][::-1], own_noise[: first - start][::-1], ahead)
    if first - back >= last + forward:
        return None
    return Rest(first - back, last + forward, slope / interval, u / interval)


def _reach(off: np.ndarray, noise: np.ndarray, ahead: int) -> int:
    """How many samples go on as the rest did, until the motion that then shows began.

    off, noise: (m,) rad, distance of the samples from the rest and its standard deviation. What
    begins to turn is four times as far off when twice the time has passed: so it began as long
    before it showed as it then took to be four times as far off, or later. May be negative.
    """
    if len(off) < ahead:
        return 0
    means = np.abs(np.convolve(off, np.ones(ahead) / ahead, "valid"))
    limit = LEFT * noise[: len(means)] / np.sqrt(ahead)
    gone, far = means > limit, means > 4.0 * limit
    turned = int(far.argmax()) if far.any() else len(far)
    shown = turned - int(np.append(~gone[:turned][::-1], True).argmax())  # not what shows by chance
    if shown == len(far):
        return len(off)
    return 2 * shown - turned - 1 if far.any() else shown - 1


# Noise of encoder angles, estimated from the angles themselves.
#
# Noise, steps and the scatter of stamps show in the twelfth differences of the angle, stretch by
# stretch, so that an axis that rests is exact and one that turns is as good as its encoder; a
# corner of the motion is rare among them and does not count. A stretch with one step is no better
# than the step, and scatter of the stamps counts by the rate. All are white from sample to
# sample.

NODE = 64  # samples that a noise is read off
SPEED_SAMPLES = 8  # samples over which a speed is averaged
ANGLE_NOISE_ORDER = 12  # of the differences: what servos do at some hertz must not count as noise
DIFFERENCE = float(
    np.sqrt(comb(2 * ANGLE_NOISE_ORDER, ANGLE_NOISE_ORDER))
)  # what they make of white noise
WHOLE_STEPS, MOSTLY = 0.1, 0.9  # steps: changes mostly whole within this are quantised
QUIETEST, LIKE = 0.25, 1.5  # quantile of stretches, and times its noise: as quiet
FEW_STEPS = 20.0  # more are whole within rounding whatever they are


def angle_variance(stamps: np.ndarray, angles: np.ndarray, even: np.ndarray) -> np.ndarray:
    """Variance (n, k) rad² of angles `even` (n, k) rad, resampled evenly from those that were read.

    stamps: (m,) s, angles: (m, k) rad as read; too few to estimate from count as exact.
    """
    if len(even) < NODE + ANGLE_NOISE_ORDER:
        return np.zeros_like(even)
    changes = np.diff(even, axis=0, prepend=even[:1])
    size = _size(even)
    if len(angles) != len(even) or (angles != even).any():
        # Interpolation smooths neighbours, and the differences of those no longer show all of it.
        least = _least(angles) * np.sqrt(len(even) / len(angles))
        size = np.where(size > ANGLE_ROUNDING, np.maximum(size, least), 0.0)
    size = _by_stretch(size, len(even))
    moved = in_blocks(np.abs(changes[ANGLE_NOISE_ORDER:]), NODE) > ANGLE_ROUNDING
    steps = encoder_steps(angles)
    # A single change tells its place to within one step: the rate there is as uncertain as any.
    coarse = _by_stretch(moved.any(axis=1) * steps**2 / 12.0, len(even))
    variance = np.maximum(size**2, coarse)
    if (size.mean(axis=0) > _size(angles).mean(axis=0)).any():
        # The samples are even and their stamps are not: interpolation hides most of it.
        jitter = noise_by_differences(stamps, 2, 0.5) * np.sqrt(len(even) / len(angles))
        jitter *= len(even) / np.ptp(stamps)
        near = np.full(SPEED_SAMPLES, 1.0 / SPEED_SAMPLES)
        moves = np.column_stack([np.convolve(one, near, "same") for one in changes.T])
        variance = np.maximum(variance, (moves * jitter) ** 2)
    return variance


def _least(angles: np.ndarray) -> np.ndarray:
    """(k,) noise rad of angles as read in the stretches where least moves; 0 where none has any."""
    noisy = [own[own > ANGLE_ROUNDING] for own in _size(angles).T]
    return np.array([
        np.median(own[own <= LIKE * np.quantile(own, QUIETEST)]) if len(own) else 0.0
        for own in noisy
    ])  # fmt: skip


def _by_stretch(values: np.ndarray, count: int) -> np.ndarray:
    """Values (m, k) of stretches at each of `count` samples."""
    middles = ANGLE_NOISE_ORDER // 2 + NODE * (np.arange(len(values)) + 0.5)
    nearest = np.clip(np.round((np.arange(count) - middles[0]) / NODE), 0, len(values) - 1)
    return np.asarray(values[nearest.astype(int)])


def _size(angles: np.ndarray) -> np.ndarray:
    """Standard deviation (m, k) rad of the white noise of angles (n, k) in each stretch."""
    rough = in_blocks(np.abs(np.diff(angles, ANGLE_NOISE_ORDER, axis=0)), NODE)
    return np.asarray(np.median(rough, axis=1) / NORMAL_QUANTILES[0.5] / DIFFERENCE)


def encoder_steps(angles: np.ndarray) -> np.ndarray:
    """(k,) rad, steps of encoders that read angles (n, k); 0 where changes are not whole steps."""
    return np.array([_step(course) for course in np.abs(np.diff(angles, axis=0)).T])


def _step(changes: np.ndarray) -> float:
    moved = changes[changes > ANGLE_ROUNDING]
    if not len(moved):
        return 0.0
    least = float(np.quantile(moved, 0.01))
    few = moved[moved < FEW_STEPS * least] / least
    whole = np.abs(few - np.round(few)) < WHOLE_STEPS
    return least if whole.mean() > MOSTLY else 0.0


# Rates of an AHRS that outputs angles only: the angle gained in each interval, over its time.
#
# The angle about each axis of the unit is the integral of what its gyro feels, so that its
# increment is the mean rate between two readings, whatever the rate did in between. White noise
# of the rate stays white; the rounding of an angle is shared by two neighbours with opposite
# signs, so that the differences noise is read off show it as larger than it is in any mean.

UNEVEN_STEP = 0.5  # of an interval: a step that differs by more is not one of them
HALF_TURN = np.pi  # rad: a larger increment is a restart, a wrap or more than can be told


def gives_angles(recording: Recording) -> bool:
    """Whether angles are all that the unit says of its turning."""
    columns = set(recording.imu.columns)
    return set(ANGLE) <= columns and not set(GYRO) & columns


def as_mean_rates(recording: Recording) -> Recording:
    """The recording with gyro_* (rad/s) in place of angles, one row in the middle of each interval.

    Other columns are the mean of both ends. NaN where samples were lost between two readings and
    where an angle was reset. A recording with rates is returned unchanged.
    """
    imu = recording.imu
    if not gives_angles(recording) or len(imu) < 2:
        return recording
    span, steps = sample_interval(imu.t), np.diff(imu.t)
    gained = np.diff(imu.stack(ANGLE), axis=0)
    whole = (np.abs(steps - span) < UNEVEN_STEP * span) & (np.abs(gained) < HALF_TURN).all(axis=1)
    rates = np.where(whole[:, None], gained / steps[:, None], np.nan)
    columns = {
        name: np.where(whole, 0.5 * (values[1:] + values[:-1]), np.nan)
        for name, values in imu.columns.items()
        if name not in ANGLE
    }
    columns |= dict(zip(GYRO, rates.T, strict=True))
    return replace(recording, imu=Stream(0.5 * (imu.t[1:] + imu.t[:-1]), columns, span))


# Rate and acceleration from an encoder's quantised and noisy angle.
#
# Each derivative is that of a polynomial fitted by least squares to the samples around it
# (Savitzky and Golay, Anal. Chem. 36, 1964). A parabola's rate is the quietest, but it rounds off
# ramps and damps oscillations, by a third at 13 Hz; a quartic does not, where the encoder is
# quiet enough for it, or where what a parabola would lose is more than a quartic's noise. Encoder
# noise σ becomes σ·√720/(T²·√n) in the second derivative, which drowns a lever arm at full
# bandwidth; a window that is too long rounds off the ramps and makes the lever arm too large. So
# the window is as long as the encoder's own noise asks for.

QUIET_ACCELERATION = 0.01  # rad/s²: noise of the second derivative that a window must reach
LONGEST_WINDOW = 0.5  # s
FINEST = 200.0  # Hz: samples nearer to each other are averaged first
FEWEST_SAMPLES = 3  # samples that have derivatives
BETWEEN = 2  # samples on each side of a time that its value is drawn through
ENCODER_NOISE_ORDER = 6  # of the differences that the encoder's noise is read off
QUIET_DIFFERENCES = 5.0  # standard deviations that noise makes of differences
UNRESOLVED = 3e-4  # rad/s by which a rate may be wrong that slow samples make
ROUNDED = 1e-9  # rad/s, rad/s²: less is arithmetic
ON_GRID = 1e-3  # of the interval
UNEVEN_STAMPS = 0.01  # of the interval: stamps that differ by more are put on an even grid


@dataclass(frozen=True)
class SmoothCourse:
    """Angles (n, k) rad read at t (n,) s, and what is made of them on an even grid.

    t: three or more, rising. angle: continuous (no jumps of a whole turn). even: (m,) s. thinned:
    (m, k) rad, the angles there.
    """

    t: np.ndarray
    angle: np.ndarray
    even: np.ndarray
    thinned: np.ndarray

    @classmethod
    def of(cls, t: np.ndarray, angle: np.ndarray) -> "SmoothCourse":
        """Of angles (n, k) rad read at t (n,) s, put on the grid."""
        return cls(t, angle, *even_grid(t, angle))

    @cached_property
    def interval(self) -> float:
        """Of the grid, s."""
        return float(self.even[1] - self.even[0])

    @cached_property
    def variance(self) -> np.ndarray:
        """(m, k) rad² of an angle on the grid."""
        return angle_variance(self.t, self.angle, self.thinned)

    @cached_property
    def slope(self) -> EncoderRate:
        """The angles' rate."""
        return encoder_rate(self.thinned, self.interval, self.variance)

    @cached_property
    def half(self) -> int:
        """Samples on each side that an acceleration takes."""
        # Jerks are fewer than a tenth of the differences.
        noise = noise_by_differences(self.thinned, ENCODER_NOISE_ORDER, 0.9)
        quiet = float((np.sqrt(720.0 * self.interval) * noise / QUIET_ACCELERATION) ** 0.4)
        return half_window(min(quiet, LONGEST_WINDOW), self.interval, len(self.even))

    @cached_property
    def acceleration(self) -> np.ndarray:
        """(m, k) rad/s²."""
        return filtered(self.thinned, _bend_kernel(self.half) / self.interval**2)

    def shows(self, at: np.ndarray) -> np.ndarray:
        """(m, k) bool: samples show the motion about the times `at` (m,) s, up to their noise.

        The rate of a quartic through five errs by a thirtieth of their fifth difference: by how the
        fourth ones, beside each other, differ where a table accelerates between slow samples.
        """
        from scipy.ndimage import minimum_filter  # late: see encoder_rate

        count, axes = self.thinned.shape
        known = np.ones((count, axes), bool)
        if self.interval < SLOW or count < 2 * FEWEST_SAMPLES:
            return np.ones((len(at), axes), bool)
        missed = np.abs(np.diff(self.thinned, 4, axis=0)) / (30.0 * self.interval)
        noise = QUIET_DIFFERENCES * np.quantile(missed, 0.1, axis=0) / NORMAL_QUANTILES[0.1]
        known[2:-2] = missed < np.maximum(UNRESOLVED, noise)
        known = minimum_filter(known, size=(3, 1))
        between = minimum_filter(known, size=(3, 1))  # what a cubic is drawn through
        place = (at - self.even[0]) / self.interval
        on_grid = (np.abs(place - np.round(place)) < ON_GRID)[:, None]
        nearest = np.clip(np.round(place).astype(int), 0, len(known) - 1)
        drawn = interpolated(at, self.even, between.astype(float)) == 1.0
        return np.asarray(np.where(on_grid, known[nearest], drawn))

    @cached_property
    def _slopes(self) -> tuple[np.ndarray, np.ndarray]:
        """Of rate and acceleration (m, k) on the grid, by their neighbours."""
        rate, acceleration = (
            np.gradient(each, self.even, axis=0) for each in (self.slope.rate, self.acceleration)
        )
        return rate, acceleration

    def angles_at(self, at: np.ndarray) -> np.ndarray:
        """Angles (m, k) at the times `at` (m,) s, NaN in gaps of the samples."""
        angles = interpolated(at, self.t, self.angle)
        return np.where(covered(self.t, at)[:, None], angles, np.nan)

    def at(self, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As `smooth_derivatives`."""
        shortest = len(self.slope.kernels[0]) // 2
        shown = self.shows(at)
        rates, accelerations = (
            np.where(
                shown & covered(self.t, at, (reach + BETWEEN) * self.slope.interval)[:, None],
                _between(at, self.even, derivative, slopes),
                np.nan,
            )
            for reach, derivative, slopes in (
                (shortest, self.slope.rate, self._slopes[0]),
                (self.half, self.acceleration, self._slopes[1]),
            )
        )
        if self.interval >= SLOW:  # rests alone may be left, whose rounding a fit would scale up
            rates = np.where(np.abs(rates) < ROUNDED, 0.0, rates)
            accelerations = np.where(np.abs(accelerations) < ROUNDED, 0.0, accelerations)
        return self.angles_at(at), rates, accelerations


def smooth_derivatives(
    t: np.ndarray, angle: np.ndarray, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angle, rate and acceleration (m, k) at the times `at` (m,) s.

    t: (n,) s, rising; angle: (n, k), continuous (no jumps of a whole turn). NaN in gaps of the
    samples, before the first and after the last, and where fewer than three have no derivative;
    a derivative is NaN, too, where a line drawn over a gap would be part of it.
    """
    if len(t) < FEWEST_SAMPLES:
        return (np.full((len(at), angle.shape[1]), np.nan),) * 3
    return SmoothCourse.of(t, angle).at(at)


@lru_cache(maxsize=2)  # a recording's motion is asked for again and again, at other times
def smooth_course(table: Stream, names: tuple[str, ...]) -> SmoothCourse | None:
    """Of a table's named angles, made continuous; None of fewer samples than have derivatives."""
    angles = continuous(table, names)
    return SmoothCourse.of(table.t, angles) if len(table) >= FEWEST_SAMPLES else None


def _between(at: np.ndarray, t: np.ndarray, values: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Values (n, k) at times t (n,) by cubics through four: a straight line would lose
    ω²x(h − x)/2 of an oscillation at x of an interval h, as no unit does.

    slopes: (n, k) at t. By hand (Hermite's form), because scipy takes a tenth of a start and works
    out every interval where few are asked for.
    """
    inside = np.clip(at, t[0], t[-1])
    left = np.clip(np.searchsorted(t, inside, "right") - 1, 0, len(t) - 2)
    width = (t[left + 1] - t[left])[:, None]
    x = (inside - t[left])[:, None] / width
    rise = values[left + 1] - values[left]
    start, end = width * slopes[left], width * slopes[left + 1]
    bend = (1.0 - x) * (start - rise) + x * (rise - end)
    return np.asarray(values[left] + x * (rise + (1.0 - x) * bend))


def _bend_kernel(half: int) -> np.ndarray:
    """Second derivative of the fitted parabola, per sample squared."""
    j = np.arange(-half, half + 1.0)
    centred = j**2 - (j**2).mean()
    return 2.0 * centred / (centred**2).sum()


def even_grid(t: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The samples at even times, no more than FINEST a second."""
    steps = np.diff(t)
    interval = float(np.median(steps))  # a lost sample is a long step, not another rate
    if np.abs(steps - interval).max() > UNEVEN_STAMPS * interval:
        even = np.arange(t[0], t[-1] + 0.5 * interval, interval)
        t, angle = even, interpolated(even, t, angle)
    group = min(int(1.0 / (FINEST * interval) + 1e-6), len(t) // 5)
    if group < 2:
        return t, angle
    return in_blocks(t, group).mean(axis=1), in_blocks(angle, group).mean(axis=1)


# What smoothing the angles of encoders takes from their acceleration.
#
# A window as long as a coarse encoder needs rounds off the ramps of a table, and what follows the
# angular acceleration, as a lever arm does, is found too large by as much. How much it takes, the
# smoothed acceleration tells when it is smoothed again.


def lost_acceleration(recording: Recording, t: np.ndarray) -> np.ndarray:
    """(n, k) rad/s² that a second smoothing takes from the accelerations of a table's k axes.

    t: (n,) s of the recording. Zero where nothing is known.
    """
    axes = recording.manifest.station.table_axes or ()
    table = recording.table
    course = table and smooth_course(table, tuple(f"{axis.name}_angle" for axis in axes))
    if not course:
        return np.zeros((len(t), len(axes)))
    lost = course.acceleration - filtered(course.acceleration, _mean_kernel(course.half))
    return np.column_stack([np.interp(t, course.even, column) for column in lost.T])


def _mean_kernel(half: int) -> np.ndarray:
    """The weighted mean (2·half − 1,) of second differences that a fitted parabola's bend is."""
    j = np.arange(-half, half + 1.0)
    centred = j**2 - (j**2).mean()
    bend = 2.0 * centred / (centred**2).sum()
    return np.cumsum(np.cumsum(bend))[: 2 * half - 1]
