"""How the uncertainty of every element of a calibration is evaluated, and items made of them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from pydantic import TypeAdapter, ValidationError

from schemas.base import Unusable
from schemas.calibration import Item, Remark, UncertaintyKind
from schemas.certificate import EquipmentLimit, LimitName
from schemas.recording import Recording, Standard
from schemas.uncertainty import Budget
from tasks.specifications.distributions import drawn
from tasks.specifications.measured import Measured
from tasks.specifications.parts import K_FACTOR
from tasks.uncertainty.budget import combine
from tasks.uncertainty.equipment import JJF1536, JJF2003, UNKNOWN, Equipment, with_limits
from tasks.uncertainty.examples import BITS, TABLE, combine_as_example

ENOUGH_DOF = 50.0  # effective degrees of freedom below which k = 2 covers too little
MOST_BITS = 64.0
EQUIPMENT: dict[Standard, tuple[Equipment, str]] = {
    "JJF 2003-2022": (JJF2003, "JJF 2003-2022, Table 1"),
    "JJF 1536-2015": (JJF1536, "JJF 1536-2015, Table 1"),
    "other": (UNKNOWN, "table and fixture not known"),
}


@dataclass(frozen=True)
class Evaluation:
    """The equipment's limits and which way a budget is made.

    seed: of the draws, where it is made by Monte Carlo. table, bits: u₁ and N of Appendix A.
    settings, remarks: what a result has to say of it.
    """

    equipment: Equipment
    kind: UncertaintyKind = "GUM"
    seed: str = ""
    table: float = TABLE
    bits: float = BITS
    settings: Mapping[str, str | float] = field(default_factory=dict)
    remarks: tuple[Remark, ...] = ()

    def budget(self, result: str, unit: str, found: Measured) -> Budget:
        """The budget of one element: propagated, drawn, or as Appendix A does it."""
        if self.kind == "GUM":
            return combine(result, unit, found.value, found.lines_in(unit))
        if self.kind == "Monte Carlo":
            return drawn(result, unit, found, self.seed)
        repeated = found.repeated or (found.lines[0].quantity.u * abs(found.lines[0].sensitivity),)
        return combine_as_example(result, unit, found.value, repeated, self.table, self.bits)


def evaluation_for(
    recording: Recording,
    kind: UncertaintyKind = "GUM",
    own: Mapping[LimitName, EquipmentLimit] | None = None,
) -> Evaluation:
    """The evaluation of a recording with the limits of its specification's Table 1.

    own: a laboratory's limits, which go before them. A recording of no specification was made on
    nobody knows what: then gravity and latitude alone are counted, and the result says so.
    Raises Unusable where the unit's `effective_bits` are no number of bits.
    """
    own = own or {}
    equipment, named = EQUIPMENT[recording.manifest.standard]
    equipment = with_limits(equipment, own)
    settings: dict[str, str | float] = {"uncertainty": kind}
    table, bits = TABLE, _bits(recording)
    if kind != "as the specification's example":
        settings["limits"] = named
        for name, limit in own.items():
            settings[f"limit of {name}"] = f"{limit.half_width:g} ({limit.source})"
        unknown = not equipment.rates or not equipment.angles
        remarks = (_UNKNOWN_EQUIPMENT,) if unknown else ()
        return Evaluation(equipment, kind, recording.digest, settings=settings, remarks=remarks)
    if "rate" in own:
        table = equipment.rates[0][1].u
    settings["u1 of the table"] = f"{table:g} ({own['rate'].source if 'rate' in own else EXAMPLE})"
    settings["effective bits"] = f"{bits:g} (the unit's)" if bits else f"{BITS} ({EXAMPLE})"
    return Evaluation(equipment, kind, table=table, bits=bits or BITS, settings=settings)


EXAMPLE = "the example's"
_UNKNOWN_EQUIPMENT = Remark(
    code="equipment_unknown",
    en="The recording names no specification, and the laboratory does not tell what its table may "
    "be off by: what is not known of table and fixture is not in the uncertainties, which hold the "
    "scatter of the data, the unit's resolution, gravity and latitude.",
    zh="记录未说明所依据的规范，实验室也未给出转台允许误差：转台和夹具未知的不确定度分量未计入，"
    "不确定度含数据分散性、分辨力、当地重力和纬度的分量。",
    blocks_pass=True,
)


def make_item(
    evaluation: Evaluation,
    name: str,
    found: Mapping[str, Measured],
    unit: str,
    clause: str,
    readings: tuple[str, ...] = (),
) -> Item:
    """An item with the budget of each element; null where an element is not determined.

    A value whose uncertainty the recording does not show (turns alone, say) has none and no budget.
    found: by element, in the item's printed unit. k is 2, or, where an element has fewer than 50
    effective degrees of freedom, the largest k of the item's elements rounded up to two decimals;
    every budget of the item then states it. By Monte Carlo it is always that largest k.
    """
    budgets = {
        e: evaluation.budget(f"{name}.{e}", unit, m) for e, m in found.items() if m.has_uncertainty
    }
    k = common_factor(budgets)
    budgets = {e: expanded(budget, k) for e, budget in budgets.items()}
    none = dict.fromkeys(found)
    return Item(
        unit=unit,
        clause=clause,
        value={e: m.value if math.isfinite(m.value) else None for e, m in found.items()},
        u={**none, **{e: budget.u_c for e, budget in budgets.items()}},
        U={**none, **{e: budget.U for e, budget in budgets.items()}},
        k=k,
        uncertainty_kind=evaluation.kind,
        budgets=budgets,
        readings=readings,
    )


def common_factor(budgets: Mapping[str, Budget]) -> float:
    """The coverage factor of an item, see `make_item`."""
    drawn_ones = any(budget.evaluation == "Monte Carlo" for budget in budgets.values())
    if not drawn_ones and all(budget.dof >= ENOUGH_DOF for budget in budgets.values()):
        return K_FACTOR
    return math.ceil(100.0 * max(budget.k for budget in budgets.values()) - 1e-9) / 100.0


def expanded(budget: Budget, k: float) -> Budget:
    """A budget stated with the coverage factor of its item."""
    return budget if budget.k == k else budget.model_copy(update={"k": k, "U": k * budget.u_c})


def _bits(recording: Recording) -> float | None:
    """`effective_bits` of the manifest's unit, None where it does not tell."""
    told = (recording.manifest.unit.model_extra or {}).get("effective_bits")
    if told is None:
        return None
    try:
        bits = TypeAdapter(float).validate_python(told, strict=True)
    except ValidationError:
        bits = math.nan
    if not 1.0 <= bits <= MOST_BITS:
        raise Unusable(
            f"{recording.manifest.recording_id}: manifest.json says unit.effective_bits = "
            f"{told!r}, no number of bits from 1 to {MOST_BITS:.0f}; correct it or leave it out"
        )
    return bits
