"""The curves of the figures: lists of numbers, in SI units."""

from collections.abc import Iterator
from decimal import Decimal

from schemas.certificate import Certificate
from schemas.curve import Curve
from tasks.certificate.dcc.quantities import coverage, ref_type
from tasks.certificate.dcc.units import DsiUnit, dsi_unit, gravity_of
from tasks.certificate.dcc.xml import Element, dcc, described, named, si
from tasks.certificate.fields import given
from tasks.certificate.figures import figures, of_figure
from tasks.words import message


def curve_results(certificate: Certificate) -> Iterator[Element]:
    """A result for each figure: of every curve the abscissae, and the ordinates with their U."""
    for figure in figures(certificate):
        curves = of_figure(certificate, figure.name)
        yield dcc.result(
            named(figure.title),
            described(figure.caption),
            dcc.data(*(_list(curve, certificate) for curve in curves)),
            refType=f"{ref_type('curve')} {ref_type(figure.name)}",
        )


def _list(curve: Curve, certificate: Certificate) -> Element:
    gravity = gravity_of(certificate)
    x_unit, y_unit = (dsi_unit(unit, gravity) for unit in (curve.x_unit, curve.y_unit))
    k = coverage(curve.k)
    expanded = si.measurementUncertaintyUnivariateXMLList(
        si.expandedMUXMLList(
            si.valueExpandedMUXMLList(_numbers(curve.U, y_unit)),
            si.coverageFactorXMLList(f"{k.k:g}"),
            si.coverageProbabilityXMLList(f"{k.probability:.4g}"),
        )
    )
    name = given(f"{curve.quantity} {curve.axis}")
    return dcc.list(
        named(name),
        _quantity("dcc-curve.x", curve.x, x_unit),
        _quantity("dcc-curve.y", curve.y, y_unit, expanded),
        refType=ref_type(curve.figure, curve.quantity, curve.axis),
    )


def _quantity(name: str, numbers: tuple[float, ...], unit: DsiUnit, *more: Element) -> Element:
    values = si.valueXMLList(_numbers(numbers, unit))
    listed = si.realListXMLList(values, si.unitXMLList(unit.si), *more)
    return dcc.quantity(named(message(name)), listed)


def _numbers(numbers: tuple[float, ...], unit: DsiUnit) -> str:
    return " ".join(str(unit.in_si(Decimal(repr(number)))) for number in numbers)
