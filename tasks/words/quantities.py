"""Quantities in readable form: SI prefixes, powers of ten, value ± U, percentages."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from tasks.words.rounding import MINUS, USUAL_K, column

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
