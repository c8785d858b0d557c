"""Why a unit does not pass, and on what condition it does."""

from collections.abc import Iterable
from decimal import Decimal

from schemas.calibration import Calibration
from schemas.discrepancy import Statement
from schemas.tolerance import Decision, LimitDecision
from tasks.conformity.limits import (
    accepted_text,
    limits_text,
    probability_text,
    quantity_title,
    relative_text,
    verdict_title,
)
from tasks.specifications.items import item_title, second_value, symbol
from tasks.words import Message, Sayable, message
from tasks.words.rounding import USUAL_K, exact, round_like, round_up, text
from tasks.words.units import quantity_text


def outside(decided: LimitDecision) -> Message:
    """A value that fails by its rule, with its uncertainty and the risk of having rejected it."""
    limits = _limits(decided)
    where = message("conformity-where.outside", limits=limits)
    if _inside(Decimal(repr(decided.value)), decided.lower, decided.upper):
        accepted = quantity_text(str(accepted_text(decided)), decided.unit)
        where = message("conformity-where.guard-band", limits=limits, accepted=accepted)
    return message(
        "conformity-outside", measured=_measured(decided), where=where, risk=_risk(decided)
    )


def conditional(decision: Decision) -> list[Message]:
    """One sentence for each pass that lies within U of a limit, or outside it."""
    return [
        message(
            f"conformity-conditional-pass.{_side(decided)}",
            measured=_measured(decided), limits=_limits(decided), risk=_risk(decided),
        )
        for decided in decision.limits
        if decided.marginal and decided.verdict == "pass"
    ]  # fmt: skip


def _side(decided: LimitDecision) -> str:
    inside = _inside(Decimal(repr(decided.value)), decided.lower, decided.upper)
    return "near" if inside else "outside"


def too_uncertain(decided: LimitDecision) -> Message:
    """A value whose uncertainty is larger than its rule allows."""
    return message(
        "conformity-too-uncertain", subject=_subject(decided), value=_value(decided),
        U=_uncertainty(decided), why=_why_too_uncertain(decided),
    )  # fmt: skip


def _why_too_uncertain(decided: LimitDecision) -> Message:
    limits = _limits(decided)
    if decided.U_max is not None and decided.U is not None and decided.U_max < decided.U:
        agreed = quantity_text(str(text(exact(decided.U_max))), decided.unit)
        return message("conformity-uncertain.agreed", agreed=agreed)
    if decided.probability_of_conformity is not None:
        chance = probability_text(decided.probability_of_conformity)
        return message("conformity-uncertain.unbounded", limits=limits, chance=chance)
    needed = max(decided.min_capability or 0.0, decided.guard_band_factor)
    if needed > 1:
        return message(
            "conformity-uncertain.capability",
            capability=f"{decided.capability:.2g}", limits=limits, needed=f"{needed:g}",
        )  # fmt: skip
    return message("conformity-uncertain.interval", limits=limits)


def without_uncertainty(decisions: Iterable[LimitDecision]) -> list[Message]:
    """One reason for each item that has values without an uncertainty above zero."""
    return [
        message("conformity-without-uncertainty", item=item_title(item), elements=elements)
        for item, elements in _by_item(decisions)
    ]


def missing(calibration: Calibration, decisions: Iterable[LimitDecision]) -> list[Message]:
    """One reason for each item that has elements without a value."""
    return [
        message(
            "conformity-missing", item=item_title(item), elements=elements,
            why=unavailable(calibration, item) or message("conformity-no-cause"),
        )
        for item, elements in _by_item(decisions)
    ]  # fmt: skip


def unavailable(calibration: Calibration, item: str) -> Statement | None:
    """Why a calibration does not have an item; None where it does not say."""
    why = calibration.unavailable.get(item)
    return Statement(en=why, zh=calibration.unavailable_zh.get(item) or why) if why else None


def _by_item(decisions: Iterable[LimitDecision]) -> list[tuple[str, str]]:
    """Each item with the list of its elements."""
    elements: dict[str, list[str]] = {}
    for decided in decisions:
        elements.setdefault(decided.item, []).append(decided.element)
    return [(item, ", ".join(dict.fromkeys(names))) for item, names in elements.items()]


def _subject(decided: LimitDecision) -> Message:
    """Item, symbol and, where the item has two values, the one that was decided on."""
    named = {"item": item_title(decided.item), "symbol": symbol(decided.item, decided.element)}
    if second_value(decided.item) is None:
        return message("conformity-subject", **named)
    return message("conformity-subject.of-two", quantity=quantity_title(decided), **named)


def _measured(decided: LimitDecision) -> Message:
    return message(
        "conformity-measured", subject=_subject(decided), value=_value(decided),
        U=_uncertainty(decided), k="" if decided.k is None else f"{decided.k:g}",
    )  # fmt: skip


def _risk(decided: LimitDecision) -> Sayable:
    """The risk of a verdict, and whether it is a conditional one."""
    condition: Sayable = ""
    if decided.marginal:
        condition = message("conformity-condition", verdict=verdict_title(decided))
    for kind in ("acceptance", "rejection"):
        chance = getattr(decided, f"false_{kind}")
        if chance is not None:
            chance = probability_text(chance)
            return message(f"conformity-risk.{kind}", condition=condition, chance=chance)
    return ""


def _value(decided: LimitDecision) -> str:
    """The value rounded to the place of U; in full where that would hide what was decided."""
    assert decided.value is not None  # else nothing was decided
    full, rounded = Decimal(repr(decided.value)), round_like(decided.value, _rounded_U(decided))
    same = _sides(rounded, decided) == _sides(full, decided)
    return quantity_text(str(text(rounded if same else full)), decided.unit)


def _sides(value: Decimal, decided: LimitDecision) -> tuple[bool, bool]:
    """Whether a value is inside the limits, and inside the acceptance limits."""
    return (
        _inside(value, decided.lower, decided.upper),
        _inside(value, decided.accept_lower, decided.accept_upper),
    )


def _inside(value: Decimal, lower: float | None, upper: float | None) -> bool:
    above = lower is None or value >= Decimal(repr(lower))
    return above and (upper is None or value <= Decimal(repr(upper)))


def _rounded_U(decided: LimitDecision) -> Decimal:  # noqa: N802
    assert decided.U is not None  # else nothing was decided
    return round_up(decided.U, decided.k or USUAL_K)


def _uncertainty(decided: LimitDecision) -> str:
    return quantity_text(str(text(_rounded_U(decided))), decided.unit)


def _limits(decided: LimitDecision) -> str:
    limits, relative = quantity_text(limits_text(decided), decided.unit), relative_text(decided)
    return f"{limits} ({relative})" if relative else limits
