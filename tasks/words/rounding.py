"""Rounding of a result and its expanded uncertainty: JJF 1059.1, 5.3.8.

As in the examples of JJF 2003 and JJF 1536 the combined uncertainty u_c is first rounded half-even
to three significant digits; U = k·u_c then keeps two and is rounded up, so that the certificate
states less than was found by no more than the rounding of u_c (half a per cent at the most). The
value is rounded half-even (GB/T 8170) to the same place.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_HALF_EVEN, Context, Decimal

SIGNIFICANT = 2  # digits of an expanded uncertainty
COMBINED = 3  # digits of a combined standard uncertainty before it is expanded
USUAL_K = 2.0
PLAIN_PLACES = 6  # more decimal places than these are written as ×10ⁿ
ALONE = 6  # significant digits of a value that has no uncertainty
MINUS = "−"

_EXACT = Context(prec=60)
_CLEAN = Context(prec=12, rounding=ROUND_HALF_EVEN)
_COMBINED = Context(prec=COMBINED, rounding=ROUND_HALF_EVEN)


@dataclass(frozen=True)
class RoundedColumn:
    """A column of results that shares one power of ten.

    exponent: every text is in units of 10^exponent; values, uncertainties: a text for each
    row, None where the number is null or not finite.
    """

    exponent: int
    values: tuple[str | None, ...]
    uncertainties: tuple[str | None, ...]


def round_up(uncertainty: float, k: float = USUAL_K) -> Decimal:
    """An expanded uncertainty U = k·u_c (≥ 0, finite), rounded up to two significant digits.

    u_c is rounded to three digits first: a u_c of 1.0004e-4 is 1.00e-4, and its U 2.0e-4. The
    twelfth digit of both is settled before: 3 × 1.1e-4 is 3.3000000000000004e-4 in binary.
    Raises ValueError for a negative or non-finite number.
    """
    if not math.isfinite(uncertainty) or uncertainty < 0:
        raise ValueError(f"an expanded uncertainty is a finite number ≥ 0, not {uncertainty!r}")
    u_c = _COMBINED.create_decimal(_CLEAN.create_decimal(repr(float(uncertainty) / k)))
    clean = _CLEAN.multiply(u_c, Decimal(repr(float(k))))
    place = Decimal((0, (1,), clean.adjusted() - SIGNIFICANT + 1))
    rounded = clean.quantize(place, ROUND_CEILING, _EXACT)
    # 9.96e-4 goes up to 10.0e-4, which has one digit too many.
    return rounded.quantize(
        Decimal((0, (1,), rounded.adjusted() - SIGNIFICANT + 1)), context=_EXACT
    )


def round_like(value: float, uncertainty: Decimal) -> Decimal:
    """A finite value rounded half-even to the last place of a rounded uncertainty."""
    return _quantized(Decimal(repr(float(value))), _place(uncertainty))


def stated(
    value: float | None, uncertainty: float | None, k: float = USUAL_K, alone: int = ALONE
) -> tuple[Decimal | None, Decimal | None]:
    """A value and its expanded uncertainty as a certificate states them; None for no number.

    alone: significant digits of a value without an uncertainty.
    """
    U = None if uncertainty is None or not math.isfinite(uncertainty) else round_up(uncertainty, k)
    if value is None or not math.isfinite(value):
        return None, U
    return (round_like(value, U) if U else _alone(value, alone)), U


def column(
    values: Sequence[float | None],
    uncertainties: Sequence[float | None],
    k: float = USUAL_K,
    alone: int = ALONE,
) -> RoundedColumn:
    """Values and their expanded uncertainties as the texts of one column of a table.

    k: the coverage factor of the uncertainties. Each value is rounded to the place of its own;
    the power of ten is one for the whole column: 0 where plain decimals do, otherwise a multiple
    of three. A value without an uncertainty (None, 0 or not finite) is given with
    `alone` significant digits.
    """
    pairs = [stated(*pair, k, alone) for pair in zip(values, uncertainties, strict=True)]
    exponent = _exponent(pairs)
    return RoundedColumn(
        exponent,
        tuple(text(value, exponent) for value, _ in pairs),
        tuple(text(uncertainty, exponent) for _, uncertainty in pairs),
    )


def text(number: Decimal | None, exponent: int = 0) -> str | None:
    """A number in units of 10^exponent, in plain decimals, with a real minus sign."""
    if number is None:
        return None
    return format(number.scaleb(-exponent, _EXACT), "f").replace("-", MINUS)


def exact(number: float | None) -> Decimal | None:
    """A number as it was given, without its trailing zeros."""
    return None if number is None else Decimal(repr(number)).normalize()


def as_given(value: float) -> str:
    """A number as it was given, up to ten digits, with a real minus sign."""
    return f"{value:.10g}".replace("-", MINUS)


def _alone(value: float, digits: int) -> Decimal:
    number = Decimal(repr(float(value)))
    return _quantized(number, max(number.adjusted() - digits + 1, _place(number)))


def _quantized(number: Decimal, place: int) -> Decimal:
    """Half-even to 10^place; a zero has no sign."""
    rounded = number.quantize(Decimal((0, (1,), place)), ROUND_HALF_EVEN, _EXACT)
    return rounded if rounded else abs(rounded)


def _place(number: Decimal) -> int:
    place = number.as_tuple().exponent
    assert isinstance(place, int)  # only NaN and infinity have a letter here
    return place


def _exponent(pairs: Sequence[tuple[Decimal | None, Decimal | None]]) -> int:
    numbers = [number for pair in pairs for number in pair if number is not None and number != 0]
    if not numbers:
        return 0
    places = [_place(number) for number in numbers]
    if max(places) <= 0 and min(places) >= -PLAIN_PLACES:
        return 0
    largest = max(number.adjusted() for number in numbers)
    # Above the coarsest last place, or a zero that is not significant would be written.
    return max(largest // 3 * 3, -(-max(places) // 3) * 3)
