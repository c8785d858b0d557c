"""The verdict on a unit: its results against the limits of its product model.

Simple acceptance (JCGM 106, 8.2): a measured value inside its limits conforms. Nothing passes by
default: what is missing, not finite, too uncertain or measured outside the conditions is
inconclusive.
"""

import math
from collections.abc import Iterable, Iterator
from datetime import date

from schemas.base import Unusable
from schemas.calibration import Calibration, Item
from schemas.station import Equipment
from schemas.tolerance import Decision, Limit, LimitDecision, Tolerance, Verdict, bounds
from tasks.certificate.names import ITEMS, SECOND_VALUE
from tasks.certificate.reasons import (
    Reason,
    missing,
    outside,
    too_uncertain,
    without_uncertainty,
)

NO_TOLERANCE = ("no limits were given for this product model", "未提供该型号的允许限")
WHOLE = ("all",)  # an item of which nothing is known but that it is unavailable


def decide(
    calibration: Calibration, tolerance: Tolerance | None, doubts: tuple[Reason, ...] = ()
) -> Decision:
    """The verdict on a calibration, limit by limit and overall.

    Fail if any limited element is outside its limits; else inconclusive if a limited element
    has no value, no uncertainty above zero or one that is larger than half the interval of its
    limits, if a remark blocks a pass, if there are `doubts` (further reasons, like `expired`
    gives), or if there is no tolerance; else pass. A lower or an upper limit alone is
    one-sided. Raises Unusable where the tolerance does not speak of this calibration: unknown
    item or element, another unit.
    """
    limits = tolerance.limits if tolerance else ()
    decisions = tuple(made for limit in limits for made in _against(calibration, limit))
    reasons = [] if tolerance else [NO_TOLERANCE]
    reasons += _of_limits(calibration, decisions)
    reasons += doubts
    reasons += [(remark.en, remark.zh) for remark in calibration.remarks if remark.blocks_pass]
    reasons = list(dict.fromkeys(reasons))
    return Decision(
        verdict=_overall(decisions, reasons),
        rule=tolerance.rule if tolerance else "simple_acceptance",
        document=tolerance.document if tolerance else None,
        limits=decisions,
        reasons=tuple(en for en, _ in reasons),
        reasons_zh=tuple(zh for _, zh in reasons),
    )


def expired(equipment: Iterable[Equipment], on: date) -> tuple[Reason, ...]:
    """A reason against a pass for each standard whose certificate had run out on a day."""
    return tuple(
        (
            f"{each.name} ({each.serial}): its certificate was valid until {each.valid_until}, "
            f"before {on}",
            f"{each.name_zh or each.name}（{each.serial}）：其证书有效期至 {each.valid_until}，"
            f"早于 {on}",
        )
        for each in equipment
        if each.valid_until and each.valid_until < on
    )


def _overall(decisions: tuple[LimitDecision, ...], reasons: list[Reason]) -> Verdict:
    if any(made.verdict == "fail" for made in decisions):
        return "fail"
    if decisions and not reasons and all(made.verdict == "pass" for made in decisions):
        return "pass"
    return "inconclusive"


def _against(calibration: Calibration, limit: Limit) -> Iterator[LimitDecision]:
    item = calibration.items.get(limit.item)
    _check(calibration, item, limit)
    for element in _limited(item, limit):
        value = _finite(getattr(item, limit.applied_to, None), element)
        U = _finite(item.U if item else None, element)
        yield LimitDecision(
            item=limit.item,
            element=element,
            unit=limit.unit,
            applied_to=limit.applied_to,
            value=value,
            U=U,
            lower=bounds(limit)[0],
            upper=bounds(limit)[1],
            verdict=_verdict(value, U, limit, _withdrawn(calibration, limit.item)),
        )


def _verdict(value: float | None, U: float | None, limit: Limit, withdrawn: bool) -> Verdict:
    """What lies outside with the whole of value ± U fails, however large U is."""
    if value is None or U is None or U <= 0 or withdrawn:
        return "inconclusive"
    lower, upper = _interval(*bounds(limit))
    too_wide = (upper - lower) / 2 < U
    if too_wide and value + U >= lower and value - U <= upper:
        return "inconclusive"
    return "pass" if lower <= value <= upper else "fail"


def _interval(lower: float | None, upper: float | None) -> tuple[float, float]:
    return -math.inf if lower is None else lower, math.inf if upper is None else upper


def _check(calibration: Calibration, item: Item | None, limit: Limit) -> None:
    """Raises Unusable where a limit and the calibration do not speak of the same thing."""
    place = f"The tolerance limits {limit.item}"
    if item is None and limit.item not in calibration.unavailable:
        known = ", ".join(sorted({*calibration.items, *calibration.unavailable}))
        raise Unusable(
            f"{place}, which calibration {calibration.run} by {calibration.method} does not "
            f"have: name one of {known}, or remove the limit."
        )
    unit = item.unit if item else ITEMS[limit.item].unit if limit.item in ITEMS else limit.unit
    if limit.unit != unit:
        raise Unusable(
            f"{place} in {limit.unit!r} but the result is in {unit!r}: give the limit in {unit!r}."
        )
    known_elements = _elements(item, limit.item)
    strange = [element for element in limit.elements or () if element not in known_elements]
    if limit.elements == () or (strange and known_elements != WHOLE):
        raise Unusable(
            f"{place} for the elements {strange}, but this item has "
            f"{', '.join(known_elements)}: name some of these or leave `elements` out."
        )
    if limit.applied_to not in ("value", SECOND_VALUE.get(limit.item)):
        raise Unusable(
            f"{place} with applied_to = {limit.applied_to!r}, a quantity that this item does not "
            "have: apply the limit to 'value'."
        )


def _elements(item: Item | None, name: str) -> tuple[str, ...]:
    """Every element the item has; those of the specification also where the result lacks them."""
    named = ITEMS[name].elements if name in ITEMS else ()
    return tuple(dict.fromkeys((*named, *(item.value if item else ())))) or WHOLE


def _limited(item: Item | None, limit: Limit) -> tuple[str, ...]:
    return limit.elements or _elements(item, limit.item)


def _finite(values: dict[str, float | None] | None, element: str) -> float | None:
    value = (values or {}).get(element)
    return value if value is not None and math.isfinite(value) else None


def _withdrawn(calibration: Calibration, name: str) -> bool:
    """Whether an item is called unavailable as a whole although all its numbers stand there."""
    item = calibration.items.get(name)
    if name not in calibration.unavailable or item is None:
        return name in calibration.unavailable
    second = getattr(item, SECOND_VALUE[name]) if name in SECOND_VALUE else item.value
    return second is not None and None not in (*item.value.values(), *second.values())


def _of_limits(calibration: Calibration, decisions: tuple[LimitDecision, ...]) -> list[Reason]:
    """Why limited elements did not pass: outside, too uncertain, without U, without a value."""
    open_ = [made for made in decisions if made.verdict == "inconclusive"]
    absent = [made for made in open_ if made.value is None or _withdrawn(calibration, made.item)]
    bare = [made for made in open_ if made not in absent and (made.U is None or made.U <= 0)]
    vague = [made for made in open_ if made not in absent and made not in bare]
    return [
        *(
            outside(made, calibration.items[made.item].k)
            for made in decisions
            if made.verdict == "fail"
        ),
        *map(too_uncertain, vague),
        *without_uncertainty(bare),
        *missing(calibration, absent),
    ]
