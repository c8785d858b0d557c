"""A calibration put together from what the clauses contributed, whatever the specification."""

from collections.abc import Iterator

import numpy as np

from schemas.calibration import Calibration, EnvironmentSeen, Method, Remark, SegmentUsed
from schemas.recording import MEASURED, TRIADS, Recording, Stream
from tasks.motion.smooth import covered
from tasks.segments.check import check_segments
from tasks.segments.conditions import Conditions
from tasks.specifications.evaluation import Evaluation
from tasks.specifications.evidence import FEWEST_ROWS, Evidence, rows_of
from tasks.specifications.information import information
from tasks.specifications.parts import Part


def assemble(
    recording: Recording,
    evidence: Evidence,
    part: Part,
    *,
    method: Method,
    procedure: str,
    order: tuple[str, ...],
    conditions: Conditions,
    evaluation: Evaluation,
    run: str,
    code_version: str,
) -> Calibration:
    """The result of one method: items in their order, reasons, remarks, segments, room."""
    station = recording.manifest.station
    remarks = (
        *part.remarks,
        *evaluation.remarks,
        *check_segments(recording, evidence.segments, conditions),
        *_without_rows(recording),
        *_null_rows(recording),
        *_without_table(recording, evidence),
        *_room_not_recorded(recording, conditions),
    )
    return Calibration(
        recording_id=recording.manifest.recording_id,
        run=run,
        digest=recording.digest,
        method=method,
        code_version=code_version,
        procedure=procedure,
        settings={
            "gravity_m_s2": station.gravity_m_s2,
            "latitude_deg": station.latitude_deg,
            **evaluation.settings,
        },
        items={name: part.items[name] for name in order},
        information=information(recording, evidence, part.items),
        unavailable={n: part.unavailable[n][0] for n in order if n in part.unavailable},
        unavailable_zh={n: part.unavailable[n][1] for n in order if n in part.unavailable},
        remarks=remarks,
        segments=tuple(_used(evidence, i) for i in range(len(evidence.segments))),
        environment=_environment_seen(recording.environment),
    )


def _room_not_recorded(recording: Recording, conditions: Conditions) -> Iterator[Remark]:
    recorded = recording.environment.columns if recording.environment is not None else {}
    if not {"temperature", "humidity"} <= set(recorded):
        yield Remark(
            code="environment_not_recorded",
            en="Air temperature and humidity were not both recorded: whether clause "
            f"{conditions.room_clause} was met is not known.",
            zh=f"未同时记录环境温度和湿度：无法确认是否满足 {conditions.room_clause} 的环境条件。",
            blocks_pass=True,
        )


def _without_rows(recording: Recording) -> Iterator[Remark]:
    """Labelled segments that the recording has no rows of, or too few for a mean."""
    measured = [s for s in recording.manifest.segments or () if s.kind in MEASURED]
    empty = {s.name: rows_of(recording, s) for s in measured}
    empty = {name: rows for name, rows in empty.items() if rows < FEWEST_ROWS}
    if empty:
        listed = ", ".join(f"{name} {rows}" for name, rows in empty.items())
        yield Remark(
            code="without_rows",
            en=f"{len(empty)} labelled segments have too few rows and were left out: {listed}.",
            zh=f"{len(empty)} 个标注段的数据行过少，未取用：{listed}。",
            segments=tuple(empty),
            blocks_pass=True,
        )


def _null_rows(recording: Recording) -> Iterator[Remark]:
    """Labelled segments that a triad of the unit has null rows in: it is not taken there."""
    imu = recording.imu
    measured = [s for s in recording.manifest.segments or () if s.kind in MEASURED]
    for triad in TRIADS:
        values = imu.columns.get(triad[0])
        if values is None or not np.isnan(values).any() or np.isnan(values).all():
            continue
        nulls = {
            s.name: int(np.isnan(values[imu.rows(s.t_start, s.t_end)]).sum()) for s in measured
        }
        nulls = {name: count for name, count in nulls.items() if count}
        if nulls:
            name = triad[0].removesuffix("_x")
            listed = ", ".join(f"{segment} {count}" for segment, count in nulls.items())
            yield Remark(
                code="null_rows",
                en=f"The {name} triad was left out of {len(nulls)} segments for their null rows: "
                f"{listed}.",
                zh=f"{len(nulls)} 段因含空值行，未取用其 {name} 数据：{listed}。",
                segments=tuple(nulls),
            )


def _without_table(recording: Recording, evidence: Evidence) -> Iterator[Remark]:
    """Segments in which the table stream, where there is one, leaves out a stretch."""
    table, imu = recording.table, recording.imu
    if table is None or not recording.manifest.station.table_axes:
        return
    rows = {s.segment.name: imu.rows(s.t_start, s.t_end) for s in evidence.segments}
    bare = {name: imu.t[row][~covered(table.t, imu.t[row])] for name, row in rows.items()}
    first = {name: float(t[0]) for name, t in bare.items() if len(t)}
    if first:
        listed = ", ".join(f"{name} from t = {t:.2f} s" for name, t in first.items())
        yield Remark(
            code="table_gap",
            en=f"The table stream does not cover {len(first)} segments, of which the labels alone "
            f"tell the attitude and rate: {listed}.",
            zh=f"转台数据未覆盖 {len(first)} 段，其姿态和角速率仅由标注得到：{listed}。",
            segments=tuple(first),
            blocks_pass=True,
        )


def _used(evidence: Evidence, i: int) -> SegmentUsed:
    summary = evidence.segments[i]
    return SegmentUsed(
        name=summary.segment.name,
        kind=summary.segment.kind,
        t_start=summary.segment.t_start,
        t_end=summary.segment.t_end,
        origin=summary.origin,
        up=evidence.up[i],
        axis=summary.segment.axis,
        rate_deg_s=summary.segment.rate_deg_s,
        rows=summary.rows,
        rows_left_out=summary.left_out,
    )


def _environment_seen(environment: Stream | None) -> EnvironmentSeen:
    def extent(name: str) -> tuple[float, float] | None:
        if environment is None or name not in environment.columns:
            return None
        values = environment.columns[name]
        return float(values.min()), float(values.max())

    return EnvironmentSeen(
        temperature_degc=extent("temperature"), humidity_percent=extent("humidity")
    )
