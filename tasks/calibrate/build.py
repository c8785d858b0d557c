"""The result of a calibration: items in their order, reasons, remarks, segments, environment."""

from collections.abc import Mapping

from schemas.calibration import Calibration, EnvironmentSeen, Item, SegmentUsed
from schemas.recording import Stream
from tasks.calibrate.evaluation import Evaluation
from tasks.calibrate.information import information
from tasks.segments.check import check_segments
from tasks.specifications.estimate import ClauseResult
from tasks.specifications.evidence import Evidence
from tasks.specifications.specification import Specification
from tasks.words import say


def build(
    specification: Specification,
    evidence: Evidence,
    result: ClauseResult,
    items: Mapping[str, Item],
    evaluation: Evaluation,
    *,
    run: str,
    code_version: str,
) -> Calibration:
    """The document of a calibration; items: with their budgets, in the specification's order."""
    recording = evidence.recording
    checked = check_segments(
        recording,
        evidence.segments,
        evidence.turning_points,
        specification.conditions,
        channels=evidence.channel_names,
        may_stand_still=evidence.may_stand_still,
    )
    missing = {key: result.unavailable[key] for key in items if key in result.unavailable}
    return Calibration(
        recording_id=recording.manifest.recording_id,
        run=run,
        digest=recording.digest,
        method=specification.method,
        code_version=code_version,
        procedure=specification.procedure,
        settings={
            "gravity_m_s2": evidence.gravity,
            "latitude_deg": evidence.latitude_deg,
            **evaluation.settings,
        },
        items=dict(items),
        information=information(evidence, items, specification.rate_sensor),
        unavailable={key: say(why, "en") for key, why in missing.items()},
        unavailable_zh={key: say(why, "zh") for key, why in missing.items()},
        remarks=(*result.remarks, *evaluation.remarks, *checked),
        segments=tuple(_used(evidence, i) for i in range(len(evidence.segments))),
        environment=_environment(recording.environment),
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


def _environment(environment: Stream | None) -> EnvironmentSeen:
    def extent(name: str) -> tuple[float, float] | None:
        if environment is None or name not in environment.columns:
            return None
        values = environment.columns[name]
        return float(values.min()), float(values.max())

    return EnvironmentSeen(
        temperature_degc=extent("temperature"), humidity_percent=extent("humidity")
    )
