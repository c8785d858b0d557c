"""Checks of segments against gravity, the table, their own samples and the specification.

Every check gives remarks that name the segment, the channel and the number. A remark with
`blocks_pass` is a condition of the specification that is not met.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from schemas.calibration import Remark
from schemas.recording import AXES, Recording
from tasks.segments.conditions import Conditions
from tasks.segments.find import up_of
from tasks.segments.rates import TurningPoint, turning_points
from tasks.segments.summarise import (
    ACCEL_COLUMNS,
    CHANNELS,
    LONGEST_BURST,
    SegmentMean,
    coarsely_quantised,
)

STUCK_SECONDS = 2.0


def check_segments(
    recording: Recording, segments: tuple[SegmentMean, ...], conditions: Conditions
) -> tuple[Remark, ...]:
    """Every remark on every segment, in the order of the segments."""
    remarks: list[Remark] = []
    points = turning_points(recording, segments)
    for i, segment in enumerate(segments):
        for check in (_position, _corrupted, _stuck, _lost):
            remarks.extend(check(recording, segment))
        remarks.extend(_room(recording, segment, conditions))
        if i in points:
            remarks.extend(_rate(segment, points[i], conditions))
    return (
        *remarks,
        *_short(segments, conditions),
        *_coarse(segments),
        *_counted_twice(segments),
    )


def _position(recording: Recording, segment: SegmentMean) -> Iterator[Remark]:
    """A labelled position that gravity contradicts."""
    label = segment.segment.up
    if segment.segment.kind != "static" or label is None or not segment.has_accel:
        return
    accel = segment.mean[ACCEL_COLUMNS]
    shown = up_of(accel)
    if shown == label:
        return
    name, axis = segment.segment.name, AXES.index(label[1])
    seen, seen_zh = (
        (f"gravity shows {shown} up, and that was used", f"重力显示 {shown} 朝天，已按重力取用")
        if shown
        else (
            "no axis lies within 10° of what is read; it was left out",
            "无任何轴在读数 10° 以内，未取用",
        )
    )
    yield Remark(
        code="position_contradicted",
        en=f"{name}: labelled {label} up, but accel_{label[1]} reads {accel[axis]:+.3f} m/s²: "
        f"{seen}.",
        zh=f"{name}：标注 {label} 朝天，但 accel_{label[1]} 读数为 {accel[axis]:+.3f} m/s²："
        f"{seen_zh}。",
        segments=(name,),
        blocks_pass=True,
    )


def _rate(segment: SegmentMean, point: TurningPoint, conditions: Conditions) -> Iterator[Remark]:
    """A rate that its witness contradicts, or that did not hold still."""
    name, axis = segment.segment.name, segment.segment.axis
    witness, witness_zh = ("the table", "转台") if point.by_table else (f"gyro_{axis}",) * 2
    if point.contradicted and point.shown is not None:
        label, shown = np.degrees(point.label), np.degrees(point.shown)
        taken, taken_zh = (
            ("the table's rate was used", "已按转台速率取用")
            if point.by_table
            else ("it was left out", "未取用")
        )
        yield Remark(
            code="rate_contradicted",
            en=f"{name}: labelled {label:+g} deg/s about {axis}, but {witness} shows "
            f"{shown:+.4f} deg/s: {taken}.",
            zh=f"{name}：标注绕 {axis} 轴 {label:+g} °/s，但{witness_zh}显示 {shown:+.4f} °/s："
            f"{taken_zh}。",
            segments=(name,),
            blocks_pass=True,
        )
    if point.unsteady:
        wander, share = np.degrees(point.wander), 100 * conditions.steadiness
        yield Remark(
            code="unsteady_rate",
            en=f"{name}: by {witness} the rate changed by {wander:.4f} deg/s during the segment; "
            f"{conditions.steadiness_clause} asks for a steady rate ({share:g} %).",
            zh=f"{name}：{witness_zh}显示该段内角速率变化 {wander:.4f} °/s；"
            f"{conditions.steadiness_clause} 要求角速率平稳（{share:g}%）。",
            segments=(name,),
            blocks_pass=True,
        )


def _corrupted(recording: Recording, segment: SegmentMean) -> Iterator[Remark]:
    """Rows that were left out of the mean."""
    if segment.left_out == 0:
        return
    name = segment.segment.name
    counts = ", ".join(
        f"{CHANNELS[channel]} {segment.far_rows[channel]}"
        for channel in np.flatnonzero(segment.far_rows)
    )
    burst = segment.longest_burst > LONGEST_BURST
    disturbed = f"; {segment.longest_burst} of them in a row: it was disturbed" if burst else ""
    disturbed_zh = f"；其中连续 {segment.longest_burst} 行：该段受到扰动" if burst else ""
    yield Remark(
        code="disturbed" if burst else "corrupted_rows",
        en=f"{name}: {segment.left_out} of {segment.rows} rows far from the rest ({counts}) were "
        f"left out of the mean{disturbed}.",
        zh=f"{name}：{segment.rows} 行中有 {segment.left_out} 行远离其余数据（{counts}），"
        f"未计入均值{disturbed_zh}。",
        segments=(name,),
        blocks_pass=burst,
    )


def _stuck(recording: Recording, segment: SegmentMean) -> Iterator[Remark]:
    """A channel that stood still where noise should have moved it."""
    if segment.segment.kind == "rotation":
        return
    rows = recording.imu.rows(segment.segment.t_start, segment.segment.t_end)
    interval = segment.seconds / segment.rows
    shortest = min(max(20, round(STUCK_SECONDS / interval)), segment.rows)
    name = segment.segment.name
    for channel in np.flatnonzero(np.isfinite(segment.mean)):
        values = recording.imu.columns[CHANNELS[channel]][rows]
        start, length = _longest_repeat(values, shortest)
        if length < shortest:
            continue
        at, held = recording.imu.t[rows.start + start], values[start]
        yield Remark(
            code="stuck",
            en=f"{name}: {CHANNELS[channel]} stood still at {held:.6g} for {length} rows from "
            f"t = {at:.2f} s.",
            zh=f"{name}：{CHANNELS[channel]} 自 t = {at:.2f} s 起连续 {length} 行停在 {held:.6g}。",
            segments=(name,),
            blocks_pass=True,
        )


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
    yield Remark(
        code="lost_samples",
        en=f"{name}: {lost} samples lost in {int(gaps.sum())} gaps, the longest "
        f"{steps[worst]:.3f} s at t = {at:.2f} s.",
        zh=f"{name}：{int(gaps.sum())} 处间断共丢失 {lost} 个采样，最长 {steps[worst]:.3f} s，"
        f"位于 t = {at:.2f} s。",
        segments=(name,),
        blocks_pass=lost > 0.01 * segment.rows,
    )


def _short(segments: tuple[SegmentMean, ...], conditions: Conditions) -> Iterator[Remark]:
    """Every segment that lasts less than each point must last."""
    asked, clause = conditions.dwell_s, conditions.dwell_clause
    held = [segment for segment in segments if segment.segment.kind != "rotation"]
    short = {s.segment.name: _lasts(s) for s in held if _lasts(s) < asked - 1e-6}
    if not short:
        return
    listed = ", ".join(f"{name} {lasts:.1f} s" for name, lasts in short.items())
    yield Remark(
        code="short_dwell",
        en=f"{len(short)} of {len(held)} segments last less than the {asked:.0f} s that {clause} "
        f"asks for at each point: {listed}.",
        zh=f"{len(held)} 段中有 {len(short)} 段短于 {clause} 要求的每点 {asked:.0f} s：{listed}。",
        segments=tuple(short),
        blocks_pass=True,
    )


def _coarse(segments: tuple[SegmentMean, ...]) -> Iterator[Remark]:
    """Channels whose step hides their noise: their means may be off by half a step."""
    flags = np.array([coarsely_quantised(segment) for segment in segments]).reshape(-1, 6)
    coarse = np.flatnonzero(flags.any(axis=0))
    if not len(coarse):
        return
    steps = [max(segment.step[channel] for segment in segments) for channel in coarse]
    pairs = zip(coarse, steps, strict=True)
    listed = ", ".join(f"{CHANNELS[channel]} {step:.3g}" for channel, step in pairs)
    yield Remark(
        code="coarse_step",
        en=f"The output's step is larger than its noise ({listed}, SI units): no averaging "
        "removes it, a mean may be off by half a step.",
        zh=f"输出分辨力大于噪声（{listed}，SI 单位）：平均不能消除，均值可能偏离半个分度。",
        segments=tuple(s.segment.name for s, row in zip(segments, flags, strict=True) if row.any()),
        blocks_pass=True,
    )


def _counted_twice(segments: tuple[SegmentMean, ...]) -> Iterator[Remark]:
    """Segments that share more than one row: the same noise would be counted as new evidence."""
    ordered = sorted(segments, key=lambda s: s.t_start)
    pairs = [
        (first.segment.name, second.segment.name)
        for first, second in pairwise(ordered)
        if second.t_start < first.t_end - 1.5 * first.seconds / first.rows
    ]
    if not pairs:
        return
    listed = ", ".join(f"{first} and {second}" for first, second in pairs[:5])
    more = f" and {len(pairs) - 5} more pairs" if len(pairs) > 5 else ""
    more_zh = f"等共 {len(pairs)} 对" if len(pairs) > 5 else ""
    yield Remark(
        code="overlapping_segments",
        en=f"Segments overlap, so the same samples are counted twice: {listed}{more}.",
        zh=f"标注段相互重叠，同一数据被重复计入：{listed}{more_zh}。",
        segments=tuple(dict.fromkeys(name for pair in pairs for name in pair)),
        blocks_pass=True,
    )


def _lasts(segment: SegmentMean) -> float:
    """How long a segment lasts (s): its samples, and up to two intervals that its label adds."""
    interval = segment.seconds / segment.rows
    asked = segment.segment.t_end - segment.segment.t_start
    return max(segment.seconds, min(asked, segment.seconds + 2 * interval))


def _room(recording: Recording, segment: SegmentMean, conditions: Conditions) -> Iterator[Remark]:
    """Air temperature and humidity outside the specification's limits during the segment."""
    if recording.environment is None:
        return
    limits = {
        "temperature": (conditions.temperature_degc, "°C", "air temperature", "环境温度"),
        "humidity": (conditions.humidity_percent, "%RH", "relative humidity", "相对湿度"),
    }
    rows = recording.environment.rows(segment.t_start, segment.t_end)
    for column, ((low, high), unit, english, chinese) in limits.items():
        values = recording.environment.columns.get(column, np.empty(0))[rows]
        if not len(values) or (values.min() >= low and values.max() <= high):
            continue
        name, clause = segment.segment.name, conditions.room_clause
        worst = values.max() if values.max() > high else values.min()
        yield Remark(
            code="environment",
            en=f"{name}: {english} {worst:.1f} {unit} is outside {low:g} to {high:g} {unit} "
            f"(clause {clause}).",
            zh=f"{name}：{chinese} {worst:.1f} {unit} 超出 {low:g}~{high:g} {unit}（{clause}）。",
            segments=(name,),
            blocks_pass=True,
        )
