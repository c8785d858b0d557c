"""What an AHRS puts out as a rate: the angle it gained, over the time.

F of eq. (10) is the mean of the increments per second over a segment, which is the angle gained
from its beginning to its end divided by the time between. The same holds for N of (16), (17).
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from schemas.recording import ANGLE, GYRO, Recording, Segment, Stream
from tasks.segments.summarise import (
    GYRO_COLUMNS,
    SegmentMean,
    allan_variances,
    far_rows,
    steps,
    summarise,
)

Origin = Literal["label", "found"]

STEP_ROWS = 8000  # rows that the resolution of an angle is looked for in
WILD = 5.0  # times nearly the largest increment of a turn: no increment of that turn


@dataclass(frozen=True)
class Gained:
    """Increments of the accumulated angles over one segment.

    increment: (3, n) rad, those that jumped replaced by what lies beside them.
    t_start, t_end: s, the first and the last reading.
    """

    increment: np.ndarray
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


def gained(imu: Stream, segment: Segment, step: np.ndarray) -> Gained | None:
    """The increments of a segment, None with fewer than two readings.

    The reading at the segment's end closes its last increment; where angles began anew there,
    that increment jumps. step: (3,) resolution, rad.
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
    for channel, values in enumerate(increment):
        wild = _wild(values * share, step[channel], segment)
        if wild is not None and not wild.all():
            row = np.arange(len(values))
            calm = np.interp(row[wild], row[~wild], (values * share)[~wild])
            increment[channel, wild] = calm / share[wild]
    return Gained(increment, float(t[0]), float(t[-1]))


def _wild(values: np.ndarray, step: float, segment: Segment) -> np.ndarray | None:
    """Which increments (n,) are a spike's or a restart's; in a turn they may differ a lot."""
    if segment.kind != "rotation":
        return far_rows(values, step)
    return np.abs(values) > WILD * np.quantile(np.abs(values), 0.9) + 4.5 * step


def angle_noise(rests: list[Gained], step: np.ndarray) -> np.ndarray:
    """Variance (3,) rad² of a single angle reading about the angle it reads.

    Noise of the angle itself makes neighbouring increments opposite: it is the lag-one covariance
    of the increments inside rests with the sign turned, and never less than that of rounding.
    """
    total, count = np.zeros(3), 0
    for rest in rests:
        about = rest.increment - rest.increment.mean(axis=1, keepdims=True)
        total += (about[:, 1:] * about[:, :-1]).sum(axis=1)
        count += about.shape[1] - 1
    rounding = step**2 / 12.0
    return np.maximum(-total / count, rounding) if count > 0 else rounding


def is_coarse(rests: list[Gained], step: np.ndarray) -> bool:
    """Whether an angle often stands still at rest, because its resolution hides its noise."""
    for channel in range(3):
        size = np.abs(np.concatenate([rest.increment[channel] for rest in rests] or [np.ones(1)]))
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
) -> tuple[tuple[SegmentMean, ...], np.ndarray, bool]:
    """Summaries of the segments, the noise (3,) rad² of an angle reading, and whether it is coarse.

    recording: with the angles; rates: the same from `as_rates`. The gyro's part of a summary is
    the angle gained over the time; its Allan variances are those of the rate, the part that noise
    of the angle makes of them taken away (3·q²/τ², IEEE Std 952, C.1.5).
    """
    step = resolution(recording.imu)
    every_step = steps(rates.imu)
    interval = float(np.median(np.diff(recording.imu.t))) if len(recording.imu) > 1 else 1.0
    every_step[GYRO_COLUMNS] = step / interval
    kept = []
    for segment in segments:
        base = summarise(rates.imu, segment, origin, every_step)
        gain = gained(recording.imu, segment, step)
        if base is not None and gain is not None:
            kept.append((base, gain))
    rests = [gain for base, gain in kept if base.segment.kind == "static"]
    noise = angle_noise(rests, step)
    means = tuple(_with_angles(base, gain, noise) for base, gain in kept)
    return means, noise, is_coarse(rests, step)


def _with_angles(base: SegmentMean, gain: Gained, noise: np.ndarray) -> SegmentMean:
    seconds = gain.t_end - gain.t_start
    count = gain.increment.shape[1]
    mean, step = base.mean.copy(), base.step.copy()
    mean[GYRO_COLUMNS] = gain.increment.sum(axis=1) / seconds
    step[GYRO_COLUMNS] = 0.0  # the rounding of the angle is counted once, as its noise
    seen, tau = allan_variances(gain.increment * count / seconds, seconds)
    allan = np.zeros((len(tau), len(mean)))
    allan[:, GYRO_COLUMNS] = (seen - 3.0 * noise / tau[:, None] ** 2).clip(min=0.0)
    return replace(
        base,
        mean=mean,
        step=step,
        allan=allan,
        tau=tau,
        t_start=gain.t_start,
        t_end=gain.t_end,
    )
