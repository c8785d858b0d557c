"""Numbers with unit, expanded uncertainty and coverage factor, as D-SI writes them."""

import base64
import math
import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Context, Decimal
from typing import Any

from lxml import etree
from lxml.builder import ElementMaker
from scipy.special import chdtri

from schemas.calibration import Calibration
from schemas.certificate import Certificate
from schemas.text import CONTRACTED, Statement
from tasks.certificate.fields import literal
from tasks.motion.whole import STANDARD_GRAVITY
from tasks.words import LANGUAGES, Sayable, message, say
from tasks.words.numbers import typeset

# Units of results in D-SI notation, with their factors to SI units.

DEGREE = Decimal("0.01745329251994329576923690768")  # rad
HOUR = Decimal(3600)
EXACT = Context(prec=40)
CLEAN = Context(prec=12)  # digits of a number that was converted
PER_G = "(deg/s)/g"


@dataclass(frozen=True)
class DsiUnit:
    """A unit in D-SI's own writing; si: the SI unit, of which one of it is `factor`.

    defined: what the unit is, where D-SI has no name for it.
    """

    name: str
    si: str
    factor: Decimal = Decimal(1)
    defined: str | None = None

    def in_si(self, number: Decimal) -> Decimal:
        """A number of this unit in the SI unit."""
        return CLEAN.plus(EXACT.multiply(number, self.factor))


def _si(name: str) -> DsiUnit:
    return DsiUnit(name, name)


UNITS = {
    "1": _si(r"\one"),
    "m": _si(r"\metre"),
    "s": _si(r"\second"),
    "d": DsiUnit(r"\day", r"\second", Decimal(86400)),
    "m/s2": _si(r"\metre\second\tothe{-2}"),
    "(m/s2)/sqrt(Hz)": _si(r"\metre\second\tothe{-1.5}"),
    "rad": _si(r"\radian"),
    "degC": _si(r"\degreecelsius"),
    "ppm": DsiUnit(r"\ppm", r"\one", Decimal("1e-6")),
    "%": DsiUnit(r"\percent", r"\one", Decimal("0.01")),
    "deg": DsiUnit(r"\degree", r"\radian", DEGREE),
    "deg/s": DsiUnit(r"\degree\second\tothe{-1}", r"\radian\second\tothe{-1}", DEGREE),
    "deg/h": DsiUnit(r"\degree\hour\tothe{-1}", r"\radian\second\tothe{-1}", DEGREE / HOUR),
    "deg/sqrt(h)": DsiUnit(
        r"\degree\hour\tothe{-0.5}", r"\radian\second\tothe{-0.5}", DEGREE / HOUR.sqrt()
    ),
}


def dsi_unit(unit: str, gravity: float) -> DsiUnit:
    """A unit of a result. gravity: the g of “per g”, m/s².

    A unit that is not known here is named as it stands, and defined by its name.
    """
    if unit == PER_G:
        g = Decimal(repr(gravity))
        return DsiUnit(
            "|(deg/s)/g",
            r"\radian\second\metre\tothe{-1}",
            DEGREE / g,
            rf"\degree\second\tothe{{-1}} / ({g} \metre\second\tothe{{-2}})",
        )
    name = "|" + "".join(unit.split())
    return UNITS.get(unit) or DsiUnit(name, name, defined=unit)


def gravity_of(certificate: Certificate) -> float:
    """The g of “per g”, m/s²: that of the place, or the standard one where it is not stated."""
    return certificate.manifest.station.gravity_m_s2 or STANDARD_GRAVITY


# Elements of the DCC and of D-SI, and texts in both languages.

DCC, SI = "https://ptb.de/dcc", "https://ptb.de/si"
NAMES = {"dcc": DCC, "si": SI}

Element = Any  # lxml's element, which has no public type

dcc = ElementMaker(namespace=DCC, nsmap=NAMES)
si = ElementMaker(namespace=SI, nsmap=NAMES)


