"""The verdict on a unit: its results against the limits of its product model.

Nothing passes by default: what is missing, not finite, too uncertain, not validated or measured
outside the conditions is inconclusive.
"""

import math
from collections.abc import Iterator
from typing import Any

from schemas.base import Unusable
from schemas.calibration import Calibration, Elements, Item
from schemas.decision import Decision, LimitDecision, Verdict
from schemas.text import Statement, texts_fields
from schemas.tolerance import Limit, Tolerance
from tasks.conformity.equipment import taken_to_be_met
from tasks.conformity.reasons import (
    Doubts,
    is_doubted,
    missing,
    outside,
    too_uncertain,
    without_uncertainty,
)
from tasks.conformity.rules import (
    Criterion,
    criterion,
    global_risks,
    probability_of_conformity,
    probability_of_nonconformity,
)
from tasks.specifications.items import ITEMS, second_value
from tasks.words import Message, Sayable, message, statement

WHOLE = ("all",)  # an item of which nothing is known but that it is unavailable


def decide(
    calibration: Calibration,
    tolerance: Tolerance | None,
    doubts: tuple[Sayable, ...] = (),
    doubts_of: Doubts | None = None,
) -> Decision:
    """The verdict on a calibration, limit by limit and overall.

    Fail if any limited element fails by its decision rule; else inconclusive if a limited element
    has no value, no uncertainty above zero or one too large for its rule, if a remark blocks a
    pass, if U of a limited element rests on limits of a specification that the equipment is only
    assumed to meet, if there are `doubts` (further reasons, such as those of `expired`), or if
    there is no tolerance; else pass. `doubts_of` an item, by its name, leave its limited elements
    undecided whatever their values, and do not count if none is limited.

    An invalid run gives no verdict on any element, neither pass nor fail: only its reasons count.

    A fail outranks the remarks that block a pass and the doubts about the whole run: they say that
    conformity was not shown, and a value outside its limits does not show it either. To reject too
    often costs a repetition, which the reasons name; to hide a failing value behind an open
    condition would let a bad unit pass as merely undecided.

    Raises Unusable if the tolerance does not apply to this calibration: unknown item or element,
    another unit.
    """
    doubts_of = doubts_of or {}
    decisions = tuple(_decisions(calibration, tolerance, doubts_of)) if tolerance else ()
    reasons: list[Sayable] = [] if tolerance else [message("conformity-no-tolerance")]
    if calibration.validity.verdict == "invalid":
        reasons.insert(0, message("conformity-invalid-run"))
    else:
        reasons += _reasons(calibration, decisions, doubts_of)
        reasons += taken_to_be_met(calibration, decisions)
    doubted = (each.item for each in decisions if is_doubted(doubts_of, each.item, each.element))
    reasons += [doubts_of[item].sentence for item in dict.fromkeys(doubted)]
    reasons += doubts
    reasons += [remark for remark in calibration.remarks if remark.blocks_pass]
    statements = tuple(dict.fromkeys(map(statement, reasons)))
    verdict = _overall(decisions, statements)
    return Decision(
        verdict=verdict,
        rule=tolerance.rule if tolerance else "simple_acceptance",
        document=tolerance.document if tolerance else None,
        limits=decisions,
        **texts_fields("reasons", statements),
        marginal=_marginal(decisions, verdict),
    )


def _overall(decisions: tuple[LimitDecision, ...], reasons: tuple[Statement, ...]) -> Verdict:
    if any(decided.verdict == "fail" for decided in decisions):
        return "fail"
    if decisions and not reasons and all(decided.verdict == "pass" for decided in decisions):
        return "pass"
    return "inconclusive"


def _marginal(decisions: tuple[LimitDecision, ...], verdict: Verdict) -> bool:
    """One doubtful element makes a pass conditional; one beyond doubt makes a fail a plain one."""
    marks = [decided.marginal for decided in decisions if decided.verdict == verdict]
    return {"pass": any(marks), "fail": all(marks), "inconclusive": False}[verdict]


def _decisions(
    calibration: Calibration, tolerance: Tolerance, doubts_of: Doubts
) -> Iterator[LimitDecision]:
    for limit in tolerance.limits:
        check(calibration, limit)
        item, rule = calibration.items.get(limit.item), criterion(tolerance, limit)
        undecided = withdrawn(calibration, limit.item)
        undecided = undecided or calibration.validity.verdict == "invalid"
        for element in limited(item, limit):
            doubted = is_doubted(doubts_of, limit.item, element)
            yield _decision(limit, rule, element, item, undecided or doubted)


