"""The calibration of a recording by a specification."""

import hashlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError

from schemas.base import Unusable
from schemas.calibration import (
    Budget,
    Calibration,
    Covariance,
    Elements,
    EnvironmentSeen,
    Item,
    SegmentUsed,
    UncertaintyKind,
)
from schemas.laboratory import EquipmentLimit, LimitName, ResultAxes
from schemas.recording import Recording, Stream
from schemas.text import Remark
from tasks.calibrate.information import information
from tasks.motion.table import off_square, squared
from tasks.motion.whole import polled_within
from tasks.readings.codes import codes_put_right
from tasks.readings.plausibility import KINDS
from tasks.run_validity.judge import run_remarks
from tasks.run_validity.site import laboratory_remarks
from tasks.segments.rates import commanded_bound
from tasks.segments.summarise import CHANNELS
from tasks.specifications.equipment_errors import stand_remarks
from tasks.specifications.estimate import (
    ClauseResult,
    Estimate,
    Estimates,
    ItemDefinition,
    ItemEstimate,
    Specification,
    covariance_of,
    item_title,
)
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.register import BY_STANDARD
from tasks.uncertainty.budget import combine
from tasks.uncertainty.equipment import (
    UNKNOWN,
    Equipment,
    with_limits,
    with_polled_encoders,
    with_rates_by_label,
)
from tasks.uncertainty.monte_carlo import (
    BITS,
    TABLE,
    combine_as_example,
    monte_carlo,
    with_monte_carlo,
)
from tasks.uncertainty.monte_carlo import EXAMPLE as BY_APPENDIX
from tasks.words import clauses, message, remark, say
from tasks.words.numbers import USUAL_K

# Evaluates the uncertainty of every element of a calibration, and makes items of them.

ENOUGH_DOF = 50.0  # effective degrees of freedom below which k = 2 covers too little
MAX_BITS = 64.0
EFFECTIVE_BITS = TypeAdapter(Annotated[float, Field(ge=1.0, le=MAX_BITS)])
EXAMPLE: UncertaintyKind = "as the specification's example"
BY_EXAMPLE = "the example's"
NO_SPECIFICATION = (UNKNOWN, "table and fixture not known")


@dataclass(frozen=True)
class Evaluation:
    """The equipment's limits and which way a budget is made.

    seed: of the draws, where it is made by Monte Carlo. table, bits: u₁ and N of Appendix A;
    table_source: who states u₁.
    settings, remarks: what a result has to say of it.
    """

    equipment: Equipment
    kind: UncertaintyKind = "GUM"
    seed: str = ""
    table: float = TABLE
    table_source: str = BY_APPENDIX
    bits: float = BITS
    settings: Mapping[str, str | float] = field(default_factory=dict)
    remarks: tuple[Remark, ...] = ()

    def budget(self, item: ItemDefinition, element: str, estimate: Estimate) -> Budget:
        """The budget of one element: propagated, drawn, or as Appendix A does it."""
        result, unit = f"{item.key}.{element}", item.unit
        if self.kind == "GUM":
            return combine(result, unit, estimate.value, estimate.lines_in(unit))
        if self.kind == "Monte Carlo":
            return monte_carlo_budget(item, element, estimate, self.seed)
        data = estimate.lines[0]
        repeated = estimate.repeated or (data.quantity.u * abs(data.sensitivity),)
        return combine_as_example(
            result, unit, estimate.value, repeated, self.table, self.bits, self.table_source
        )

    def item(self, definition: ItemDefinition, estimate: ItemEstimate) -> Item:
        """An item with the budget of each element; null where an element is not determined.

        A value whose uncertainty the recording does not show (turns alone, say) has none and no
        budget. k is 2, or, where an element has fewer than 50 effective degrees of freedom, the
        largest k of the item's elements rounded up to two decimals; every budget of the item then
        states it. By Monte Carlo it is always that largest k.
        """
        budgets = self._budgets(definition, estimate.elements)
        k = common_factor(budgets)
        budgets = {e: expanded(budget, k) for e, budget in budgets.items()}
        item = Item(
            unit=definition.unit,
            clause=estimate.clause,
            value=_values(estimate.elements),
            u={e: budgets[e].u_c if e in budgets else None for e in estimate.elements},
            U={e: budgets[e].U if e in budgets else None for e in estimate.elements},
            k=k,
            uncertainty_kind=self.kind,
            budgets=budgets,
            readings=estimate.readings,
            repeatability=self._repeatability(estimate.elements) or None,
        )
        return item.model_copy(update=self._second_value(definition, estimate, item))

    def _budgets(self, definition: ItemDefinition, estimates: Estimates) -> dict[str, Budget]:
        return {
            e: self.budget(definition, e, estimate)
            for e, estimate in estimates.items()
            if estimate.has_uncertainty
            and (estimate.has_repeatability if self.kind == EXAMPLE else not estimate.unstated)
        }

    def _repeatability(self, estimates: Estimates) -> Elements:
        """u_A of the elements that have no U because nobody states what they hang on."""
        if self.kind == EXAMPLE:
            return {}
        return {e: one.u_of_data for e, one in estimates.items() if one.unstated}

    def _second_value(
        self, definition: ItemDefinition, estimate: ItemEstimate, item: Item
    ) -> dict[str, Elements]:
        """The fields of the value beside the clause's own; none where an item has one value."""
        second = estimate.without_earth_rotation
        if definition.second_value == "value_model":
            opposite = {e: None if value is None else -value for e, value in item.value.items()}
            return {"value_model": opposite}
        if definition.second_value is None or second is None:
            return {}
        value, u, U = item.value, item.u, item.U
        if second != estimate.elements:
            value, budgets = _values(second), self._budgets(definition, second)
            u = {e: budgets[e].u_c if e in budgets else None for e in second}
            U = {e: None if each is None else item.k * each for e, each in u.items()}
        return {
            "value_without_earth_rotation": value,
            "u_without_earth_rotation": u,
            "U_without_earth_rotation": U,
        }


