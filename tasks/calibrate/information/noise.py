"""Noise of each channel over the longest rests: random walk and bias instability.

Source: IEEE Std 952, annex C: the random walk coefficient N is the Allan deviation of the white
part at 1 s; the bias instability is the minimum of the Allan deviation over √(2·ln 2/π) = 0.664.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.calibration import Information
from schemas.recording import AXES
from tasks.calibrate.information.entry import entry, of_axes, student_k, unit_and_table
from tasks.segments.summarise import (
    ACCEL_COLUMNS,
    CHANNELS,
    GYRO_COLUMNS,
    SegmentMean,
    coarsely_quantised,
)
from tasks.specifications.estimate import DEG
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import Message, message
from tasks.words.numbers import USUAL_K

# Overlapping Allan variance of rests, its noise components, and their uncertainty.
#
# Source: IEEE Std 952, annex C (shapes of the noise terms); NIST SP 1065, 5.2.4 and 5.4
# (overlapping Allan variance and its equivalent degrees of freedom). By hand, because importing
# allantools takes longer than the whole calibration of a million rows; the tests compare with it.

FLICKER = 2.0 * np.log(2.0)  # Allan variance of S(f) = 1/f
SHARPEST = 0.02  # of a variance: no noise follows the textbook's shapes more closely
STARTS = 8  # averages begun within one averaging time
PIECE, FINE = 1 << 14, 64  # rows taken at once, of averages over at most so many rows
MIN_LEVELS = 5  # averaging times that separate the noise terms
ROUNDS = 4  # of weighting by the model fitted before
MISFIT = 1.5  # mean squared deviation, in what is known of each level, above which a fit is refused
FAINTEST = 0.01  # of a variance: what is expected of a level is never less
WHITE = 1  # place of the white noise among the terms


@dataclass(frozen=True)
class AllanCurve:
    """Allan variances over all rests together.

    tau: (levels,) s, doubling. variance: (levels, channels). white_dof, flicker_dof: (levels,)
    equivalent degrees of freedom where white noise or flicker rules.
    """

    tau: np.ndarray
    variance: np.ndarray
    white_dof: np.ndarray
    flicker_dof: np.ndarray


@dataclass(frozen=True)
class WhiteNoise:
    """N² (unit²·s) of white noise and its standard uncertainty."""

    density: float
    u: float


def overlapping_variances(readings: Sequence[np.ndarray], sizes: Sequence[int]) -> np.ndarray:
    """Overlapping Allan variances (sizes, channels) of readings (n,) of each channel.

    sizes: rows averaged over, each a multiple of the one before, 2·size ≤ n. Multiples of STARTS
    begin an average at every (size/STARTS)-th row only: what those between would add is nearly
    nothing.
    """
    count, fine = len(readings[0]), [size for size in sizes if size <= FINE]
    last = fine[-1] if fine else 1
    piece = PIECE // last * last
    squares, sums = np.zeros((len(sizes), len(readings))), []
    for channel, values in enumerate(readings):
        parts = []
        for first in range(0, count, piece):  # which stays in the processor's cache
            rows = values[first : first + piece + 2 * last] - values[0]
            of_piece, part = _squares(rows, 1, fine, piece)
            squares[: len(fine), channel] += of_piece
            parts.append(part[: piece // _stride(last)])
        sums.append(np.concatenate(parts))
    squares[len(fine) :] = _squares(np.array(sums), last, sizes[len(fine) :], count)[0]
    compared = [(count - 2 * size) // _stride(size) + 1 for size in sizes]
    return np.asarray(squares / (2.0 * np.array(sizes) ** 2 * compared)[:, None])


def _stride(size: int) -> int:
    """Rows from the beginning of one average over `size` rows to the next one's."""
    return 1 if size % STARTS else size // STARTS


