"""The rate of an AHRS that outputs angles: the angle gained, over the time.

F of eq. (10) is the mean of the increments per second over a segment, which is the angle gained
from its beginning to its end divided by the time between. The same holds for N of (16), (17).
"""

from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import ANGLE, GYRO, Recording, Segment, Stream
from tasks.readings.standing import longest_run, steps
from tasks.segments.block_allan import allan_variances
from tasks.segments.one_pass import one_pass
from tasks.segments.summarise import (
    GYRO_COLUMNS,
    Origin,
    SegmentMean,
    far_rows,
    summarise,
)

FLICKER_ALLAN = 2.0 * np.log(2.0)
ROUNDS = 5  # of weighting by the model fitted before
FAINT = 0.1  # of the white part: less is what is left of a difference
AS_LONG = 0.9  # of the longest rest: rests that show noise as slow as it does
STEP_ROWS = 8000  # rows that the resolution of an angle is looked for in
OUTLYING = 5.0  # times the 90 % quantile of a turn's increments: no increment of that turn


# Noise of accumulated angles, from their increments inside the rests.
#
# Three parts: white noise of the rate, which makes the angle walk (N², rad²/s); white noise and
# rounding of the angle itself (q², rad²); flicker of the rate. Their Allan variances are N²/τ,
# 3·q²/τ² and 2·ln 2·h (IEEE Std 952, annex C). What is slower than a rest, `tasks.uncertainty`
# finds between them.


@dataclass(frozen=True)
class AngleNoise:
    """walk: (3,) N², rad²/s; angle: (3,) q², rad², of one reading."""

    walk: np.ndarray
    angle: np.ndarray


@dataclass(frozen=True)
class Increments:
    """Increments of the accumulated angles over one segment.

    increment: (3, n) rad, those that jumped replaced by what lies beside them.
    outlying: (3, n), which ones those are.
    t_start, t_end: s, the first and the last reading.
    """

    increment: np.ndarray
    outlying: np.ndarray
    t_start: float
    t_end: float


def has_angles(recording: Recording) -> bool:
    """Whether the recording holds the AHRS's accumulated angles."""
    return all(name in recording.imu.columns for name in ANGLE)


def as_rates(recording: Recording) -> Recording:
    """The recording with gyro_* (rad/s) made of the angles: the increment that begins at each row.

    Whatever checks a gyro, its steadiness, its lost samples, can then check an AHRS.
    """
    imu = recording.imu
    rates = np.diff(imu.stack(ANGLE), axis=0).T / np.diff(imu.t)
    columns = {name: values[:-1] for name, values in imu.columns.items() if name not in ANGLE}
    columns |= dict(zip(GYRO, rates, strict=True))
    return replace(recording, imu=Stream(imu.t[:-1], columns))