def _values(estimates: Estimates) -> Elements:
    return {e: estimate.value if estimate.determined else None for e, estimate in estimates.items()}


def evaluation_for(
    recording: Recording,
    kind: UncertaintyKind = "GUM",
    own: Mapping[LimitName, EquipmentLimit] | None = None,
    axes: ResultAxes | None = None,
) -> Evaluation:
    """The evaluation of a recording with the limits of its specification's Table 1.

    own: a laboratory's limits, which go before them. Of a recording without specification
    the equipment is not known: then gravity and latitude alone are counted, and the result says so.
    axes: about which the results are: those of the mounting plane count its limit, and give no pass
    without one; those of the unit and of the fixture leave it out. None: those of the mounting
    plane where it has a limit that counts, else those of the unit where a mount states them.
    Raises Unusable where the unit's `effective_bits` are no number of bits, or `table_time` does
    not say within how many seconds the times of polled encoders are known.
    """
    counts = own is not None and "mounting" in own and kind != EXAMPLE
    off = off_square(recording.manifest)
    axes = axes or ("mounting plane" if counts else "unit" if off else "fixture")
    plane = axes == "mounting plane"
    own = {n: limit for n, limit in (own or {}).items() if n != "mounting" or plane}
    specification = BY_STANDARD.get(recording.manifest.standard)
    equipment, named = NO_SPECIFICATION
    if specification is not None:
        equipment, named = specification.equipment, specification.equipment_source
    equipment = with_limits(equipment, own)
    if half_width_s := polled_within(recording):
        equipment = with_polled_encoders(equipment, half_width_s, commanded_bound(recording))
    elif recording.table is None and "rate" not in own:
        equipment = with_rates_by_label(equipment, commanded_bound(recording))
    settings: dict[str, str | float] = {"uncertainty": kind, "axes": axes}
    remarks: tuple[Remark, ...] = ()
    if off:
        settings["mount"] = float(f"{np.degrees(off):.4g}")
    if plane and not counts:
        phrase = message("specifications-mounting-unknown")
        remarks = (remark("mounting_unknown", phrase, blocks_pass=True),)
    table, table_source, bits = TABLE, BY_APPENDIX, _bits(recording)
    if kind != EXAMPLE:
        settings["limits"] = named
        for name, limit in own.items():
            settings[f"limit of {name}"] = f"{limit.half_width:g} ({limit.source})"
        if specification is None and not equipment.known:
            phrase = message("specifications-equipment-unknown")
            remarks = (remark("equipment_unknown", phrase, blocks_pass=True), *remarks)
        return Evaluation(equipment, kind, recording.digest, settings=settings, remarks=remarks)
    if "rate" in own:
        table = max(limit.u for _, limit in equipment.rates)
        table_source = own["rate"].source
    settings["u1 of the table"] = (
        f"{table:g} ({own['rate'].source if 'rate' in own else BY_EXAMPLE})"
    )
    settings["effective bits"] = f"{bits:g} (the unit's)" if bits else f"{BITS} ({BY_EXAMPLE})"
    return Evaluation(
        equipment, kind, table=table, table_source=table_source, bits=bits or BITS,
        settings=settings, remarks=remarks,
    )  # fmt: skip


