"""Numbers for people: quantities and units, rounding by JJF 1059.1, 5.3.8, and typography."""

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_HALF_EVEN, Context, Decimal
from functools import lru_cache, partial
from typing import Any

from schemas.text import Statement
from tasks.words.message import Argument, message
from tasks.words.translation import LANGUAGES, say

# Rounding of a result and its expanded uncertainty: JJF 1059.1, 5.3.8.
#
# As in the examples of JJF 2003 and JJF 1536 the combined uncertainty u_c is first rounded half-
# even to three significant digits; U = k·u_c then keeps two and is rounded up, so that the
# certificate states less than was found by no more than the rounding of u_c (half a per cent at
# the most). The value is rounded half-even (GB/T 8170) to the same place.

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


# Quantities in readable form: SI prefixes, powers of ten, value ± U, percentages.

SPELLINGS = (
    ("m/s2", "m/s²"), (")2", ")²"), ("^2", "²"), ("^3", "³"), ("^4", "⁴"), ("deg", "°"),
    ("*", "·"), ("sqrt(h)", "√h"), ("sqrt(s)", "√s"), ("sqrt(Hz)", "√Hz"),
)  # fmt: skip
PREFIXED = ("m", "s", "rad", "m/s2", "V", "T")  # units that take a prefix
PREFIXES = {-3: "m", -6: "µ", -9: "n"}
SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
IN_DEGREES = {"rad/s": math.degrees(1.0), "deg/s": 1.0}  # what is printed in °/s or °/h
SLOW = 0.01  # °/s; below it a rate is easier read in °/h
WIDE = 99.5  # units that U fills with two digits and zeros
PLAIN = 0.01  # a smaller number is printed with a power of ten


@dataclass(frozen=True)
class Scale:
    """How a number is printed: value·factor / 10^exponent in `unit`."""

    factor: float
    exponent: int
    unit: str


def readable_scale(largest: float, unit: str) -> Scale:
    """A scale in which a number of this size is neither long nor all zeros."""
    factor = 1.0
    if unit in IN_DEGREES:
        slow = 0.0 < IN_DEGREES[unit] * largest < SLOW
        factor, unit = IN_DEGREES[unit] * (3600.0 if slow else 1.0), "deg/h" if slow else "deg/s"
    elif unit.startswith("(rad/s)"):
        factor, unit = IN_DEGREES["rad/s"], unit.replace("(rad/s)", "(deg/s)", 1)
    largest *= factor
    if not 0.0 < largest < (1.0 if unit in PREFIXED else PLAIN):
        return Scale(factor, 0, unit)
    exponent = 3 * math.floor(math.log10(largest) / 3)
    if unit not in PREFIXED:
        return Scale(factor, exponent, unit)
    power = max(exponent, min(PREFIXES))
    return Scale(factor / 10.0**power, 0, PREFIXES[power] + unit)


def power_of_ten(exponent: int) -> str:
    """“×10⁻⁶”, or nothing."""
    return f"×10{str(exponent).translate(SUPERSCRIPTS)}" if exponent else ""


def plain(number: float, digits: int = 3) -> str:
    """A bare number with few digits and a real minus sign."""
    size = abs(number)
    shown = f"{number:.0f}" if 10.0**digits <= size < 1e6 else f"{number:.{digits}g}"
    mantissa, mark, exponent = shown.partition("e")
    return mantissa.replace("-", MINUS) + (power_of_ten(int(exponent)) if mark else "")


def probability(p: float) -> str:
    """“p = 0.41”, “p < 10⁻¹²”."""
    return "p < 10⁻¹²" if p < 1e-12 else f"p = {plain(p, 2)}"


def moment(t: float) -> str:
    """An instant of a recording on its own clock, s: tenths, of a long one whole seconds."""
    return f"{t:.1f}" if abs(t) < 1000.0 else f"{t:.0f}"


def percent(share: float) -> str:
    """A share as “62 %”."""
    return "< 1 %" if 0.0 < share < 0.005 else f"{100 * share:.0f} %".replace("-", MINUS)


def multiple(ratio: float) -> str:
    """A change as a multiple of something, “+9.0”."""
    if abs(ratio) >= 1e4:
        return ("+" if ratio > 0 else "") + plain(ratio, 2)
    return f"{ratio:+.{1 if abs(ratio) < 99.95 else 0}f}".replace("-", MINUS)


def rough_quantity(value: float, unit: str) -> str:
    """A value that has no U here, to three digits, in a unit of its size: “11.3 ms”."""
    scale = readable_scale(abs(value), unit)
    shown = "" if scale.unit == "1" else unit_text(scale.unit)
    return f"{plain(value * scale.factor)} {shown}".strip()


def chi2(value: float) -> str:
    """A χ² per degree of freedom."""
    return f"{value:.2f}" if abs(value) < 100 else plain(value)


@dataclass(frozen=True)
class Quantities:
    """Values that share a unit, as texts; `unit` has their power of ten, “×10⁻⁶ (°/s)/g”."""

    values: tuple[str | None, ...]
    uncertainties: tuple[str | None, ...]
    unit: str

    def text(self, index: int) -> str:
        """“(9.66 ± 0.40) °/h”, “(2.01 ± 0.12)×10⁻⁶”; without ± where there is no U."""
        number, U = self.values[index] or "0", self.uncertainties[index]
        body = number if U is None else f"({number} ± {U})" if self.unit else f"{number} ± {U}"
        return body + self.unit if self.unit.startswith("×") else f"{body} {self.unit}".strip()


