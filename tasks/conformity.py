"""The verdict on a unit: its results against the limits of its product model.

Simple acceptance (JCGM 106, 8.2): a measured value inside its limits conforms. Nothing passes by
default: what is missing, not finite or measured outside the conditions is inconclusive.
"""

import math
from collections.abc import Iterator

from schemas.base import Unusable
from schemas.calibration import Calibration, Item
from schemas.tolerance import Decision, Limit, LimitDecision, Tolerance, Verdict, bounds
from tasks.certificate.names import ITEMS, SECOND_VALUE, item_name, unit_text
from tasks.uncertainty.rounding import MINUS

Reason = tuple[str, str]  # English, Chinese

NO_TOLERANCE = ("no limits were given for this product model", "未提供该型号的允许限")
WHOLE = ("all",)  # an item of which nothing is known but that it is unavailable
NO_CAUSE = ("no cause was given", "未说明原因")


def decide(calibration: Calibration, tolerance: Tolerance | None) -> Decision:
    """The verdict on a calibration, limit by limit and overall.

    Fail if any limited element is outside its limits; else inconclusive if a limited element
    has no value or no uncertainty, a remark blocks a pass, or there is no tolerance; else pass.
    A lower or an upper limit alone is one-sided. Raises Unusable where the
    tolerance does not speak of this calibration: unknown item or element, another unit.
    """
    limits = tolerance.limits if tolerance else ()
    decisions = tuple(made for limit in limits for made in _against(calibration, limit))
    doubts = [] if tolerance else [NO_TOLERANCE]
    doubts += [_outside(made) for made in decisions if made.verdict == "fail"]
    doubts += _missing(calibration, decisions)
    doubts += [(remark.en, remark.zh) for remark in calibration.remarks if remark.blocks_pass]
    reasons = tuple(dict.fromkeys(doubts))
    return Decision(
        verdict=_overall(decisions, reasons),
        rule=tolerance.rule if tolerance else "simple_acceptance",
        document=tolerance.document if tolerance else None,
        limits=decisions,
        reasons=tuple(en for en, _ in reasons),
        reasons_zh=tuple(zh for _, zh in reasons),
    )


def _overall(decisions: tuple[LimitDecision, ...], reasons: tuple[Reason, ...]) -> Verdict:
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
    if value is None or U is None or withdrawn:
        return "inconclusive"
    lower, upper = _interval(*bounds(limit))
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
    return name in calibration.unavailable and (
        item is None or all(value is not None for value in item.value.values())
    )


def _missing(calibration: Calibration, decisions: tuple[LimitDecision, ...]) -> list[Reason]:
    """One reason for each limited item that has elements without a verdict."""
    by_item: dict[str, list[str]] = {}
    for made in decisions:
        if made.verdict == "inconclusive":
            by_item.setdefault(made.item, []).append(made.element)
    reasons = []
    for name, elements in by_item.items():
        zh, en = item_name(name)
        why = calibration.unavailable.get(name, NO_CAUSE[0])
        why_zh = calibration.unavailable_zh.get(name)
        why_zh = why_zh or (why if name in calibration.unavailable else NO_CAUSE[1])
        listed = ", ".join(dict.fromkeys(elements))
        reasons.append(
            (f"{en} ({listed}) not determined: {why}", f"{zh}（{listed}）未得：{why_zh}")
        )
    return reasons


def _outside(made: LimitDecision) -> Reason:
    zh, en = item_name(made.item)
    unit = unit_text(made.unit)
    value = _text(made.value)
    wanted = f"{_text(made.lower)} … {_text(made.upper)}"
    if made.lower is None:
        wanted = f"≤ {_text(made.upper)}"
    elif made.upper is None:
        wanted = f"≥ {_text(made.lower)}"
    return (
        f"{en} ({made.element}): {value} {unit} is outside {wanted} {unit}",
        f"{zh}（{made.element}）：{value} {unit} 超出 {wanted} {unit}",
    )


def _text(number: float | None) -> str:
    return format(number, ".6g").replace("-", MINUS) if number is not None else "—"
