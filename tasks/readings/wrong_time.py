"""Times in a smaller unit than seconds."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from schemas.recording import GYRO, Recording, Segment
from schemas.text import Remark
from tasks.readings.implausible import found_on_sight
from tasks.readings.segment_means import FEW, SegmentMeans, directions_of
from tasks.words import message

SLOWEST = 0.25  # s between rows, from which the time may be in a smaller unit
FASTEST = 2e4  # Hz
TIMES = ((1e3, "ms"), (1e6, "us"), (1e9, "ns"))
MOST = 0.9  # of the labels
TURNED = np.radians(30.0)  # between rests: a move
LONGEST_WAY = 100.0  # times the angle between two rests that a unit turns from one to the other
AS_FAR = 2.5  # times: axes that turn together, noise


def wrong_time(
    recording: Recording, segments: Sequence[Segment], means: SegmentMeans
) -> Remark | None:
    """Times in a smaller unit than s: by the rates of encoders, by the way between rests, or by
    labels and streams of which one lasts a thousand times as long.
    """
    t = recording.imu.t
    beyond = [segment.t_end for segment in segments if segment.t_start > t[-1]]
    if beyond and len(beyond) > MOST * len(segments):
        for factor, unit in TIMES:
            if abs(np.log(max(beyond) / t[-1] / factor)) < np.log(2.0):
                return _time_sentence("labels", max(beyond), factor, f"--units labels={unit}")
    if t[-1] - t[0] < 0.5 * SLOWEST * (len(t) - 1):  # most of the steps are shorter
        return None
    interval = float(np.median(np.diff(t)))
    if interval < SLOWEST:
        return None
    for factor, unit in TIMES:
        if interval / factor > 1.0 / 4.0 or interval / factor < 1.0 / FASTEST:
            continue
        if _by_encoders(recording, factor) or _by_ways(recording, segments, means, factor):
            return _time_sentence("recording", interval, factor, f"--units t={unit}")
    return None


def _time_sentence(what: str, value: float, factor: float, option: str) -> Remark:
    unit = option.rpartition("=")[2]
    return found_on_sight(
        "time_unit",
        message("plausibility-time", what=what, value=f"{value:.4g}", factor=f"{factor:.0f}",
                unit=unit, option=option),
    )  # fmt: skip


def _by_encoders(recording: Recording, factor: float) -> bool:
    """Whether gyros turn as far as encoders once their times are divided."""
    ratio = turned_ratio(recording)
    return ratio is not None and 1.0 / AS_FAR < ratio / factor < AS_FAR


def turned_ratio(recording: Recording) -> float | None:
    """How far the gyros turned in all, over how far the encoders did; None where either is not
    known.
    """
    imu, table = recording.imu, recording.table
    gyro = imu.stack(GYRO)
    if table is None or not np.isfinite(gyro).all():
        return None
    angles = [v for name, v in table.columns.items() if name.endswith("_angle")]
    turned = sum(float(np.abs(np.diff(angle)).sum()) for angle in angles)
    speed = np.linalg.norm(gyro - np.median(gyro, axis=0), axis=1)
    read = float(np.sum(0.5 * (speed[1:] + speed[:-1]) * np.diff(imu.t)))
    return read / turned if turned > np.pi else None


def _by_ways(
    recording: Recording, segments: Sequence[Segment], means: SegmentMeans, factor: float
) -> bool:
    """Whether between all rests the gyros turn by far too much for what gravity turned by, and
    once the times are divided by enough.
    """
    ratios = ways(recording, segments, means)
    return len(ratios) > FEW and min(ratios) > LONGEST_WAY and min(ratios) / factor > 0.5


def ways(recording: Recording, segments: Sequence[Segment], means: SegmentMeans) -> list[float]:
    """From each rest to the next, how far the gyros turned over the angle that gravity turned by,
    where it turned; no way is shorter than that angle.
    """
    imu = recording.imu
    order = np.argsort([s.t_start for s in segments])
    usable = (
        means.static & np.isfinite(means.gyro).all(axis=1) & np.isfinite(means.accel).all(axis=1)
    )
    rests = [int(k) for k in order if usable[k]]
    if len(rests) <= FEW:
        return []
    rate = np.nan_to_num(imu.stack(GYRO) - np.median(means.gyro[rests], axis=0))
    speed = np.linalg.norm(rate, axis=1)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(imu.t))])
    directions, ratios = directions_of(means.accel), list[float]()
    for a, b in pairwise(rests):
        angle = np.arccos(np.clip(directions[a] @ directions[b], -1.0, 1.0))
        if angle > TURNED:
            ends = (segments[a].t_end, segments[b].t_start)
            ratios.append(float(np.diff(np.interp(ends, imu.t, way))[0] / angle))
    return ratios