def languages() -> tuple[str, ...]:
    """Every language, that of the specifications first."""
    return tuple(sorted(LANGUAGES, key=lambda language: language != CONTRACTED[-1]))


def contents(sayable: Sayable) -> list[Element]:
    """A text in every language, set as the printed certificate sets it."""
    return [dcc.content(_set(sayable, language) or "—", lang=language) for language in languages()]


def named(sayable: Sayable, tag: str = "name") -> Element:
    """A text by its tag: the name of something, unless another is given."""
    return dcc(tag, *contents(sayable))


def described(*sayables: Sayable, tag: str = "description") -> Element:
    """Sentences by their tag, each in both languages: one after the other in each language."""
    texts = [[_set(each, language) for each in sayables] for language in languages()]
    joined = ["\n".join(filter(None, lines)) or "—" for lines in texts]
    parts = [
        dcc.content(text, lang=language) for text, language in zip(joined, languages(), strict=True)
    ]
    return dcc(tag, *parts)


def plain(tag: str, text: str) -> Element:
    """A text that is the same in every language; a dash if it is empty."""
    return dcc(tag, literal(text) or "—")


def file(name: str, mime_type: str, content: bytes, tag: str = "file") -> Element:
    """A file within the document."""
    return dcc(
        tag,
        dcc.fileName(name),
        dcc.mimeType(mime_type),
        dcc.dataBase64(base64.b64encode(content).decode()),
    )


def canonical(root: Element) -> bytes:
    """The one way to write a document: every other byte would be another document."""
    return etree.tostring(root, method="c14n")


def _set(sayable: Sayable, language: str) -> str:
    if isinstance(sayable, str | Statement):
        return literal(say(sayable, language))
    return literal(typeset(say(sayable, language), language))


@dataclass(frozen=True)
class Coverage:
    """The coverage factor of an expanded uncertainty, and the probability that goes with it."""

    k: float
    probability: float


def ref_type(*parts: str) -> str:
    """A refType of this program's own: what a value is, down to its element."""
    return "_".join(("mimucal", *parts))


def coverage(k: float, probability: float | None = None) -> Coverage:
    """probability: None is that of a normal distribution."""
    return Coverage(k, math.erf(k / math.sqrt(2.0)) if probability is None else probability)


def quantity(
    name: Sayable,
    label: str,
    value: Decimal | None,
    unit: DsiUnit,
    U: Decimal | None,
    at: Coverage,
    more: Sequence[Element] = (),
) -> Element:
    """A result by its name, in its SI unit; where it is stated in another, in both, SI first.

    label: item and element for programs, in the refType too: of gyro_bias.x it is
    mimucal_gyro_bias_x. more: what else belongs to it.
    """
    own = ref_type(*label.split("."))
    if value is None:
        return dcc.quantity(named(name), _no_number(), *more, refType=own)
    numbers = [real(label, value, unit.name, U, at)]
    if unit.name != unit.si:
        in_si = None if U is None else unit.in_si(U)
        numbers.insert(0, real(label, unit.in_si(value), unit.si, in_si, at))
    content = si.hybrid(*numbers) if len(numbers) > 1 else numbers[0]
    return dcc.quantity(named(name), content, *more, refType=f"basic_measuredValue {own}")


def plain_quantity(
    name: Sayable, value: Decimal, unit: DsiUnit, tag: str = "quantity", **attributes: str
) -> Element:
    """A number without an uncertainty: a condition, a limit, a setting."""
    numbers = [real(None, value, unit.name)]
    if unit.name != unit.si:
        numbers.insert(0, real(None, unit.in_si(value), unit.si))
    content = si.hybrid(*numbers) if len(numbers) > 1 else numbers[0]
    return dcc(tag, named(name), content, **attributes)


def without_number(name: Sayable) -> Element:
    """That there is no number, where one would be looked for."""
    return dcc.quantity(named(name), _no_number())


