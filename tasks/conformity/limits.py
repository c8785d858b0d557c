"""Limits, verdicts on them and probabilities as they are printed."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal

from schemas.calibration import Calibration
from schemas.text import Statement
from schemas.tolerance import Decision, LimitDecision
from tasks.specifications.estimate import item_title, second_value, symbol
from tasks.words import Message, Sayable, message
from tasks.words.numbers import USUAL_K, exact, quantity_text, round_like, round_up, text

NO_INTERVAL = "–"
DIGITS = 9  # significant, of a limit as it is printed
NEARLY_CERTAIN = 0.999  # a probability nearer to 1 or 0 is not told apart from it


def verdict_title(limit: Decision | LimitDecision) -> Message:
    """A verdict in words, with its condition where a value lies within U of a limit.

    The names are those of ILAC-G8:09/2019, 4.2.3.
    """
    return message(f"conformity-{'conditional' if limit.marginal else 'verdict'}.{limit.verdict}")


def quantity_title(limit: LimitDecision) -> Message:
    """Which value of an item a limit is applied to."""
    return message(f"conformity-quantity.{limit.applied_to.replace('_', '-')}")


def interval_text(lower: Decimal | None, upper: Decimal | None, exponent: int = 0) -> str:
    """±, ≤, ≥ or from … to, in units of 10^exponent; one of the two is there."""
    low, high = text(lower, exponent), text(upper, exponent)
    if lower is None or upper is None:
        return f"≤ {high}" if lower is None else f"≥ {low}"
    return f"±{high}" if lower == -upper else f"{low} … {high}"


def limits_text(limit: LimitDecision, exponent: int = 0) -> str:
    """The limits, without a unit."""
    return interval_text(_laid_down(limit.lower), _laid_down(limit.upper), exponent)


def _laid_down(edge: float | None) -> Decimal | None:
    """A limit without the binary digits that a product with a nominal value leaves behind."""
    return None if edge is None else exact(float(f"{edge:.{DIGITS}g}"))


def nothing_accepted(limit: LimitDecision) -> bool:
    """Whether U is so large that the guard bands leave no acceptance interval."""
    guarded = bool(limit.guard_band_factor) and limit.U is not None
    return guarded and limit.accept_lower is None and limit.accept_upper is None


def accepted_edges(limit: LimitDecision) -> tuple[Decimal | None, Decimal | None] | None:
    """The acceptance limits, rounded like U; None if they equal the limits, or there is none."""
    if not limit.guard_band_factor or limit.U is None or nothing_accepted(limit):
        return None
    place = round_up(limit.U, limit.k or USUAL_K)
    lower, upper = (
        None if edge is None else round_like(edge, place)
        for edge in (limit.accept_lower, limit.accept_upper)
    )
    return lower, upper


def accepted_text(limit: LimitDecision, exponent: int = 0) -> str | None:
    """The acceptance limits, to the place of U; None where they are the limits."""
    if nothing_accepted(limit):
        return NO_INTERVAL
    edges = accepted_edges(limit)
    return interval_text(*edges, exponent) if edges else None


def relative_text(limit: LimitDecision) -> str | None:
    """Relative limits as they were given, like “±1 % × 3.2 °/s”; None for absolute ones."""
    if limit.nominal is None:
        return None
    lower, upper = (_percent(edge, limit.nominal) for edge in (limit.lower, limit.upper))
    nominal = quantity_text(str(text(exact(limit.nominal))), limit.unit)
    return f"{interval_text(lower, upper)} % × {nominal}"


def probability_text(probability: float) -> str:
    """A probability in per cent, distinct from 0 and 1 down to 0.1 %."""
    if probability > NEARLY_CERTAIN:
        return "> 99.9 %"
    return "< 0.1 %" if probability < 1 - NEARLY_CERTAIN else f"{100 * probability:.1f} %"


def _percent(limit: float | None, nominal: float) -> Decimal | None:
    if limit is None:
        return None
    return _laid_down(100 * (limit - nominal) / abs(nominal))


# Why a unit does not pass, and under which condition it does.

MORE_PLACES = 6  # of decimals, up to which a value is written out to show that it is beyond


@dataclass(frozen=True)
class Doubt:
    """Why nothing is decided on an item; elements: on which of it, None: on any."""

    sentence: Sayable
    elements: frozenset[str] | None = None

    def about(self, element: str) -> bool:
        """Whether it is a doubt about an element; one about the whole item is about each."""
        return self.elements is None or element == "all" or element in self.elements


Doubts = Mapping[str, Doubt]  # by item
OF_LIMITS = tuple(f"conformity-{name}" for name in (
    "outside", "conditional-pass", "too-uncertain", "without-uncertainty", "missing",
))  # fmt: skip


def is_of_a_limit(reason: Statement) -> bool:
    """Whether a reason of a decision is about one of its limits, and not about all of it."""
    return reason.message is not None and reason.message.id.startswith(OF_LIMITS)


def outside(limit: LimitDecision) -> Message:
    """A value that fails by its rule, with its uncertainty and the risk of having rejected it."""
    limits = _limits(limit)
    where = message("conformity-where.outside", limits=limits)
    if _inside_limits(limit):
        accepted = quantity_text(str(accepted_text(limit)), limit.unit)
        where = message("conformity-where.guard-band", limits=limits, accepted=accepted)
    return message("conformity-outside", measured=_measured(limit), where=where, risk=_risk(limit))


def conditional(decision: Decision) -> list[Message]:
    """One sentence for each pass that lies within U of a limit, or outside it."""
    return [
        message(
            f"conformity-conditional-pass.{'near' if _inside_limits(limit) else 'outside'}",
            measured=_measured(limit), limits=_limits(limit), risk=_risk(limit),
        )
        for limit in decision.limits
        if limit.marginal and limit.verdict == "pass"
    ]  # fmt: skip


def too_uncertain(limit: LimitDecision) -> Message:
    """A value whose uncertainty is larger than its rule allows."""
    return message(
        "conformity-too-uncertain", subject=_subject(limit), value=_value(limit),
        U=_uncertainty(limit), why=_why_too_uncertain(limit),
    )  # fmt: skip


def _why_too_uncertain(limit: LimitDecision) -> Message:
    limits = _limits(limit)
    if limit.U_max is not None and limit.U is not None and limit.U_max < limit.U:
        agreed = quantity_text(str(text(exact(limit.U_max))), limit.unit)
        return message("conformity-uncertain.agreed", agreed=agreed)
    if limit.probability_of_conformity is not None:
        chance = probability_text(limit.probability_of_conformity)
        return message("conformity-uncertain.unbounded", limits=limits, chance=chance)
    needed = max(limit.min_capability or 0.0, limit.guard_band_factor)
    if needed > 1:
        return message(
            "conformity-uncertain.capability",
            capability=f"{limit.capability:.2g}", limits=limits, needed=f"{needed:g}",
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
            why=calibration.why_unavailable(item) or message("conformity-no-cause"),
        )
        for item, elements in _by_item(decisions)
    ]  # fmt: skip


def _by_item(decisions: Iterable[LimitDecision]) -> list[tuple[str, str]]:
    """Each item with the list of its elements."""
    elements: dict[str, list[str]] = {}
    for limit in decisions:
        elements.setdefault(limit.item, []).append(limit.element)
    return [(item, ", ".join(dict.fromkeys(names))) for item, names in elements.items()]


def _subject(limit: LimitDecision) -> Message:
    """Item, symbol and, where the item has two values, the one that was decided on."""
    named = {"item": item_title(limit.item), "symbol": symbol(limit.item, limit.element)}
    if second_value(limit.item) is None:
        return message("conformity-subject", **named)
    return message("conformity-subject.of-two", quantity=quantity_title(limit), **named)


def _measured(limit: LimitDecision) -> Message:
    return message(
        "conformity-measured", subject=_subject(limit), value=_value(limit),
        U=_uncertainty(limit), k="" if limit.k is None else f"{limit.k:g}",
    )  # fmt: skip


def _risk(limit: LimitDecision) -> Sayable:
    """The risk of a verdict, and whether it is a conditional one."""
    condition: Sayable = ""
    if limit.marginal:
        condition = message("conformity-condition", verdict=verdict_title(limit))
    for kind in ("acceptance", "rejection"):
        chance = getattr(limit, f"false_{kind}")
        if chance is not None:
            chance = probability_text(chance)
            return message(f"conformity-risk.{kind}", condition=condition, chance=chance)
    return ""


def _value(limit: LimitDecision) -> str:
    """The value rounded to the place of U; to as many more as show what was decided.

    No further place shows it for a value that lies on an edge: it is then rounded as U is.
    """
    assert limit.value is not None  # else nothing was decided
    full, place = Decimal(repr(limit.value)), _rounded_U(limit)
    intervals = ((limit.lower, limit.upper), (limit.accept_lower, limit.accept_upper))
    decided = [_inside(full, *edges) for edges in intervals]
    for more in range(MORE_PLACES):
        rounded = round_like(limit.value, place.scaleb(-more))
        if [_inside(rounded, *edges) for edges in intervals] == decided:
            return quantity_text(str(text(rounded)), limit.unit)
    return quantity_text(str(text(round_like(limit.value, place))), limit.unit)


def _inside_limits(limit: LimitDecision) -> bool:
    return _inside(Decimal(repr(limit.value)), limit.lower, limit.upper)


def _inside(value: Decimal, lower: float | None, upper: float | None) -> bool:
    above = lower is None or value >= Decimal(repr(lower))
    return above and (upper is None or value <= Decimal(repr(upper)))


def _rounded_U(limit: LimitDecision) -> Decimal:  # noqa: N802
    assert limit.U is not None  # else nothing was decided
    return round_up(limit.U, limit.k or USUAL_K)


def _uncertainty(limit: LimitDecision) -> str:
    return quantity_text(str(text(_rounded_U(limit))), limit.unit)


def _limits(limit: LimitDecision) -> str:
    limits, relative = quantity_text(limits_text(limit), limit.unit), relative_text(limit)
    return f"{limits} ({relative})" if relative else limits


def is_doubted(doubts: Doubts, item: str, element: str) -> bool:
    """Whether nothing can be decided on an element of an item."""
    return item in doubts and doubts[item].about(element)
