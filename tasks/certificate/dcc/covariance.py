"""The covariance of all elements, as D-SI states the uncertainty of a vector, in SI units."""

import math
import re
from collections import defaultdict
from decimal import Context, Decimal

from scipy.special import chdtri

from schemas.calibration import Calibration
from schemas.certificate import Certificate
from tasks.certificate.dcc.quantities import real, ref_type
from tasks.certificate.dcc.units import DsiUnit, dsi_unit, gravity_of
from tasks.certificate.dcc.xml import Element, dcc, described, named, si
from tasks.words import message

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
