"""The content of the certificate as plain rows, clause 8 a) to l), and that of its annex.

Every text is a message or a statement, which `in_languages` turns into texts by language. The
template lays out only; no sentence and no number is made there.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from schemas.calibration import Calibration, Elements, Item
from schemas.certificate import Amended, AsFound, Certificate, Replaced
from schemas.text import Statement, text_in, text_of
from schemas.tolerance import LimitDecision, Quantity
from tasks.certificate import cover
from tasks.certificate.budgets import Budgets, budgets
from tasks.certificate.conditions import ReportedConditions, conditions
from tasks.certificate.cover import Signature, calibrated_object
from tasks.certificate.equipment import accuracy, settings
from tasks.certificate.fields import NONE, NOT_GIVEN, Field, day, field, given, literal
from tasks.certificate.figures import PrintedFigure, figures
from tasks.certificate.mandatory import standards_of
from tasks.certificate.results import (
    InformationRow,
    Mark,
    PrintedSection,
    information_rows,
    mark,
    sections,
)
from tasks.certificate.statements import (
    ReadingRow,
    RemarkRow,
    basis,
    conformity,
    evaluation,
    readings,
    reasons,
    remarks,
    uncertainty,
    uncertainty_in_short,
)
from tasks.conformity import is_traceable, is_virtual
from tasks.conformity.capabilities import (
    certificate_as_stated,
    not_accredited,
    outside_accreditation,
    raised_elements,
)
from tasks.conformity.decide import deviations
from tasks.conformity.limits import conditional, quantity_title
from tasks.specifications.estimate import ItemDefinition, Specification, item_title, symbol
from tasks.specifications.register import SPECIFICATIONS
from tasks.words import Message, Sayable, clauses, message, say, statement
from tasks.words.numbers import MINUS, as_given, column, quantity, typeset, unit_text

# What an amendment prints of its difference from the certificate that it replaces.


def changes(replaced: Replaced | None) -> tuple[Message, ...]:
    """A sentence for everything that is different (ISO/IEC 17025:2017, 7.8.8.2)."""
    if replaced is None:
        return ()
    if not replaced.changes:
        return (message("certificate-changed.nothing", number=replaced.number),)
    return tuple(
        message(
            "certificate-changed", number=replaced.number,
            what=each.what, before=each.before, after=each.after,
        )
        for each in replaced.changes
    )  # fmt: skip


# The unit as found, before adjustment, beside the unit as left.


@dataclass(frozen=True)
class FoundRow:
    """One element: value and U as found and as left (None: no number), the marks as found."""

    name: Sayable
    letter: str
    sub: str
    found: str | None
    U_found: str | None
    left: str | None
    U_left: str | None
    marks: tuple[Mark, ...]


@dataclass(frozen=True)
class FoundGroup:
    """One item, in units of 10^exponent; quantity: which value, where it is not the clause's."""

    title: Sayable
    quantity: Message | None
    unit: str
    exponent: int
    rows: tuple[FoundRow, ...]


@dataclass(frozen=True)
class FoundSection:
    """What is printed of the unit as found."""

    fields: tuple[Field, ...]
    introduction: Message
    groups: tuple[FoundGroup, ...]


def scope_with_found(certificate: Certificate, scope: Message | None) -> Message | None:
    """The scope of the verdict, for the first page, with the verdict as found."""
    found = certificate.as_found
    if found is None or scope is None:
        return scope
    verdict = cover.verdict(found.decision)
    return message("certificate-scope.as-found", scope=scope, verdict=verdict)


def as_found(certificate: Certificate, specification: Specification) -> FoundSection | None:
    """Every item that is known as found or as left; None for a unit that was not adjusted."""
    found = certificate.as_found
    if found is None:
        return None
    calibration = found.calibration
    return FoundSection(
        fields=(
            field("calibrated", day(found.calibrated_on)),
            field("recording", given(calibration.recording_id)),
            field("run", given(calibration.run)),
            field("digest", given(calibration.digest)),
            field("as-found", cover.verdict(found.decision)),
        ),
        introduction=message("certificate-as-found"),
        groups=tuple(_groups(found, certificate, specification)),
    )


def _groups(
    found: AsFound, certificate: Certificate, specification: Specification
) -> Iterator[FoundGroup]:
    for name, definition in specification.definitions.items():
        before = found.calibration.items.get(name)
        after = certificate.calibration.items.get(name)
        if before is None or after is None:
            continue
        limits = [limit for limit in found.decision.limits if limit.item == name]
        group = _group(definition, before, after, limits)
        if any(row.found or row.left for row in group.rows):
            yield group