def text_quantity(name: Sayable, text: Sayable, tag: str = "quantity") -> Element:
    """A property that is a text."""
    return dcc(tag, named(name), dcc.noQuantity(*contents(text)))


def real(
    label: str | None, value: Decimal, unit: str, U: Decimal | None = None,
    at: Coverage | None = None,
) -> Element:  # fmt: skip
    parts = [si.label(label)] if label else []
    parts += [si.value(str(value)), si.unit(unit)]
    if U is not None and at is not None:
        expanded = si.expandedMU(
            si.valueExpandedMU(str(U)),
            si.coverageFactor(f"{at.k:g}"),
            si.coverageProbability(f"{at.probability:.4g}"),
        )
        parts.append(si.measurementUncertaintyUnivariate(expanded))
    return si.real(*parts)


def _no_number() -> Element:
    return dcc.noQuantity(*contents(message("dcc-no-number")))


# The covariance of all elements, as D-SI states the uncertainty of a vector, in SI units.

PROBABILITY = 0.95
DIGITS = Context(
    prec=9
)  # of a covariance: it stays positive definite where elements are correlated
POWER = re.compile(r"\\([a-z]+)(?:\\tothe\{([^}]*)\})?")


def covariance_result(certificate: Certificate, calibration: Calibration) -> Element | None:
    """All elements as one vector with its ellipsoidal coverage region; None without a covariance.

    The region's factor is the root of the χ² quantile for so many elements: it is k of the vector,
    and not that of a single element.
    """
    covariance = calibration.covariance
    if covariance is None:
        return None
    names = [element.split(".", 1) for element in covariance.elements]
    items = [calibration.items[item] for item, _ in names]
    gravity = gravity_of(certificate)
    units = [dsi_unit(item.unit, gravity) for item in items]
    values = [item.value[element] for item, (_, element) in zip(items, names, strict=True)]
    products = {one.si: [product(one, other) for other in units] for one in units}
    count, rows = len(names), covariance.rows

    def column(j: int) -> Element:
        numbers = (rows[max(i, j)][min(i, j)] for i in range(count))
        return si.column(
            *(
                si.covariance(si.value(_in_si(number, unit, units[j])), si.unit(both))
                for number, unit, both in zip(numbers, units, products[units[j].si], strict=True)
            )
        )

    vector = si.realList(
        *(
            real(name, unit.in_si(Decimal(repr(value))), unit.si)
            for name, value, unit in zip(covariance.elements, values, units, strict=True)
        ),
        si.ellipsoidalRegion(
            si.covarianceMatrix(*map(column, range(count))),
            si.coverageFactor(f"{_factor(count):.4g}"),
            si.coverageProbability(f"{PROBABILITY:g}"),
        ),
    )
    title = message("dcc-covariance")
    return dcc.result(
        named(title),
        described(message("dcc-covariance.how", count=count)),
        dcc.data(dcc.quantity(named(title), si.list(vector))),
        refType=ref_type("covariance"),
    )


def _in_si(covariance: float, one: DsiUnit, other: DsiUnit) -> str:
    return str(DIGITS.multiply(Decimal(repr(covariance)), one.factor * other.factor))


def product(one: DsiUnit, other: DsiUnit) -> str:
    """The SI unit of a product, each base unit once: of rad/s twice it is rad²·s⁻²."""
    powers = defaultdict[str, Decimal](Decimal)
    for name, power in POWER.findall(one.si + other.si):
        powers[name] += Decimal(power or 1)
    parts = [(name, power) for name, power in powers.items() if name != "one" and power]
    return (
        "".join(
            rf"\{name}" if power == 1 else rf"\{name}\tothe{{{power}}}" for name, power in parts
        )
        or r"\one"
    )


def _factor(count: int) -> float:
    """k of the ellipsoid that holds a normal vector of so many elements with PROBABILITY."""
    return math.sqrt(float(chdtri(count, 1.0 - PROBABILITY)))
