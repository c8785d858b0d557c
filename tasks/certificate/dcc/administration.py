"""Administrative data of the DCC: laboratory, client, unit, dates."""

from datetime import date

from schemas.certificate import Certificate, Contact, Laboratory, Party
from schemas.text import text_of
from tasks.certificate.cover import party_address, party_name, signatures
from tasks.certificate.dcc.equipment import identification
from tasks.certificate.dcc.software import software
from tasks.certificate.dcc.xml import Element, dcc, described, languages, named, plain
from tasks.certificate.fields import given
from tasks.words import message, say

COUNTRY = "CN"  # of the specifications
NO_CONTACT = Contact()


def administration(certificate: Certificate, statements: Element) -> Element:
    """Everything but the results."""
    return dcc.administrativeData(
        dcc.dccSoftware(software(certificate.calibration.code_version)),
        _core(certificate),
        _unit(certificate),
        _laboratory(certificate.laboratory),
        _persons(certificate),
        _party("customer", certificate.order.client if certificate.order else None),
        statements,
    )


def _laboratory(laboratory: Laboratory | None) -> Element:
    """The laboratory, its accreditation as its code."""
    code = text_of(laboratory, "accreditation") if laboratory else None
    return dcc.calibrationLaboratory(
        *([plain("calibrationLaboratoryCode", say(code))] if code else []),
        _party(
            "contact",
            laboratory.party if laboratory else None,
            laboratory.contact if laboratory else NO_CONTACT,
        ),
    )


def _core(certificate: Certificate) -> Element:
    """If no day of calibration is given, that of issue replaces it, as in `due`."""
    order = certificate.order
    performed = day(certificate.calibrated_on or certificate.issued_on)
    used = [dcc.usedLangCodeISO639_1(language) for language in languages()]
    mandatory = [dcc.mandatoryLangCodeISO639_1(language) for language in languages()]
    return dcc.coreData(
        dcc.countryCodeISO3166_1(COUNTRY),
        *used,
        *mandatory,
        plain("uniqueIdentifier", certificate.number),
        *([dcc.receiptDate(day(order.received))] if order else []),
        dcc.beginPerformanceDate(performed),
        dcc.endPerformanceDate(performed),
        dcc.performanceLocation("other" if order and order.place else "laboratory"),
        *([dcc.issueDate(day(certificate.issued_on))] if certificate.state == "issued" else []),
        *_replaced(certificate),
    )


def day(when: date) -> str:
    return when.isoformat()


def _replaced(certificate: Certificate) -> list[Element]:
    if certificate.replaces is None:
        return []
    return [
        dcc.reportAmendedSubstituted(
            dcc.typeOfChange("amended"),
            plain("replacedUniqueIdentifier", certificate.replaces.number),
        )
    ]


def _unit(certificate: Certificate) -> Element:
    unit = certificate.manifest.unit
    return dcc.items(
        dcc.item(
            named(given(f"{unit.manufacturer} {unit.model}")),
            dcc.manufacturer(named(given(unit.manufacturer))),
            plain("model", unit.model),
            dcc.identifications(
                identification(
                    "manufacturer", unit.serial, message("certificate-field.serial"),
                    refType="basic_serialNumber",
                )
            ),
        )
    )  # fmt: skip


def _party(tag: str, party: Party | None, contact: Contact = NO_CONTACT) -> Element:
    return dcc(
        tag,
        named(party_name(party)),
        *([plain("eMail", contact.e_mail)] if contact.e_mail else []),
        *([plain("phone", contact.phone)] if contact.phone else []),
        dcc.location(dcc.countryCode(COUNTRY), described(party_address(party), tag="further")),
    )


def _persons(certificate: Certificate) -> Element:
    """Operator, verifier and issuer; the issuer signs."""
    signed = signatures(certificate)
    return dcc.respPersons(
        *(
            dcc.respPerson(
                dcc.person(named(each.name)),
                described(each.role, each.title or ""),
                dcc.mainSigner("true" if each is signed[-1] else "false"),
            )
            for each in signed
        )
    )
