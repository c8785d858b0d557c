"""Evaluates the uncertainty of every element of a calibration, and makes items of them."""

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError

from schemas.base import Unusable
from schemas.calibration import Elements, Item, UncertaintyKind
from schemas.equipment import EquipmentLimit, LimitName, ResultAxes
from schemas.recording import Recording
from schemas.text import Remark
from schemas.uncertainty import Budget
from tasks.motion.polled import polled_within
from tasks.motion.table import off_square
from tasks.segments.commanded_rate import commanded_bound
from tasks.specifications.estimate import Estimate, Estimates, ItemEstimate
from tasks.specifications.items import ItemDefinition
from tasks.specifications.register import BY_STANDARD
from tasks.uncertainty.budget import combine
from tasks.uncertainty.equipment import (
    UNKNOWN,
    Equipment,
    with_limits,
    with_polled_encoders,
    with_rates_by_label,
)
from tasks.uncertainty.examples import BITS, TABLE, combine_as_example
from tasks.uncertainty.examples import EXAMPLE as BY_APPENDIX
from tasks.uncertainty.monte_carlo import monte_carlo, with_monte_carlo
from tasks.words import message, remark
from tasks.words.rounding import USUAL_K

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
