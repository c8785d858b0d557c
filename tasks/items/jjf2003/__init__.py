"""JJF 2003-2022, clause 7: every item that a recording allows."""

from collections.abc import Iterator

from schemas.base import Unusable
from schemas.calibration import Calibration, EnvironmentSeen, Remark, SegmentUsed
from schemas.recording import ACCEL, GYRO, MEASURED, Recording, Stream
from tasks.items.evidence import FEWEST_ROWS, Evidence, gather, rows_of
from tasks.items.jjf2003.rate_sensitivity import rate_sensitivity_item
from tasks.items.jjf2003.tumble import tumble_items
from tasks.items.jjf2003.turning import gyro_matrix, turning_items
from tasks.items.parts import Part
from tasks.segments.check import check_segments

PROCEDURE = "JJF 2003-2022, 7.2"
ORDER = (
    "gyro_scale_factor",
    "gyro_cross_coupling",
    "gyro_fit_offset",
    "gyro_bias",
    "gyro_g_sensitivity",
    "accel_scale_factor",
    "accel_cross_coupling",
    "accel_bias",
    "accel_rate_sensitivity",
)


def calibrate(recording: Recording, *, run: str, code_version: str) -> Calibration:
    """Estimate the eight items of JJF 2003-2022 (Table 2) and the fit offset of eq. (4).

    Raises Unusable where the recording holds neither gyro nor accelerometer readings.
    """
    if not any(name in recording.imu.columns for name in GYRO + ACCEL):
        raise Unusable(
            f"{recording.manifest.recording_id}: there are no gyro_* or accel_* columns, which JJF "
            "2003 calibrates; a recording of accumulated angles belongs to JJF 1536"
        )
    evidence = gather(recording)
    turning = turning_items(recording, evidence)
    tumble = tumble_items(recording, evidence, gyro_matrix(turning))
    parts = (turning, tumble, rate_sensitivity_item(evidence))
    items = {name: item for part in parts for name, item in part.items.items()}
    reasons = {name: reason for part in parts for name, reason in part.unavailable.items()}
    station = recording.manifest.station
    return Calibration(
        recording_id=recording.manifest.recording_id,
        run=run,
        digest=recording.digest,
        method="jjf2003",
        code_version=code_version,
        procedure=PROCEDURE,
        settings={"gravity_m_s2": station.gravity_m_s2, "latitude_deg": station.latitude_deg},
        items={name: items[name] for name in ORDER},
        unavailable={name: reasons[name][0] for name in ORDER if name in reasons},
        unavailable_zh={name: reasons[name][1] for name in ORDER if name in reasons},
        remarks=_remarks(recording, evidence, parts),
        segments=tuple(_used(evidence, i) for i in range(len(evidence.segments))),
        environment=_environment_seen(recording.environment),
    )


def _remarks(
    recording: Recording, evidence: Evidence, parts: tuple[Part, ...]
) -> tuple[Remark, ...]:
    remarks = [remark for part in parts for remark in part.remarks]
    remarks.extend(check_segments(recording, evidence.segments))
    remarks.extend(_without_rows(recording))
    recorded = recording.environment.columns if recording.environment is not None else {}
    if not {"temperature", "humidity"} <= set(recorded):
        remarks.append(
            Remark(
                code="environment_not_recorded",
                en="Air temperature and humidity were not both recorded: whether clause 6.1 was "
                "met is not known.",
                zh="未同时记录环境温度和湿度：无法确认是否满足 6.1 的环境条件。",
                blocks_pass=True,
            )
        )
    return tuple(remarks)


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
