"""The calibration of a recording by a specification."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from schemas.calibration import (
    Calibration,
    Covariance,
    Elements,
    EnvironmentSeen,
    Item,
    SegmentUsed,
)
from schemas.recording import Recording, Stream
from schemas.text import Remark
from tasks.calibrate.evaluation import EXAMPLE, Evaluation, evaluation_for
from tasks.calibrate.information import information
from tasks.motion.table import squared
from tasks.readings.codes import codes_put_right
from tasks.readings.implausible import KINDS
from tasks.run_validity.judge import run_remarks
from tasks.run_validity.site import laboratory_remarks
from tasks.segments.summarise import CHANNELS
from tasks.specifications.axes_of_table import stand_remarks
from tasks.specifications.covariance import covariance_of
from tasks.specifications.estimate import ClauseResult, ItemEstimate
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.items import ItemDefinition, item_title
from tasks.specifications.specification import Specification
from tasks.words import clauses, message, remark, say


def calibrate(
    specification: Specification,
    recording: Recording,
    *,
    run: str,
    code_version: str,
    evaluation: Evaluation | None = None,
    own_latitude_deg: float | None = None,
) -> Calibration:
    """Every item of the specification that the recording determines, with its remarks and what
    else the recording tells.

    evaluation: of the uncertainties; by default the law of propagation with the limits of the
    recording's specification. own_latitude_deg: the laboratory's, if known. Codes that firmware
    joined wrongly are put right first. Raises Unusable for a recording that the specification's
    method cannot use.
    """
    recording = codes_put_right(recording)
    specification.check(recording)
    evaluation = evaluation or evaluation_for(recording)
    if evaluation.settings.get("axes") == "fixture":
        recording = replace(recording, manifest=squared(recording.manifest))
    evidence = specification.gather(recording)
    made = without_information(
        specification, evidence, evaluation, run=run, code_version=code_version,
        own_latitude_deg=own_latitude_deg,
    )  # fmt: skip
    more = information(evidence, made.items, specification.rate_sensor)
    return made.model_copy(update={"information": more})


def without_information(
    specification: Specification,
    evidence: ClauseEvidence,
    evaluation: Evaluation,
    *,
    run: str = "",
    code_version: str = "",
    own_latitude_deg: float | None = None,
) -> Calibration:
    """The items and remarks of a recording's evidence alone, for one of many calibrations that
    are compared item by item.
    """
    result = specification.estimate(evidence, evaluation.equipment)
    items = {
        item.key: evaluation.item(item, result.items[item.key]).model_copy(
            update={"temperature_degc": _temperatures(item, result.items[item.key], evidence)}
        )
        for item in specification.items
    }
    checked = (
        *run_remarks(evidence, specification.conditions, items),
        *(stand_remarks(evidence) if evaluation.equipment.axes else ()),
        *laboratory_remarks(evidence.recording, own_latitude_deg),
        *_unstated(items),
        *_at_temperatures(items),
    )
    wrong = tuple(one for one in checked if one.code in KINDS)
    checked = tuple(one for one in checked if one.code not in KINDS)
    missing = {key: result.unavailable[key] for key in items if key in result.unavailable}
    return Calibration(
        recording_id=evidence.recording.manifest.recording_id,
        run=run,
        digest=evidence.recording.digest,
        method=specification.method,
        code_version=code_version,
        procedure=specification.procedure,
        settings={
            "gravity_m_s2": evidence.gravity,
            "latitude_deg": evidence.latitude_deg,
            **evaluation.settings,
        },
        items=items,
        covariance=_covariance(result, evidence, items),
        unavailable={key: say(why, "en") for key, why in missing.items()},
        unavailable_zh={key: say(why, "zh") for key, why in missing.items()},
        remarks=(*wrong, *result.remarks, *evaluation.remarks, *checked),
        segments=tuple(_used(evidence, i) for i in range(len(evidence.segments))),
        environment=EnvironmentSeen(
            temperature_degc=_extent(evidence.recording.environment, "temperature"),
            humidity_percent=_extent(evidence.recording.environment, "humidity"),
        ),
    )


def _covariance(
    result: ClauseResult, evidence: ClauseEvidence, items: Mapping[str, Item]
) -> Covariance | None:
    """Of the elements that have a budget and are combinations of the segment means."""
    if result.errors is None or any(item.uncertainty_kind == EXAMPLE for item in items.values()):
        return None
    found = {
        f"{key}.{element}": estimate
        for key, item in result.items.items()
        if key in items
        for element, estimate in item.elements.items()
        if element in items[key].budgets and estimate.operator is not None
    }
    if not found:
        return None
    matrix = covariance_of(tuple(found.values()), evidence, result.errors)
    rows = tuple(tuple(map(float, row[: p + 1])) for p, row in enumerate(matrix))
    return Covariance(elements=tuple(found), rows=rows)


def _temperatures(
    definition: ItemDefinition, item: ItemEstimate, evidence: ClauseEvidence
) -> Elements | None:
    """At which temperature of the unit each element holds: of the segments as they weigh in it.

    A segment weighs by the operator that makes the value of the means; in a ratio to an input by
    what its reading gives, for a rest with none has no part in it.
    """
    at = evidence.temperatures
    known = np.isfinite(at)
    if not known.any():
        return None
    found: Elements = {}
    for element, estimate in item.elements.items():
        if estimate.operator is None:
            continue
        read = np.nan_to_num(evidence.means).T if definition.unit == "1" else 1.0
        weights = np.abs(estimate.operator * read).sum(axis=0) * known
        if weights.any():
            found[element] = round(float(weights @ np.nan_to_num(at) / weights.sum()), 2)
    return found or None


def _at_temperatures(items: Mapping[str, Item]) -> Iterator[Remark]:
    """At which temperatures of the unit the elements hold, where it was recorded."""
    held = [
        message(
            "specifications-temperatures.item", item=item_title(key),
            at=", ".join(f"{e} {t:.2f}" for e, t in item.temperature_degc.items() if t is not None),
        )
        for key, item in items.items()
        if item.temperature_degc
    ]  # fmt: skip
    if held:
        yield remark("temperatures", message("specifications-temperatures", items=clauses(held)))


def _unstated(items: Mapping[str, Item]) -> Iterator[Remark]:
    """That elements have no U, because nobody states the largest error of what they hang on."""
    lacking = [
        message(
            "specifications-unstated.item", item=item_title(key),
            elements=", ".join(item.repeatability),
            u=f"{max(filter(None, item.repeatability.values()), default=0.0):.1e}", unit=item.unit,
        )
        for key, item in items.items() if item.repeatability
    ]  # fmt: skip
    if lacking:
        phrase = message("specifications-unstated", items=clauses(lacking))
        yield remark("reference_unstated", phrase, blocks_pass=True)


def _used(evidence: ClauseEvidence, i: int) -> SegmentUsed:
    summary = evidence.segments[i]
    return SegmentUsed(
        **summary.segment.model_dump(
            include={"name", "kind", "t_start", "t_end", "axis", "rate_deg_s"}
        ),
        origin=summary.origin,
        up=evidence.up[i],
        rows=summary.rows,
        rows_left_out=summary.left_out,
        mean=_recorded(summary.mean),
        deviation=_recorded(summary.deviation),
    )


def _recorded(of_channels: np.ndarray) -> dict[str, float]:
    """(6,) as numbers by the names of the channels; without those that were not recorded."""
    named = zip(CHANNELS, of_channels.tolist(), strict=True)
    return {name: value for name, value in named if math.isfinite(value)}


def _extent(environment: Stream | None, name: str) -> tuple[float, float] | None:
    if environment is None or name not in environment.columns:
        return None
    values = environment.columns[name]
    return float(values.min()), float(values.max())