def resolution(imu: Stream) -> np.ndarray:
    """Smallest difference (3,) rad between two readings of each accumulated angle."""
    sample = np.sort(imu.stack(ANGLE)[:: max(1, len(imu) // STEP_ROWS)], axis=0)
    apart = np.diff(sample, axis=0)
    rounding = 8 * np.finfo(float).eps * np.abs(sample).max(axis=0)
    smallest = np.where(apart > rounding, apart, np.inf).min(axis=0, initial=np.inf)
    return np.where(np.isfinite(smallest), smallest, 0.0)


def angle_increments(imu: Stream, segment: Segment, step: np.ndarray) -> Increments | None:
    """The increments of a segment, None with fewer than two readings.

    The reading at the segment's end closes its last increment; if the angles were reset there, that
    increment jumps. step: (3,) resolution, rad.
    """
    rows = imu.rows(segment.t_start, segment.t_end)
    if rows.stop - rows.start < 2:
        return None
    interval = float(np.median(np.diff(imu.t[rows])))
    stop = rows.stop
    if stop < len(imu) and imu.t[stop] < segment.t_end + 0.5 * interval:
        stop += 1
    within = slice(rows.start, stop)
    t = imu.t[within]
    increment = np.diff(imu.channels(ANGLE, within), axis=1)
    share = interval / np.diff(t)
    replaced = np.zeros(increment.shape, bool)
    row = np.arange(len(share))
    for channel, values in enumerate(increment * share):
        outlying = _outlying_rows(values, step[channel], segment)
        if outlying is not None and not outlying.all():
            calm = np.interp(row[outlying], row[~outlying], values[~outlying])
            increment[channel, outlying] = calm / share[outlying]
            replaced[channel] = outlying
    return Increments(increment, replaced, float(t[0]), float(t[-1]))


def _outlying_rows(values: np.ndarray, step: float, segment: Segment) -> np.ndarray | None:
    """Which increments (n,) are a spike's or a restart's; in a turn they may differ a lot."""
    if segment.kind != "rotation":
        return far_rows(values, step)
    return np.abs(values) > OUTLYING * np.quantile(np.abs(values), 0.9) + 4.5 * step


def is_coarse(rests: list[np.ndarray], step: np.ndarray) -> bool:
    """Whether an angle often stands still at rest, because its resolution hides its noise."""
    for channel in range(3):
        size = np.abs(np.concatenate([rest[channel] for rest in rests] or [np.ones(1)]))
        moved = size > 0.5 * step[channel]
        if (
            step[channel] > 0
            and moved.mean() < 0.9
            and (not moved.any() or np.median(size[moved]) < 3 * step[channel])
        ):
            return True
    return False


def summarise_angles(
    recording: Recording, rates: Recording, segments: tuple[Segment, ...], origin: Origin
) -> tuple[tuple[SegmentMean, ...], AngleNoise, bool]:
    """Summaries of the segments, the noise of the angles, and whether their resolution is coarse.

    recording: with the angles; rates: the same from `as_rates`. The gyro's part of a summary is
    the angle gained over the time.
    """
    step = resolution(recording.imu)
    every_step = steps(rates.imu)
    interval = float(np.median(np.diff(recording.imu.t))) if len(recording.imu) > 1 else 1.0
    every_step[GYRO_COLUMNS] = step / interval
    kept = []
    for segment in segments:
        base = summarise(rates.imu, segment, origin, every_step)
        gain = angle_increments(recording.imu, segment, step)
        if base is not None and gain is not None:
            kept.append((base, gain))
    rests = [gain.increment for base, gain in kept if base.segment.kind == "static"]
    noise = fit_angle_noise(rests, interval, step)
    means = tuple(_with_angles(base, gain) for base, gain in kept)
    return _with_slow_noise(means, noise), noise, is_coarse(rests, step)


def _with_angles(base: SegmentMean, gain: Increments) -> SegmentMean:
    """The summary with the angle gained over the time as its rates, and their Allan variances."""
    seconds = gain.t_end - gain.t_start
    mean, step, far = base.mean.copy(), base.step.copy(), base.far_rows.copy()
    mean[GYRO_COLUMNS] = gain.increment.sum(axis=1) / seconds
    step[GYRO_COLUMNS] = 0.0  # the rounding of the angle is counted once, as its noise
    rate = gain.increment * gain.increment.shape[1] / seconds
    variances, tau = allan_variances(one_pass(rate).blocks, seconds)
    allan = np.zeros((len(tau), len(mean)))
    allan[:, GYRO_COLUMNS] = variances
    far[GYRO_COLUMNS] = gain.outlying.sum(axis=1)
    any_outlying = np.asarray(gain.outlying.any(axis=0))
    return replace(
        base,
        t_start=gain.t_start,
        t_end=gain.t_end,
        left_out=int(any_outlying.sum()),
        far_rows=far,
        longest_burst=longest_run(any_outlying),
        mean=mean,
        step=step,
        allan=allan,
        tau=tau,
    )


def _with_slow_noise(means: tuple[SegmentMean, ...], noise: AngleNoise) -> tuple[SegmentMean, ...]:
    """The summaries with the Allan variances that the rests show together.

    The longest rests keep what they show, the mean over all of them; the others, and whatever
    turns, have the white noise of the rate.
    """
    rests = {i: m for i, m in enumerate(means) if m.segment.kind == "static"}
    levels = max((len(m.tau) for m in rests.values()), default=0)
    longest = max((m.seconds for m in rests.values()), default=0.0)
    long = {
        i: m.allan[:, GYRO_COLUMNS]
        for i, m in rests.items()
        if m.seconds > AS_LONG * longest and len(m.tau) == levels
    }
    changed = []
    for i, m in enumerate(means):
        allan = np.zeros_like(m.allan)
        allan[:, GYRO_COLUMNS] = noise.walk / m.tau[:, None]
        if i in long:
            allan[:, GYRO_COLUMNS] = slow_allan(list(long.values()), m.tau, noise)
        changed.append(replace(m, allan=allan))
    return tuple(changed)


def fit_angle_noise(rests: list[np.ndarray], interval: float, step: np.ndarray) -> AngleNoise:
    """Noise that all rests together show.

    rests: increments (3, n) rad each, `interval` s apart; step: (3,) rad, resolution. The noise
    of the angle is never less than that of rounding, step²/12.
    """
    rounding = step**2 / 12.0
    variance, count = pooled_allan(rests, interval)
    if not len(count):
        return AngleNoise(np.zeros(3), rounding)
    tau = interval * 2.0 ** np.arange(len(count))
    fitted = np.array([_fit(tau, variance[:, channel], count) for channel in range(3)])
    return AngleNoise(walk=fitted[:, 1], angle=np.maximum(fitted[:, 0], rounding))


def pooled_allan(rests: list[np.ndarray], interval: float) -> tuple[np.ndarray, np.ndarray]:
    """Allan variances (levels, 3) of the rate at 1, 2, 4 … intervals, and how many differences."""
    levels = max((rest.shape[1].bit_length() - 1 for rest in rests), default=0)
    total, count = np.zeros((levels, 3)), np.zeros(levels, int)
    for rest in rests:
        gain = rest
        for level in range(rest.shape[1].bit_length() - 1):
            square = np.diff(gain, axis=1) ** 2 / (interval * 2.0**level) ** 2
            total[level] += 0.5 * square.sum(axis=1)
            count[level] += square.shape[1]
            even = gain.shape[1] // 2 * 2
            gain = gain[:, 0:even:2] + gain[:, 1:even:2]
    return total / count[:, None], count


def _fit(tau: np.ndarray, variance: np.ndarray, count: np.ndarray) -> np.ndarray:
    """q², N² and h (3,), none negative: least squares, each level as it knows its own size."""
    from scipy.optimize import nnls  # late: a tenth of a start

    if not variance.any():
        return np.zeros(3)
    design = np.column_stack([3.0 / tau**2, 1.0 / tau, np.full(len(tau), FLICKER_ALLAN)])
    expected, terms = variance.clip(min=1e-6 * variance.max() / len(tau)), np.zeros(3)
    for _ in range(ROUNDS):
        weight = np.sqrt(count) / expected
        scaled = design * weight[:, None]
        size = np.linalg.norm(scaled, axis=0)
        terms = nnls(scaled / size, variance * weight)[0] / size
        expected = np.maximum(design @ terms, 1e-12 * variance.max())
    return terms


def slow_allan(variances: list[np.ndarray], tau: np.ndarray, noise: AngleNoise) -> np.ndarray:
    """Mean Allan variance (levels, 3) of equally long rests, without the part of the angle.

    variances: (levels, 3) of each rest at block lengths tau (levels,). Never less than a part of
    what the white rate noise gives.
    """
    slow = np.mean(variances, axis=0) - 3.0 * noise.angle / tau[:, None] ** 2
    return np.maximum(slow, FAINT * noise.walk / tau[:, None])
