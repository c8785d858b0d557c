"""The result of a calibration: items in their order, reasons, remarks, segments, environment."""

from collections.abc import Mapping

from schemas.calibration import Calibration, EnvironmentSeen, Information, Item, SegmentUsed
from schemas.recording import Stream
from schemas.text import Remark
from tasks.specifications.evidence import Evidence
from tasks.specifications.specification import Specification
from tasks.words import Sayable, say


def build(
    specification: Specification,
    evidence: Evidence,
    items: Mapping[str, Item],
    unavailable: Mapping[str, Sayable],
    *,
    remarks: tuple[Remark, ...],
    information: Mapping[str, Information],
    settings: Mapping[str, str | float],
    run: str,
    code_version: str,
) -> Calibration:
    """The document of a calibration; items: with their budgets, in the specification's order.

    unavailable: why items, or elements of them, have no value; settings: of the evaluation.
    """
    recording = evidence.recording
    missing = {key: unavailable[key] for key in items if key in unavailable}
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
            **settings,
        },
        items=dict(items),
        information=dict(information),
        unavailable={key: say(why, "en") for key, why in missing.items()},
        unavailable_zh={key: say(why, "zh") for key, why in missing.items()},
        remarks=remarks,
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
