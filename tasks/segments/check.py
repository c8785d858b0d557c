"""Checks of segments against gravity, the table, their own samples and the specification.

Every check gives remarks that name the segment, the channel and the number. A remark with
`blocks_pass` is a condition of the specification that is not met.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from schemas.recording import AXES, Recording
from schemas.text import Remark
from tasks.segments.completeness import completeness_remarks
from tasks.segments.conditions import (
    Conditions,
    environment_not_recorded,
    environment_remarks,
    segment_remark,
)
from tasks.segments.find import up_of
from tasks.segments.rates import TurningPoint
from tasks.segments.summarise import (
    ACCEL_COLUMNS,
    CHANNELS,
    LONGEST_BURST,
    SegmentMean,
    coarsely_quantised,
)
from tasks.words import message

Channels = tuple[str, ...]

STUCK_SECONDS = 2.0
LISTED_PAIRS = 5


def check_segments(
    recording: Recording,
    segments: tuple[SegmentMean, ...],
    points: Mapping[int, TurningPoint],
    conditions: Conditions,
    *,
    channels: Channels = CHANNELS,
    may_stand_still: bool = False,
) -> tuple[Remark, ...]:
    """Every remark on every segment, in the order of the segments, then those on all together.

    points: of the segments that turn, by their index. channels: the (6,) columns as they were
    recorded; may_stand_still: their resolution hides their noise.
    """
    remarks: list[Remark] = []
    for i, segment in enumerate(segments):
        remarks.extend(_position(segment))
        remarks.extend(_corrupted(segment, channels))
        if not may_stand_still:
            remarks.extend(_stuck(recording, segment, channels))
        remarks.extend(_lost(recording, segment))
        remarks.extend(environment_remarks(recording, segment, conditions))
        if i in points:
            remarks.extend(_rate(segment, points[i], conditions, channels))
    return (
        *remarks,
        *_short(segments, conditions),
        *_coarse(segments, channels),
        *_overlapping(segments),
        *completeness_remarks(recording, segments),
        *environment_not_recorded(recording, conditions),
    )


def _position(segment: SegmentMean) -> Iterator[Remark]:
    """A labelled position that gravity contradicts."""
    label = segment.segment.up
    if segment.segment.kind != "static" or label is None or not segment.has_accel:
        return
    accel = segment.mean[ACCEL_COLUMNS]
    shown = up_of(accel)
    if shown == label:
        return
    name, axis = segment.segment.name, label[1]
    yield segment_remark(
        "position_contradicted", name, segment=name, label=label, axis=axis,
        reading=f"{accel[AXES.index(axis)]:+.3f}", shown=shown or "none",
    )  # fmt: skip


def _rate(
    segment: SegmentMean, point: TurningPoint, conditions: Conditions, channels: Channels
) -> Iterator[Remark]:
    """A rate that its witness contradicts, or that did not hold still."""
    name, axis = segment.segment.name, segment.segment.axis or ""
    witness = "table" if point.by_table else channels[AXES.index(axis)]
    if point.contradicted and point.shown is not None:
        yield segment_remark(
            "rate_contradicted", name, segment=name, axis=axis, witness=witness,
            label=f"{np.degrees(point.label):+g}", shown=f"{np.degrees(point.shown):+.4f}",
        )  # fmt: skip
    if point.unsteady:
        yield segment_remark(
            "unsteady_rate", name, segment=name, witness=witness,
            wander=f"{np.degrees(point.wander):.4f}", clause=conditions.steadiness_clause,
            percent=f"{100 * conditions.steadiness:g}",
        )  # fmt: skip


def _corrupted(segment: SegmentMean, channels: Channels) -> Iterator[Remark]:
    """Rows that were left out of the mean."""
    if segment.left_out == 0:
        return
    name, burst = segment.segment.name, segment.longest_burst
    counts = [f"{channels[c]} {rows}" for c, rows in enumerate(segment.far_rows) if rows]
    disturbed = burst > LONGEST_BURST
    yield segment_remark(
        "disturbed" if disturbed else "corrupted_rows", name, blocks_pass=disturbed,
        segment=name, out=segment.left_out, rows=segment.rows, channels=", ".join(counts),
        burst=burst,
    )  # fmt: skip


def _stuck(recording: Recording, segment: SegmentMean, channels: Channels) -> Iterator[Remark]:
    """A channel that stood still where noise should have moved it."""
    if segment.segment.kind == "rotation":
        return
    rows = recording.imu.rows(segment.segment.t_start, segment.segment.t_end)
    interval = segment.seconds / segment.rows
    shortest = min(max(20, round(STUCK_SECONDS / interval)), segment.rows)
    name = segment.segment.name
    for channel in np.flatnonzero(np.isfinite(segment.mean)).tolist():
        values = recording.imu.columns[CHANNELS[channel]][rows]
        start, length = _longest_repeat(values, shortest)
        if length < shortest:
            continue
        yield segment_remark(
            "stuck", name, segment=name, channel=channels[channel],
            value=f"{values[start]:.6g}", rows=length,
            time=f"{recording.imu.t[rows.start + start]:.2f}",
        )  # fmt: skip


def _longest_repeat(values: np.ndarray, shortest: int) -> tuple[int, int]:
    """First row and length of the longest run of one value; (0, 0) if none is long enough.

    A run of `shortest` rows holds two neighbours of a sample that takes every half of it.
    """
    sample = values[:: max(1, shortest // 2)]
    if len(sample) > 1 and not (sample[1:] == sample[:-1]).any():
        return 0, 0
    changes = np.flatnonzero(np.diff(values)) + 1
    edges = np.concatenate(([0], changes, [len(values)]))
    lengths = np.diff(edges)
    longest = int(lengths.argmax())
    return int(edges[longest]), int(lengths[longest])


def _lost(recording: Recording, segment: SegmentMean) -> Iterator[Remark]:
    """Samples missing between two time stamps."""
    rows = recording.imu.rows(segment.segment.t_start, segment.segment.t_end)
    steps = np.diff(recording.imu.t[rows])
    if len(steps) < 2:
        return
    interval = float(np.median(steps))
    gaps = steps > 1.5 * interval
    if not gaps.any():
        return
    lost = int(np.round(steps[gaps] / interval - 1).sum())
    worst = int(steps.argmax())
    name, at = segment.segment.name, recording.imu.t[rows.start + worst]
    yield segment_remark(
        "lost_samples", name, blocks_pass=lost > 0.01 * segment.rows,
        segment=name, lost=lost, gaps=int(gaps.sum()), longest=f"{steps[worst]:.3f}",
        time=f"{at:.2f}",
    )  # fmt: skip


def _short(segments: tuple[SegmentMean, ...], conditions: Conditions) -> Iterator[Remark]:
    """Every segment that lasts less than each point must last."""
    held = [segment for segment in segments if segment.segment.kind != "rotation"]
    short = {s.segment.name: _lasts(s) for s in held if _lasts(s) < conditions.dwell_s - 1e-6}
    if short:
        yield segment_remark(
            "short_dwell", *short, short=len(short), held=len(held),
            asked=f"{conditions.dwell_s:.0f}", clause=conditions.dwell_clause,
            listed=", ".join(f"{name} {lasts:.1f} s" for name, lasts in short.items()),
        )  # fmt: skip


def _lasts(segment: SegmentMean) -> float:
    """How long a segment lasts (s): its samples, and up to two intervals that its label adds."""
    interval = segment.seconds / segment.rows
    asked = segment.segment.t_end - segment.segment.t_start
    return max(segment.seconds, min(asked, segment.seconds + 2 * interval))


def _coarse(segments: tuple[SegmentMean, ...], channels: Channels) -> Iterator[Remark]:
    """Channels whose step hides their noise: their means may be off by half a step."""
    flags = np.array([coarsely_quantised(segment) for segment in segments]).reshape(-1, 6)
    steps = {
        c: max(s.step[c] for s in segments) for c in np.flatnonzero(flags.any(axis=0)).tolist()
    }
    if steps:
        listed = ", ".join(f"{channels[channel]} {step:.3g}" for channel, step in steps.items())
        names = (s.segment.name for s, row in zip(segments, flags, strict=True) if row.any())
        yield segment_remark("coarse_step", *names, steps=listed)


def _overlapping(segments: tuple[SegmentMean, ...]) -> Iterator[Remark]:
    """Segments that share more than one row: the same noise would be counted as new evidence."""
    ordered = sorted(segments, key=lambda s: s.t_start)
    pairs = [
        (first.segment.name, second.segment.name)
        for first, second in pairwise(ordered)
        if second.t_start < first.t_end - 1.5 * first.seconds / first.rows
    ]
    if pairs:
        listed = [message("segments-pair", first=a, second=b) for a, b in pairs[:LISTED_PAIRS]]
        names = dict.fromkeys(name for pair in pairs for name in pair)
        yield segment_remark(
            "overlapping_segments", *names,
            pairs=tuple(listed), more=max(len(pairs) - LISTED_PAIRS, 0),
        )  # fmt: skip
