"""The complete DCC document, made from the certificate alone."""

from collections.abc import Iterator, Sequence
from datetime import date

from schemas.calibration import Calibration
from schemas.certificate import Certificate, Contact, Laboratory, Party
from schemas.text import text_of
from tasks.certificate.content import content
from tasks.certificate.cover import party_address, party_name, signatures
from tasks.certificate.cover import verdict as verdict_words
from tasks.certificate.dcc.quantities import (
    Element,
    canonical,
    dcc,
    described,
    dsi_unit,
    file,
    gravity_of,
    languages,
    named,
    plain,
    ref_type,
)
from tasks.certificate.dcc.results import identification, measurement_results, software, verdict
from tasks.certificate.fields import Field, given
from tasks.certificate.remarks import RemarkRow
from tasks.conformity.capabilities import certificate_as_stated
from tasks.words import Sayable, clauses, message, say

# Administrative data of the DCC: laboratory, client, unit, dates.

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
        *_replaced_identifier(certificate),
    )


def day(when: date) -> str:
    return when.isoformat()


def _replaced_identifier(certificate: Certificate) -> list[Element]:
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


# The sentences of the printed certificate as DCC statements, and the record itself.

RECORD = ref_type("record")


def statements(certificate: Certificate, record: bytes) -> Element:
    """Every statement; `record` is attached to the last."""
    decision, printed = certificate.decision, content(certificate)
    scope = [printed.scope] if printed.scope else []
    in_short = [printed.uncertainty_in_short] if printed.uncertainty_in_short else []
    parts = {
        "basis": printed.statement,
        "object": _lines(printed.calibrated_object),
        "traceability": [printed.traceability],
        "environment": [
            message(
                "dcc-required",
                name=row.name,
                measured=row.measured,
                required=row.required,
                by=message("certificate-label-required"),
            )
            for row in printed.environment
        ],
        "conditions": (
            *(
                message("dcc-rates", axis=rate.axis, points=rate.points, count=rate.count)
                for rate in printed.conditions.rates
            ),
            *_lines(printed.conditions.fields),
            *printed.conditions.sentences,
        ),
        "as-found": _lines(printed.as_found.fields) if printed.as_found else (),
        "uncertainty": (*in_short, *printed.uncertainty, *printed.evaluation),
        "reasons": printed.reasons,
        "remarks": [_remark(row) for row in printed.remarks],
        "readings": [
            message("dcc-field", label=clauses((row.short, row.clause)), value=row.text)
            for row in printed.readings
        ],
        "trace": _lines(printed.trace),
    }
    return dcc.statements(
        verdict(decision, verdict_words(decision), *scope, *_lines(printed.conformity)),
        _sentences(printed.title, _lines((*printed.front, *printed.laboratory_fields))),
        *(
            _sentences(message(f"certificate-label-{name}"), lines)
            for name, lines in parts.items()
            if lines
        ),
        *_replacement_statement(certificate),
        *_units(certificate),
        _record(certificate, record),
    )


def _remark(row: RemarkRow) -> Sayable:
    if not row.segments:
        return row.text
    return message("dcc-remark", remark=row.text, segments=row.segments)


def _lines(fields: tuple[Field, ...]) -> list[Sayable]:
    return [message("dcc-field", label=each.label, value=each.value) for each in fields]


def _sentences(name: Sayable, lines: Sequence[Sayable]) -> Element:
    return dcc.statement(named(name), described(*lines, tag="declaration"))


def _replacement_statement(certificate: Certificate) -> list[Element]:
    replaced = certificate.replaces
    if replaced is None:
        return []
    name = message("dcc-replaces", number=replaced.number, day=replaced.issued_on.isoformat())
    return [dcc.statement(named(name), described(given(replaced.why), tag="declaration"))]


def _units(certificate: Certificate) -> Iterator[Element]:
    """The definition of every unit that D-SI has no name for."""
    gravity = gravity_of(certificate)
    found = certificate.as_found
    results: list[Calibration] = [certificate.calibration, *([found.calibration] if found else [])]
    units = [
        *(item.unit for result in results for item in result.items.values()),
        *(shown.unit for shown in certificate.calibration.information.values()),
    ]
    for unit in dict.fromkeys(units):
        dsi = dsi_unit(unit, gravity)
        if dsi.defined:
            yield dcc.statement(plain("nonSIDefinition", dsi.defined), plain("nonSIUnit", dsi.name))


def _record(certificate: Certificate, record: bytes) -> Element:
    return dcc.statement(
        named(message("dcc-record")),
        dcc.data(file(f"{certificate.number}.json", "application/json", record, tag="byteData")),
        refType=RECORD,
    )


VERSION = "3.3.0"


def record_of(certificate: Certificate) -> bytes:
    """The record as it is stored, attached to the DCC, and identified by its SHA-256 in the QR
    code.
    """
    return certificate.model_dump_json(indent=1).encode()


def dcc_of(certificate: Certificate) -> bytes:
    """The DCC without a signature, in canonical form (C14N 1.0, UTF-8)."""
    record = record_of(certificate)
    stated = certificate_as_stated(certificate)
    return canonical(
        dcc.digitalCalibrationCertificate(
            administration(stated, statements(certificate, record)),
            measurement_results(stated),
            schemaVersion=VERSION,
        )
    )
