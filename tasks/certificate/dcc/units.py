"""Units of results in D-SI notation, with their factors to SI units."""

from dataclasses import dataclass
from decimal import Context, Decimal

from schemas.certificate import Certificate
from tasks.motion.whole import STANDARD_GRAVITY

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
