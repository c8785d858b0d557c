"""The content of the certificate as plain rows, clause 8 a) to l), and that of its annex.

Every text is a message or a statement, which `in_languages` turns into texts by language. The
template lays out only; no sentence and no number is made there.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from schemas.certificate import Certificate
from schemas.text import Statement, text_in, text_of
from tasks.certificate import cover
from tasks.certificate.amended import changes
from tasks.certificate.as_found import FoundSection, as_found, scope_with_found
from tasks.certificate.budgets import Budgets, budgets
from tasks.certificate.calibrated_object import calibrated_object
from tasks.certificate.capabilities import stated_above, without_accreditation
from tasks.certificate.conditions import ReportedConditions, conditions
from tasks.certificate.cover import Signature
from tasks.certificate.decisions import conformity
from tasks.certificate.equipment import accuracy
from tasks.certificate.fields import NOT_GIVEN, Field, day, field, given, literal
from tasks.certificate.figures import PrintedFigure, figures
from tasks.certificate.information import InformationRow, information_rows
from tasks.certificate.mandatory import standards_of
from tasks.certificate.remarks import RemarkRow, remarks
from tasks.certificate.results import PrintedSection, sections
from tasks.certificate.settings import settings
from tasks.certificate.statements import (
    ReadingRow,
    basis,
    evaluation,
    readings,
    reasons,
    uncertainty,
    uncertainty_in_short,
)
from tasks.conformity import is_traceable, is_virtual
from tasks.conformity.capabilities import certificate_as_stated
from tasks.conformity.deviations import deviations
from tasks.conformity.reasons import conditional
from tasks.specifications.register import SPECIFICATIONS
from tasks.specifications.specification import Specification
from tasks.words import Message, Sayable, clauses, message, say, statement
from tasks.words.rounding import MINUS, as_given
from tasks.words.typography import typeset


@dataclass(frozen=True)
class StandardRow:
    """Clause 8 h): name, serial number, accuracy, certificate number, valid until."""

    name: Sayable
    serial: Sayable
    accuracy: Sayable
    certificate: Sayable
    valid_until: Sayable


@dataclass(frozen=True)
class ConditionRow:
    """Clause 8 i): what was measured during the run, and what the specification asks for."""

    name: Message
    measured: Sayable
    required: str


@dataclass(frozen=True)
class Content:
    """The whole certificate in the order in which it is printed; from the readings on: its annex,
    for the laboratory and whoever asks how the results came about.
    """

    number: str
    title: Message
    is_report: bool
    watermark: Message | None
    laboratory: Sayable
    laboratory_address: Sayable
    laboratory_fields: tuple[Field, ...]
    front: tuple[Field, ...]
    verdict: str
    verdict_text: Message
    scope: Message | None
    uncertainty_in_short: Message | None
    signatures: tuple[Signature, ...]
    statement: tuple[Message, ...]
    calibrated_object: tuple[Field, ...]
    standards: tuple[StandardRow, ...]
    traceability: Message
    environment: tuple[ConditionRow, ...]
    conditions: ReportedConditions
    sections: tuple[PrintedSection, ...]
    uncertainty: tuple[Message, ...]
    as_found: FoundSection | None
    conformity: tuple[Field, ...]
    reasons: tuple[Message, ...]
    remarks: tuple[RemarkRow, ...]
    readings: tuple[ReadingRow, ...]
    evaluation: tuple[Message, ...]
    budgets: Budgets | None
    figures: tuple[PrintedFigure, ...]
    information: tuple[InformationRow, ...]
    trace: tuple[Field, ...]


def content(certificate: Certificate) -> Content:
    """Everything the certificate prints, every U as it is stated."""
    capability, outside = stated_above(certificate), without_accreditation(certificate)
    certificate = certificate_as_stated(certificate)
    calibration, decision = certificate.calibration, certificate.decision
    specification, laboratory = SPECIFICATIONS[calibration.method], certificate.laboratory
    configuration, order = certificate.configuration, certificate.order
    deviating = deviations(calibration, configuration, order.waived_conditions if order else ())
    marked = certificate.state != "issued"
    kind = "report" if certificate.report else "calibration"
    if calibration.validity.verdict == "invalid":
        kind = "invalid-run"
    title = message(f"certificate-title.{kind}")
    state: str | None = certificate.state if marked else None
    if is_virtual(standards_of(certificate)):
        title, state = message("certificate-title.virtual", title=title), state or "virtual"
    return Content(
        number=certificate.number,
        title=title,
        is_report=kind != "calibration",
        watermark=message(f"certificate-watermark.{state}") if state else None,
        laboratory=cover.party_name(laboratory.party if laboratory else None),
        laboratory_address=cover.party_address(laboratory.party if laboratory else None),
        laboratory_fields=tuple(cover.laboratory_fields(laboratory)),
        front=cover.front(certificate, specification, bool(deviating)),
        verdict=decision.verdict,
        verdict_text=cover.verdict(decision),
        scope=scope_with_found(certificate, cover.scope(calibration, decision, specification)),
        uncertainty_in_short=uncertainty_in_short(calibration),
        signatures=cover.signatures(certificate),
        statement=(
            *basis(calibration, specification, bool(deviating)),
            *outside,
            *changes(certificate.replaces),
        ),
        calibrated_object=calibrated_object(certificate),
        standards=_standards(certificate),
        traceability=_traceability(certificate),
        environment=_environment(certificate, specification),
        conditions=conditions(calibration, certificate.manifest, configuration, specification),
        sections=sections(calibration, decision, specification),
        uncertainty=(*uncertainty(calibration), *capability),
        as_found=as_found(certificate, specification),
        conformity=conformity(decision),
        reasons=(*reasons(calibration, decision, deviating), *conditional(decision)),
        remarks=remarks(calibration, certificate.manifest, deviating),
        readings=readings(calibration),
        evaluation=(*evaluation(calibration, decision, specification), *_validation(certificate)),
        budgets=budgets(calibration) if certificate.budgets else None,
        figures=figures(certificate),
        information=information_rows(calibration),
        trace=_trace(certificate),
    )


def in_languages(part: Any, languages: Sequence[str]) -> Any:
    """A part of the content with every text in the languages, one after the other.

    Messages are typeset by the rules of each language; the user's own texts are not changed.
    """
    if isinstance(part, Message):
        return tuple(literal(typeset(say(part, lang), lang)) for lang in languages)
    if isinstance(part, Statement):
        words = statement(part).words  # as the record has kept them
        return tuple(literal(words[language]) for language in languages)
    if isinstance(part, str):
        return literal(part)
    if isinstance(part, tuple):
        return tuple(in_languages(entry, languages) for entry in part)
    if is_dataclass(part) and not isinstance(part, type):
        values = {f.name: in_languages(getattr(part, f.name), languages) for f in fields(part)}
        return type(part)(**values)
    return part


def _validation(certificate: Certificate) -> tuple[Message, ...]:
    """Which record validates the estimation."""
    if certificate.validation is None:
        return ()
    record = text_in(certificate.validation, certificate.validation_message)
    return (message("certificate-validation", record=record or ""),)


def _standards(certificate: Certificate) -> tuple[StandardRow, ...]:
    equipment = certificate.laboratory.equipment if certificate.laboratory else ()
    rows = [
        StandardRow(
            given(text_of(standard, "name")),
            given(standard.serial),
            accuracy(standard),
            given(standard.certificate),
            day(standard.valid_until),
        )
        for standard in equipment
    ]
    return tuple(rows) or (StandardRow(*[NOT_GIVEN] * len(fields(StandardRow))),)


def _traceability(certificate: Certificate) -> Message:
    """To what the results are traceable (ISO/IEC 17025:2017, 7.8.4.1 c), by which certificates.

    Nothing is claimed for an invalid run, nor by standards without a traceable certificate.
    """
    if certificate.calibration.validity.verdict == "invalid":
        return message("certificate-traceability.invalid-run")
    standards = certificate.laboratory.equipment if certificate.laboratory else ()
    bare = tuple(given(text_of(each, "name")) for each in standards if not is_traceable(each))
    if len(bare) == len(standards):
        return message("certificate-traceability.none")
    if bare:
        return message("certificate-traceability.in-part", names=bare)
    return message("certificate-traceability")


def _environment(
    certificate: Certificate, specification: Specification
) -> tuple[ConditionRow, ...]:
    air = certificate.calibration.environment
    low, high = specification.conditions.temperature_degc
    middle, half = (low + high) / 2, (high - low) / 2
    dry, damp = specification.conditions.humidity_percent
    return tuple(
        ConditionRow(message(f"certificate-environment.{name}"), _range(measured, unit), required)
        for name, measured, unit, required in (
            ("temperature", air.temperature_degc, "°C", f"({middle:g} ± {half:g}) °C"),
            ("humidity", air.humidity_percent, "%", f"{dry:g} % … {damp:g} %"),
        )
    )


def _range(measured: tuple[float, float] | None, unit: str) -> Sayable:
    if measured is None:
        return NOT_GIVEN
    edges = dict.fromkeys(f"{value:.1f} {unit}".replace("-", MINUS) for value in measured)
    return given(" … ".join(edges))


def _trace(certificate: Certificate) -> tuple[Field, ...]:
    """Where the result comes from, so that it can be made again."""
    calibration, station = certificate.calibration, certificate.manifest.station
    gravity, latitude = station.gravity_m_s2, station.latitude_deg
    made_with = tuple(setting.printed for setting in settings(calibration))
    return (
        field("recording", given(calibration.recording_id)),
        field("run", given(calibration.run)),
        field("digest", given(calibration.digest)),
        field("method", message(f"certificate-method.{calibration.method}")),
        field("procedure", given(calibration.procedure)),
        field("code-version", given(calibration.code_version)),
        field("settings", clauses(made_with) if made_with else NOT_GIVEN),
        field("station", given(station.id)),
        field("gravity", given(None if gravity is None else f"{as_given(gravity)} m/s²")),
        field("latitude", given(None if latitude is None else f"{as_given(latitude)}°")),
    )
