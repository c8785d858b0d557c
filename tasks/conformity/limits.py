"""Limits, verdicts on them and probabilities as they are printed."""

from decimal import Decimal

from schemas.decision import Decision, LimitDecision
from tasks.words import Message, message
from tasks.words.quantities import quantity_text
from tasks.words.rounding import USUAL_K, exact, round_like, round_up, text

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