def common_scales(sizes: Iterable[tuple[float | None, str]]) -> dict[str, Scale]:
    """For each unit that is printed in a smaller or larger one, the scale of its largest size, so
    that a page has one unit for all of its lengths, and one for all of its rates.
    """
    largest: dict[str, float] = {}
    for size, unit in sizes:
        if unit in PREFIXED or unit in IN_DEGREES:
            largest[unit] = max(largest.get(unit, 0.0), abs(size or 0.0))
    return {unit: readable_scale(size, unit) for unit, size in largest.items()}


def quantities(
    values: Sequence[float | None], U: float | Sequence[float | None] | None, unit: str,
    scale: Scale | None = None,
) -> Quantities:  # fmt: skip
    """Values with one expanded uncertainty, or with one each (0 or None: without), in the unit of a
    scale, else in one of their size.
    """
    each = U if isinstance(U, Sequence) else [U] * len(values)
    uncertainties = [one or 0.0 for one in each]
    sizes = (abs(value) for value in (*values, *uncertainties) if value is not None)
    if scale is None:
        scale = readable_scale(max(sizes), unit)
        if scale.unit != unit and unit in PREFIXED and max(uncertainties) * scale.factor >= WIDE:
            larger = 3 - round(math.log10(scale.factor))  # the next larger unit
            scale = Scale(10.0**-larger, 0, PREFIXES.get(larger, "") + unit)
    by = scale.factor / 10.0**scale.exponent
    scaled = [None if value is None else value * by for value in values]
    made = column(scaled, [one * by if one > 0 else None for one in uncertainties], USUAL_K)
    power = power_of_ten(scale.exponent + made.exponent)
    shown = "" if scale.unit == "1" else unit_text(scale.unit)
    return Quantities(made.values, made.uncertainties, f"{power} {shown}".strip())


def quantity(value: float, U: float | None, unit: str, scale: Scale | None = None) -> str:
    """A value with its U (0 or None: without) and unit."""
    return quantities([value], U, unit, scale).text(0)


def unit_text(unit: str) -> str:
    """A unit as it is printed."""
    for ascii_, printed in SPELLINGS:
        unit = unit.replace(ascii_, printed)
    return unit


def quantity_text(number: str, unit: str) -> str:
    """A number with its unit as it is printed; a ratio has none."""
    if unit == "deg":
        return f"{number}°"
    return number if unit == "1" else f"{number} {unit_text(unit)}"


# Typography of sentences: dashes, minus signs and equation numbers by language.
#
# What the numerics write in one way for all languages (“eq. (3)-(5)”, “Table 1”, `-9.8`) is set
# by the messages `typography-…` of each catalogue.

NO_BREAK = "\u00a0"
FULL_STOPS = ".\u3002"  # Latin and Chinese
_NUMBER = r"\((?:[A-Z]\.)?\d+\)"
_SENTENCE = (
    (r"\bJJF (?P<number>\d+)-(?P<year>\d{4})\b", "specification"),
    (rf"eq\. (?P<first>{_NUMBER})–(?P<last>{_NUMBER})", "equations.range"),
    (rf"eq\. (?P<numbers>{_NUMBER}(?:, {_NUMBER})*)", "equations"),
    (rf"(?<=\d)~(?=[\d{MINUS}])", "range"),
)
_CLAUSE = (
    (r"list under (?P<equation>eq\. \(\d+\))", "list-under"),
    (r"Appendix (?P<letter>[A-Z]), (?P<entry>\d+)", "appendix.entry"),
    (r"Appendix (?P<letter>[A-Z])", "appendix"),
    (r"Table (?P<number>\d)", "table"),
    (r"(?<=\d) to (?=\d)", "from-to"),
    (r"(?<=\)) and (?=eq\.)", "and.equations"),
    (r", joint method with gravity alone", "joint-method.gravity"),
    (r", joint method", "joint-method"),
    (r", (?=eq\.)", "comma.equation"),
    *_SENTENCE,
    (r" and ", "and"),
    (r", ", "comma"),
)


@lru_cache(maxsize=4096)  # certificates say the same of many units
def typeset(text: str, language: str) -> str:
    """A sentence with real minus signs, ° for deg, “< 0.1 %” on one line, and what its language
    has for the rest.
    """
    text = re.sub(r"(?<![\w.)\]-])-(?=\d|[xyz]\b)", MINUS, text)
    text = re.sub(rf"(eq\. {_NUMBER})-(?={_NUMBER})", r"\1–", text)
    text = re.sub(r"(?<=[<>]) (?=\d)|(?<=\d) (?=%)", NO_BREAK, text)
    return _replaced(re.sub(r"\bdeg/s\b", "°/s", text), _SENTENCE, language)


def clause(text: str, specification: str = "") -> Statement:
    """A clause in every language, without the name of the specification that is meant anyway."""
    short = text.removeprefix(specification).strip(" ,")
    short = re.sub(rf"(eq\. {_NUMBER})-(?={_NUMBER})", r"\1–", short)
    made: dict[str, Any] = {language: _clause(short, language) for language in LANGUAGES}
    return Statement(**made)


def _clause(text: str, language: str) -> str:
    return typeset(_replaced(text, _CLAUSE, language), language)


def _replaced(text: str, rules: tuple[tuple[str, str], ...], language: str) -> str:
    for pattern, name in rules:
        text = re.sub(pattern, partial(_filled, name, language), text)
    return text


def _filled(name: str, language: str, match: re.Match[str]) -> str:
    arguments: dict[str, Argument] = dict(match.groupdict())
    if name == "equations":
        numbers = match["numbers"].split(", ")
        arguments["numbers"] = tuple(message("typography-equation", number=n) for n in numbers)
    return say(message(f"typography-{name}", **arguments), language)
