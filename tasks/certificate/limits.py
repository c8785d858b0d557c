"""Limits, verdicts on them and probabilities as they are printed."""

from dataclasses import dataclass
from decimal import Decimal

from schemas.tolerance import LimitDecision, Verdict
from tasks.certificate.names import Pair, verdict_words
from tasks.words.rounding import USUAL_K, round_like, round_up, text
from tasks.words.units import quantity_text

SURE = 0.999  # a probability nearer to 1 or 0 than this is not told apart from it


@dataclass(frozen=True)
class Mark:
    """The verdict on one limit: its key and words, and the probability of conformity."""

    verdict: Verdict
    words: Pair
    chance: str | None


def mark(made: LimitDecision) -> Mark:
    """The verdict as it stands beside a value; no probability where nothing was decided."""
    chance = made.probability_of_conformity
    said = None if chance is None else probability_text(chance)
    return Mark(made.verdict, verdict_words(made), said)


def limit_lines(made: LimitDecision, exponent: int, two: bool) -> tuple[str, ...]:
    """The limits and, where they differ, the acceptance limits AL, without a unit.

    two: whether the item shows two values; (a), (b) then name the column.
    """
    wanted, accepted = limits_text(made, exponent), accepted_text(made, exponent)
    if two:
        wanted = f"({'a' if made.applied_to == 'value' else 'b'}) {wanted}"
    return (wanted, f"AL {accepted}") if accepted else (wanted,)


def interval_text(lower: Decimal | None, upper: Decimal | None, exponent: int = 0) -> str:
    """±, ≤, ≥ or from … to, in units of 10^exponent; one of the two is there."""
    low, high = text(lower, exponent), text(upper, exponent)
    if lower is None or upper is None:
        return f"≤ {high}" if lower is None else f"≥ {low}"
    return f"±{high}" if lower == -upper else f"{low} … {high}"


def limits_text(made: LimitDecision, exponent: int = 0) -> str:
    """The limits, without a unit."""
    return interval_text(plain(made.lower), plain(made.upper), exponent)


def accepted_text(made: LimitDecision, exponent: int = 0) -> str | None:
    """The acceptance limits, to the place of U; None where they are the limits."""
    if not made.guard_band_factor or made.U is None:
        return None
    place, edges = round_up(made.U, made.k or USUAL_K), (made.accept_lower, made.accept_upper)
    lower, upper = (None if edge is None else round_like(edge, place) for edge in edges)
    return interval_text(lower, upper, exponent)


def relative_text(made: LimitDecision) -> str | None:
    """Relative limits as they were given, like «±1 % × 3.2 °/s»; None for absolute ones."""
    if made.nominal is None:
        return None
    lower, upper = (_percent(edge, made.nominal) for edge in (made.lower, made.upper))
    of = quantity_text(str(text(plain(made.nominal))), made.unit)
    return f"{interval_text(lower, upper)} % × {of}"


def probability_text(probability: float) -> str:
    """A probability in per cent, told apart from 0 and 1 down to 0.1 %."""
    if probability > SURE:
        return "> 99.9 %"
    return "< 0.1 %" if probability < 1 - SURE else f"{100 * probability:.1f} %"


def _percent(limit: float | None, nominal: float) -> Decimal | None:
    if limit is None:
        return None
    return plain(float(f"{100 * (limit - nominal) / abs(nominal):.9g}"))


def plain(number: float | None) -> Decimal | None:
    """A number as it was given, without its trailing zeros."""
    return None if number is None else Decimal(repr(number)).normalize()