def _group(
    definition: ItemDefinition, before: Item, after: Item, limits: list[LimitDecision]
) -> FoundGroup:
    quantity: Quantity = limits[0].applied_to if limits else "value"
    elements, n = definition.elements, len(definition.elements)
    numbers = [_numbers(item, quantity) for item in (before, after)]
    printed = column(
        [values.get(e) for values, _ in numbers for e in elements],
        [U.get(e) for _, U in numbers for e in elements],
        after.k,
    )
    return FoundGroup(
        title=item_title(definition.key),
        quantity=quantity_title(limits[0]) if quantity != "value" else None,
        unit=unit_text(after.unit),
        exponent=printed.exponent,
        rows=tuple(
            FoundRow(
                name=definition.element_title(element),
                letter=definition.letter,
                sub=definition.element_subscript(element),
                found=printed.values[i],
                U_found=printed.uncertainties[i],
                left=printed.values[n + i],
                U_left=printed.uncertainties[n + i],
                marks=tuple(mark(limit) for limit in limits if limit.element == element),
            )
            for i, element in enumerate(elements)
        ),
    )


def _numbers(item: Item, quantity: Quantity) -> tuple[Elements, Elements]:
    """The values that the limits are applied to, and their U."""
    without_earth = quantity == "value_without_earth_rotation"
    own = item.U_without_earth_rotation if without_earth else None
    return getattr(item, quantity) or {}, own or item.U


# What a certificate says of the laboratory's capabilities (CMC) and of its accreditation.


def stated_above(certificate: Certificate) -> tuple[Message, ...]:
    """Names the elements of which a U smaller than the capability was evaluated and then raised."""
    found, laboratory = certificate.as_found, certificate.laboratory
    raised = raised_elements(certificate.calibration, laboratory)
    before = raised_elements(found.calibration, laboratory) if found else {}
    items = tuple(
        message(
            "certificate-capability-item",
            item=item_title(name),
            symbols=", ".join(
                symbol(name, element)
                for element in dict.fromkeys((*raised.get(name, ()), *before.get(name, ())))
            ),
        )
        for name in dict.fromkeys((*raised, *before))
    )
    return (message("certificate-capability.stated", items=items),) if items else ()


def without_accreditation(certificate: Certificate) -> Iterator[Message]:
    """Why nothing refers to the accreditation: of the whole certificate, or of which items."""
    if why := not_accredited(certificate):
        yield message(f"certificate-accreditation-not-claimed.{why}")
    elif outside := outside_accreditation(certificate):
        items = tuple(item_title(name) for name in outside)
        yield message("certificate-capability.outside", items=items)


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
        front=cover.cover_fields(certificate, specification, bool(deviating)),
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


# What two certificates print differently: an amendment, and what it replaces.

NOT_COMPARED = {  # which certificate is replaced is said beside the changes
    field("replaces", "").label,
    field("settings", "").label,  # what they change stands in the values and their U
}


def differences(before: Certificate, after: Certificate) -> tuple[Amended, ...]:
    """Every field, standard, value with U and verdict that is printed otherwise than before."""
    old, new = (
        {label: statement(value) for label, value in _printed(each) if label not in NOT_COMPARED}
        for each in (before, after)
    )
    return tuple(
        Amended(what=statement(label), before=old.get(label, NONE), after=new.get(label, NONE))
        for label in dict.fromkeys((*old, *new))
        if old.get(label) != new.get(label)
    )


def _printed(certificate: Certificate) -> Iterator[tuple[Sayable, Sayable]]:
    printed = content(certificate)
    yield message("certificate-label-conclusion"), printed.verdict_text
    yield message("mandatory-what.laboratory"), printed.laboratory
    yield message("mandatory-what.laboratory-address"), printed.laboratory_address
    for each in (
        *printed.laboratory_fields,
        *printed.front,
        *printed.calibrated_object,
        *printed.conformity,
        *printed.trace,
    ):
        yield each.label, each.value
    operator = printed.signatures[0]
    yield operator.role, operator.name
    standards = [
        message("certificate-amended-standard", name=row.name, serial=row.serial,
                certificate=row.certificate)
        for row in printed.standards
    ]  # fmt: skip
    yield message("certificate-label-standards"), clauses(standards)
    yield message("certificate-label-traceability"), printed.traceability
    for row in printed.environment:
        yield row.name, row.measured
    yield from _values(certificate_as_stated(certificate).calibration)


def _values(calibration: Calibration) -> Iterator[tuple[Sayable, Sayable]]:
    for name, item in calibration.items.items():
        for element, value in item.value.items():
            if value is not None:
                U = item.U.get(element) or 0.0
                label = clauses((item_title(name), symbol(name, element)))
                yield label, quantity(value, U, item.unit)
