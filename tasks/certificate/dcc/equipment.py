"""The measurement standards used (clause 8 h)."""

from schemas.certificate import Certificate
from schemas.equipment import MeasurementStandard
from tasks.certificate.dcc.quantities import text_quantity
from tasks.certificate.dcc.xml import Element, dcc, named, plain
from tasks.certificate.equipment import accuracy
from tasks.certificate.fields import day, given
from tasks.words import Sayable, message


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
        named(given(standard.name, standard.name_zh)),
        dcc.identifications(
            identification("manufacturer", standard.serial, message("certificate-label-serial")),
            identification(
                "other", standard.certificate, message("certificate-label-standard-certificate")
            ),
        ),
        dcc.measuringEquipmentQuantities(
            text_quantity(labelled, accuracy(standard), "measuringEquipmentQuantity"),
            text_quantity(until, day(standard.valid_until), "measuringEquipmentQuantity"),
        ),
        refType="basic_calibrationEquipment",
    )