def _squares(
    sums: np.ndarray, of: int, sizes: Sequence[int], starts: int
) -> tuple[np.ndarray, np.ndarray]:
    """Sums (sizes, …) of the squares that neighbouring sums over `size` rows differ by.

    sums: (…, n) over `of` rows each; only rows before `starts` begin a pair. Also returns the sums
    over the last size.
    """
    squares, begun = [], _stride(of)
    for size in sizes:
        stride = _stride(size)
        sums = _sums_of(sums, size // of, of // begun, stride // begun)
        of, begun, neighbour = size, stride, size // stride
        apart = (sums[..., neighbour:] - sums[..., :-neighbour])[..., : starts // stride]
        squares.append(np.vecdot(apart, apart))
    return np.array(squares).reshape(len(sizes), *sums.shape[:-1]), sums


def _sums_of(values: np.ndarray, count: int, apart: int, stride: int) -> np.ndarray:
    """Sums of `count` values (…, n) that lie `apart` places from each other, from every
    stride-th one on.
    """
    length = values.shape[-1] - (count - 1) * apart
    sums = values[..., :length:stride]
    for first in range(apart, count * apart, apart):
        sums = sums + values[..., first : first + length : stride]
    return sums


def allan_curve(rests: Sequence[Sequence[np.ndarray]], interval: float) -> AllanCurve:
    """The Allan variances of rests sampled every `interval` s, weighted by length.

    rests: of each its channels (n,). Averaging times go up to a quarter of the shortest rest; none
    where it has fewer than 4 rows.
    """
    shortest = min(len(rest[0]) for rest in rests)
    sizes = [1 << power for power in range(shortest.bit_length()) if 4 << power <= shortest]
    rows = [len(rest[0]) for rest in rests]
    variances = [overlapping_variances(rest, sizes) for rest in rests]
    alike = Counter(rows).items()  # rests are mostly of one length
    return AllanCurve(
        tau=interval * np.array(sizes, float),
        variance=np.average(variances, axis=0, weights=rows),
        white_dof=np.array([sum(k * white_dof(n, size) for n, k in alike) for size in sizes]),
        flicker_dof=np.array([sum(k * flicker_dof(n, size) for n, k in alike) for size in sizes]),
    )


def white_dof(count: int, size: int) -> float:
    """Equivalent degrees of freedom of white noise, `count` readings averaged over `size`."""
    points = count + 1
    return (1.5 * (points - 1) / size - 2.0 * (points - 2) / points) * (
        4.0 * size**2 / (4.0 * size**2 + 5.0)
    )


def flicker_dof(count: int, size: int) -> float:
    """Equivalent degrees of freedom of flicker, `count` readings averaged over `size`."""
    points = count + 1
    if size == 1:
        return 2.0 * (points - 2) ** 2 / (2.3 * points - 4.9)
    return 5.0 * points**2 / (4.0 * size * (points + 3.0 * size))


def white_noise(curve: AllanCurve, channel: int) -> WhiteNoise | None:
    """White noise of one channel, by its shape beside angle noise, flicker and random walk.

    The shortest averaging times, where the unit's low-pass rules or a line of the mains, are left
    off until the shapes fit. None where too few are left, or where white noise does not show.
    """
    if not curve.variance[:, channel].all():
        return None
    for first in range(len(curve.tau) - MIN_LEVELS + 1):
        tau, variance = curve.tau[first:], curve.variance[first:, channel]
        known = np.sqrt(2.0 / curve.white_dof[first:] + SHARPEST**2)
        density, u, misfit = _fit(tau, variance, known)
        if misfit < MISFIT:
            shows = density > 2.0 * u > 0.0
            return WhiteNoise(density, u) if shows else None
    return None


def _fit(tau: np.ndarray, variance: np.ndarray, known: np.ndarray) -> tuple[float, float, float]:
    """N², its standard uncertainty and the mean squared misfit.

    known: relative standard uncertainty of each variance. No term is negative but the first: to
    first order, a low-pass takes from white noise what angle noise of that size would add.
    """
    shapes = np.column_stack([3.0 / tau**2, 1.0 / tau, np.full(len(tau), FLICKER), tau / 3.0])
    expected, terms = variance, np.zeros(shapes.shape[1])
    used = list(range(shapes.shape[1]))
    for _ in range(ROUNDS):
        weight = 1.0 / (known * expected)
        used = list(range(shapes.shape[1]))
        while True:  # a negative term is no noise: without it, again
            design = shapes[:, used] * weight[:, None]
            scale = np.linalg.norm(design, axis=0)
            strength = np.linalg.lstsq(design / scale, variance * weight, rcond=None)[0]
            if strength[1:].min(initial=0.0) >= 0.0:
                break
            used.pop(1 + int(strength[1:].argmin()))
        terms = np.zeros(shapes.shape[1])
        terms[used] = strength / scale
        expected = np.maximum(shapes @ terms, FAINTEST * variance)
    misfit = float(np.mean(((variance - expected) / (known * expected)) ** 2))
    if WHITE not in used:
        return 0.0, 0.0, misfit
    place = used.index(WHITE)
    spread = np.linalg.pinv((design / scale).T @ (design / scale))[place, place]
    return float(terms[WHITE]), float(np.sqrt(spread) / scale[place]), misfit


FLOOR = float(np.sqrt(2.0 * np.log(2.0) / np.pi))  # 0.664
AS_LONG = 0.9  # of the longest rest: rests as long as it is
GAP = 1.5  # sampling intervals: a longer step is a lost row
FALLING = 2.5  # times the minimum at a quarter of its averaging time: white noise makes half of it
SQRT_HOUR = 60.0  # √(3600 s)
HOUR = 3600.0


Quantity = tuple[str, str, float]  # key in the result, printed unit, factor from SI


@dataclass(frozen=True)
class AllanOfRests:
    """The Allan variances of a triad over its longest rests, SI.

    hidden: which channels (3,) have a step that hides their noise. count, seconds: how many rests,
    and how long the shortest of them is.
    """

    curve: AllanCurve
    hidden: np.ndarray
    count: int
    seconds: float


def noise_information(evidence: ClauseEvidence, rate_sensor: str) -> dict[str, Information]:
    """Random walk and bias instability of each triad that the recording has."""
    made = _of_triad(
        evidence,
        GYRO_COLUMNS,
        (f"{rate_sensor}_angle_random_walk", "deg/sqrt(h)", DEG * SQRT_HOUR),
        (f"{rate_sensor}_bias_instability", "deg/h", DEG * HOUR),
    )
    if rate_sensor == "gyro":
        made |= _of_triad(
            evidence,
            ACCEL_COLUMNS,
            ("accel_velocity_random_walk", "(m/s2)/sqrt(Hz)", 1.0),
            ("accel_bias_instability", "m/s2", 1.0),
        )
    return made


def _of_triad(
    evidence: ClauseEvidence, triad: slice, walk: Quantity, instability: Quantity
) -> dict[str, Information]:
    """Both quantities of three channels; none without a whole rest."""
    allan = allan_of_rests(evidence, triad)
    if allan is None:
        return {}
    curve, hidden = allan.curve, allan.hidden
    white, floor = np.full((2, 3), np.nan), np.full((4, 3), np.nan)
    if len(curve.tau) >= MIN_LEVELS:
        for i in np.flatnonzero(~hidden).tolist():
            white[:, i], floor[:, i] = _random_walk(curve, i), _bias_instability(curve, i)
    source = message("information-rests", count=allan.count, seconds=f"{allan.seconds:.0f}")
    coarse = of_axes("information-noise-hidden", _axes(hidden))
    averaged = [f"{AXES[i]} {floor[2, i]:.3g} s" for i in np.flatnonzero(np.isfinite(floor[2]))]
    longest = f"{curve.tau.max(initial=0.0):.3g}"
    return {
        walk[0]: _entry(
            walk,
            white,
            USUAL_K,
            message("information-random-walk", source=source),
            *unit_and_table(white[0]),
            *coarse,
            *of_axes("information-no-white-noise", _axes(np.isnan(white[0]) & ~hidden)),
        ),
        instability[0]: _entry(
            instability,
            floor[:2],
            student_k(floor[3]),
            message("information-bias-instability", source=source),
            *unit_and_table(floor[0]),
            *of_axes("information-averaging-times", averaged),
            *coarse,
            *of_axes("information-no-floor", _axes(np.isnan(floor[2]) & ~hidden), tau=longest),
        ),
    }


def allan_of_rests(evidence: ClauseEvidence, triad: slice) -> AllanOfRests | None:
    """The Allan variances of a triad (its columns among CHANNELS); None without a whole rest."""
    imu, rests = evidence.recording.imu, _longest(evidence, triad)
    if not rests:
        return None
    interval = float(np.median([rest.seconds / rest.rows for rest in rests]))
    return AllanOfRests(
        curve=allan_curve([imu.views(CHANNELS[triad], rest.place) for rest in rests], interval),
        hidden=np.any([coarsely_quantised(rest)[triad] for rest in rests], axis=0),
        count=len(rests),
        seconds=min(rest.seconds for rest in rests),
    )


def _longest(evidence: ClauseEvidence, triad: slice) -> list[SegmentMean]:
    """The rests as long as the longest, whole: no row left out of them and none lost."""
    whole = [
        s
        for s in (evidence.segments[i] for i in evidence.of_kind("static"))
        if s.left_out == 0
        and np.isfinite(evidence.recording.imu.views(CHANNELS[triad], s.place)).all()
        and (s.rows < 2 or s.intervals[1] < GAP * s.seconds / s.rows)
    ]
    longest = max((s.seconds for s in whole), default=0.0)
    return [s for s in whole if s.seconds >= AS_LONG * longest]


def _random_walk(curve: AllanCurve, channel: int) -> tuple[float, float]:
    """N of the white noise and its standard uncertainty, NaN where none shows."""
    noise = white_noise(curve, channel)
    if noise is None:
        return np.nan, np.nan
    value = np.sqrt(noise.density)
    return value, noise.u / (2.0 * value)


def _bias_instability(curve: AllanCurve, channel: int) -> tuple[float, float, float, float]:
    """Bias instability, its standard uncertainty, its averaging time (s) and degrees of freedom.

    NaN without floor.
    """
    variance = curve.variance[:, channel]
    level = int(variance.argmin())
    if level < 2 or not variance[level - 2] < FALLING * variance[level]:
        return np.nan, np.nan, np.nan, np.nan
    value, dof = np.sqrt(variance[level]) / FLOOR, curve.flicker_dof[level]
    return value, value / np.sqrt(2.0 * dof), curve.tau[level], dof


def _axes(which: np.ndarray) -> list[str]:
    return [AXES[i] for i in np.flatnonzero(which)]


def _entry(
    quantity: Quantity,
    value_and_u: np.ndarray,
    k: float,
    *sentences: Message,
) -> Information:
    key, unit, factor = quantity
    return entry(key, unit, *value_and_u, *sentences, factor=factor, k=k)
