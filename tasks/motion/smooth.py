"""Rate and acceleration from an encoder's quantised and noisy angle.

Each derivative is that of a polynomial fitted by least squares to the samples around it (Savitzky
and Golay, Anal. Chem. 36, 1964). A parabola's rate is the quietest, but it rounds off ramps and
damps oscillations, by a third at 13 Hz; a quartic does not, where the encoder is quiet enough for
it, or where what a parabola would lose is more than a quartic's noise. Encoder noise σ becomes
σ·√720/(T²·√n) in the second derivative, which drowns a lever arm at full bandwidth; a window that
is too long rounds off the ramps and makes the lever arm too large. So the window is as long as
the encoder's own noise asks for.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from schemas.recording import Stream
from tasks.motion.angle_noise import angle_variance
from tasks.motion.encoder_rate import EncoderRate, encoder_rate, filtered, half_window
from tasks.motion.samples import (
    NORMAL_QUANTILES,
    SLOW,
    continuous,
    covered,
    in_blocks,
    interpolated,
    noise_by_differences,
)

QUIET_ACCELERATION = 0.01  # rad/s²: noise of the second derivative that a window must reach
LONGEST_WINDOW = 0.5  # s
FINEST = 200.0  # Hz: samples nearer to each other are averaged first
FEWEST = 3  # samples that have derivatives
BETWEEN = 2  # samples on each side of a time that its value is drawn through
ORDER = 6  # of the differences that the encoder's noise is read off
QUIET_DIFFERENCES = 5.0  # standard deviations that noise makes of differences
UNRESOLVED = 3e-4  # rad/s by which a rate may be wrong that slow samples make
ROUNDED = 1e-9  # rad/s, rad/s²: less is arithmetic
ON_GRID = 1e-3  # of the interval
UNEVEN = 0.01  # of the interval: stamps that differ by more are put on an even grid


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
        noise = noise_by_differences(self.thinned, ORDER, 0.9)
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
        if self.interval < SLOW or count < 2 * FEWEST:
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
    if len(t) < FEWEST:
        return (np.full((len(at), angle.shape[1]), np.nan),) * 3
    return SmoothCourse.of(t, angle).at(at)


@lru_cache(maxsize=2)  # a recording's motion is asked for again and again, at other times
def smooth_course(table: Stream, names: tuple[str, ...]) -> SmoothCourse | None:
    """Of a table's named angles, made continuous; None of fewer samples than have derivatives."""
    angles = continuous(table, names)
    return SmoothCourse.of(table.t, angles) if len(table) >= FEWEST else None


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
    if np.abs(steps - interval).max() > UNEVEN * interval:
        even = np.arange(t[0], t[-1] + 0.5 * interval, interval)
        t, angle = even, interpolated(even, t, angle)
    group = min(int(1.0 / (FINEST * interval) + 1e-6), len(t) // 5)
    if group < 2:
        return t, angle
    return in_blocks(t, group).mean(axis=1), in_blocks(angle, group).mean(axis=1)