def _decision(
    limit: Limit, rule: Criterion, element: str, item: Item | None, undecided: bool
) -> LimitDecision:
    """The verdict on one element, by its U where that is above zero."""
    value = _at(getattr(item, limit.applied_to), element) if item else None
    U = _expanded_uncertainty(item, limit, element) if item else None
    accepted = _acceptance_interval(rule, U)
    verdict: dict[str, Any] = {"verdict": "inconclusive"}
    if item and U and value is not None and not undecided:
        budget = item.budgets.get(element)
        dof = budget.dof if budget else math.inf
        verdict = _verdict(limit, rule, value, U, U / item.k, dof)
    return LimitDecision(
        item=limit.item,
        element=element,
        unit=limit.unit,
        applied_to=limit.applied_to,
        value=value,
        U=U,
        k=item.k if item else None,
        lower=_finite(rule.lower),
        upper=_finite(rule.upper),
        nominal=limit.nominal,
        rule=rule.rule,
        guard_band_factor=rule.factor,
        accept_lower=accepted[0],
        accept_upper=accepted[1],
        capability=_finite(rule.capability(U)) if U else None,
        min_capability=rule.min_capability,
        U_max=rule.U_max,
        **verdict,
    )


def _acceptance_interval(rule: Criterion, U: float | None) -> tuple[float | None, float | None]:
    """The acceptance limits; none where U is so large that they would have changed sides."""
    low, high = rule.accepted(U) if U else (math.nan, math.nan)
    return (_finite(low), _finite(high)) if low <= high else (None, None)


def _expanded_uncertainty(item: Item, limit: Limit, element: str) -> float | None:
    """U of the quantity that a limit is applied to, where it is above zero."""
    without_earth = limit.applied_to == "value_without_earth_rotation"
    own = item.U_without_earth_rotation if without_earth else None
    U = _at(own or item.U, element)
    return U if U and U > 0 else None


def _verdict(
    limit: Limit, rule: Criterion, value: float, U: float, u: float, dof: float
) -> dict[str, Any]:
    """The verdict with its risk; dof: those of the element's budget, infinite without one."""
    about = (value, u, rule.limits, dof)
    conforms, not_so = probability_of_conformity(*about), probability_of_nonconformity(*about)
    verdict = rule.verdict(value, U, conforms)
    if verdict == "inconclusive":
        shown = {"probability_of_conformity": conforms} if rule.unbounded else {}
        return {"verdict": verdict, **shown}
    accepted = verdict == "pass"
    risk: dict[str, Any] = {
        "false_acceptance": not_so if accepted else None,
        "false_rejection": None if accepted else conforms,
    }
    if limit.prior:
        risk["global_risks"] = global_risks(limit.prior, u, rule.limits, rule.accepted(U))
    return {
        "verdict": verdict,
        "marginal": rule.marginal(value, U, verdict),
        "probability_of_conformity": conforms,
        **risk,
    }


def _at(values: Elements | None, element: str) -> float | None:
    return _finite((values or {}).get(element))


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _reasons(
    calibration: Calibration, decisions: tuple[LimitDecision, ...], doubts_of: Doubts
) -> list[Message]:
    """Why limited elements did not pass: outside, too uncertain, without U, without a value."""
    undecided = [d for d in decisions if d.verdict == "inconclusive"]
    absent = [d for d in undecided if d.value is None or withdrawn(calibration, d.item)]
    bare = [d for d in undecided if d not in absent and d.U is None]
    explained = [*absent, *bare]
    vague = [
        d for d in undecided if d not in explained and not is_doubted(doubts_of, d.item, d.element)
    ]
    return [
        *(outside(decided) for decided in decisions if decided.verdict == "fail"),
        *map(too_uncertain, vague),
        *without_uncertainty(bare),
        *missing(calibration, absent),
    ]


def check(calibration: Calibration, limit: Limit) -> None:
    """Raises Unusable for an unknown item, element or quantity, or another unit."""
    place = f"The tolerance limits {limit.item}"
    item = calibration.items.get(limit.item)
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
    if limit.applied_to not in ("value", second_value(limit.item)):
        raise Unusable(
            f"{place} with applied_to = {limit.applied_to!r}, a quantity that this item does not "
            "have: apply the limit to 'value'."
        )


def limited(item: Item | None, limit: Limit) -> tuple[str, ...]:
    """The elements that a limit is about."""
    return limit.elements or _elements(item, limit.item)


def withdrawn(calibration: Calibration, name: str) -> bool:
    """Whether an item is unavailable as a whole although all its numbers are there."""
    item = calibration.items.get(name)
    if name not in calibration.unavailable or item is None:
        return name in calibration.unavailable
    second = getattr(item, second_value(name) or "value")
    return second is not None and None not in (*item.value.values(), *second.values())


def _elements(item: Item | None, name: str) -> tuple[str, ...]:
    """Every element the item has; those of the specification also where the result lacks them."""
    named = ITEMS[name].elements if name in ITEMS else ()
    return tuple(dict.fromkeys((*named, *(item.value if item else ())))) or WHOLE
