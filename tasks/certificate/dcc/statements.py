"""The sentences of the printed certificate as DCC statements, and the record itself."""

from collections.abc import Iterator, Sequence

from schemas.calibration import Calibration
from schemas.certificate import Certificate
from tasks.certificate.content import content
from tasks.certificate.cover import verdict as verdict_words
from tasks.certificate.dcc.conformity import verdict
from tasks.certificate.dcc.quantities import ref_type
from tasks.certificate.dcc.units import dsi_unit, gravity_of
from tasks.certificate.dcc.xml import Element, dcc, described, file, named, plain
from tasks.certificate.fields import Field, given
from tasks.certificate.remarks import RemarkRow
from tasks.words import Sayable, clauses, message

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
        *_replaced(certificate),
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


def _replaced(certificate: Certificate) -> list[Element]:
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
