"""The measurement standards used (clause 8 h), and how far off they may be, as numbers."""

from collections.abc import Iterator
from decimal import Decimal

from schemas.certificate import Certificate
from schemas.equipment import MeasurementStandard
from schemas.text import text_of
from tasks.certificate.dcc.quantities import plain_quantity, ref_type, text_quantity
from tasks.certificate.dcc.units import UNITS
from tasks.certificate.dcc.xml import Element, dcc, named, plain
from tasks.certificate.equipment import accuracy
from tasks.certificate.fields import day, given
from tasks.uncertainty.equipment import limit_of
from tasks.words import Sayable, message

QUANTITY = "measuringEquipmentQuantity"


def equipment(certificate: Certificate) -> list[Element]:
    """The list of the standards; nothing where none is known."""
    standards = certificate.laboratory.equipment if certificate.laboratory else ()
    return [dcc.measuringEquipments(*map(_standard, standards))] if standards else []


def identification(issuer: str, value: str, name: Sayable, **attributes: str) -> Element:
    """An identification number, and who assigned it."""
    return dcc.identification(dcc.issuer(issuer), plain("value", value), named(name), **attributes)


def _standard(standard: MeasurementStandard) -> Element:
    labelled, until = (
        message("certificate-label-accuracy"),
        message("certificate-label-valid-until"),
    )
    return dcc.measuringEquipment(
        named(given(text_of(standard, "name"))),
        dcc.identifications(
            identification("manufacturer", standard.serial, message("certificate-label-serial")),
            identification(
                "other", standard.certificate, message("certificate-label-standard-certificate")
            ),
        ),
        dcc.measuringEquipmentQuantities(
            text_quantity(labelled, accuracy(standard), QUANTITY),
            text_quantity(until, day(standard.valid_until), QUANTITY),
            *_limits(standard),
        ),
        refType="basic_calibrationEquipment",
    )


def _limits(standard: MeasurementStandard) -> Iterator[Element]:
    """The half-width of each limit, U (k = 2) of a normal one; which limit and which distribution
    it is stands in the refType.
    """
    for name, bound in standard.limits.items():
        limit = limit_of(name)
        what = f"{ref_type('limit', name)} {ref_type('distribution', bound.distribution)}"
        number = Decimal(repr(bound.half_width))
        yield plain_quantity(limit.name, number, UNITS[limit.unit], QUANTITY, refType=what)