def common_factor(budgets: Mapping[str, Budget]) -> float:
    """The coverage factor of an item, see `Evaluation.item`."""
    drawn = any(budget.evaluation == "Monte Carlo" for budget in budgets.values())
    if not drawn and all(budget.dof >= ENOUGH_DOF for budget in budgets.values()):
        return USUAL_K
    return math.ceil(100.0 * max(budget.k for budget in budgets.values()) - 1e-9) / 100.0


def expanded(budget: Budget, k: float) -> Budget:
    """A budget stated with the coverage factor of its item."""
    return budget if budget.k == k else budget.model_copy(update={"k": k, "U": k * budget.u_c})


def _bits(recording: Recording) -> float | None:
    """`effective_bits` of the manifest's unit, None where it has none."""
    stated = (recording.manifest.unit.model_extra or {}).get("effective_bits")
    if stated is None:
        return None
    try:
        return EFFECTIVE_BITS.validate_python(stated, strict=True)
    except ValidationError as error:
        raise Unusable(
            f"{recording.manifest.recording_id}: manifest.json says unit.effective_bits = "
            f"{stated!r}, not a number of bits from 1 to {MAX_BITS:.0f}; correct it or leave it out"
        ) from error


# Monte Carlo evaluation of one element (JCGM 101): inputs drawn and put through its equation.
#
# Every item is a sum over its inputs, and some are divided by what the equipment states: a scale
# factor by the rate, an accelerometer's by gravity, p by the square of the rate, a misalignment by
# the angle turned. With the contributions cᵢδᵢ and the power n of the divisor
#
#     y = (y₀ + Σ cᵢδᵢ)/(1 − Σ cⱼδⱼ/(n·y₀))ⁿ,
#
# i over what is summed, j over what the divisor is made of: to first order the law of propagation.


def monte_carlo_budget(item: ItemDefinition, element: str, estimate: Estimate, seed: str) -> Budget:
    """The budget of one element with u, U and interval by Monte Carlo, to two figures of u.

    seed: any text, the digest of the recording; the same text gives the same draws bit for bit,
    and every element its own.
    Raises Unusable where the draws do not settle.
    """
    result, value, lines = f"{item.key}.{element}", estimate.value, estimate.lines_in(item.unit)
    budget = combine(result, item.unit, value, lines)
    if budget.u_c == 0.0:
        return budget.model_copy(update={"evaluation": "Monte Carlo"})
    divides = [bool(value) and line.quantity.symbol in item.divisor for line in lines]

    def equation(*errors: np.ndarray) -> np.ndarray:
        total, divisor = np.full_like(errors[0], value), np.ones_like(errors[0])
        for line, error, below in zip(lines, errors, divides, strict=True):
            if below:
                divisor -= line.sensitivity * error / (item.power * value)
            else:
                total += line.sensitivity * error
        return np.asarray(total / divisor**item.power)

    number = int.from_bytes(hashlib.sha256(f"{seed} {result}".encode()).digest()[:8])
    errors = [
        replace(line.quantity, estimate=0.0, distribution=line.distribution) for line in lines
    ]
    return with_monte_carlo(budget, monte_carlo(equation, errors, seed=number))


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
    known = {
        key: {e: f"{t:.2f}" for e, t in (item.temperature_degc or {}).items() if t is not None}
        for key, item in items.items()
    }
    every = {at for of_item in known.values() for at in of_item.values()}
    if len(every) == 1:
        yield remark("temperatures", message("specifications-temperature", at=every.pop()))
        return
    held = [
        message(
            "specifications-temperatures.item", item=item_title(key),
            at=", ".join(f"{e} {t}" for e, t in of_item.items())
            if len(set(of_item.values())) > 1 else min(of_item.values()),
        )
        for key, of_item in known.items() if of_item
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
