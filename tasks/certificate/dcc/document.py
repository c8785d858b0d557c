"""The complete DCC document, made from the certificate alone."""

import re
from collections.abc import Iterator, Sequence
from datetime import date
from decimal import Decimal
from itertools import chain

from schemas.calibration import Calibration, Elements, Information, Item
from schemas.certificate import Certificate, Contact, Laboratory, Party
from schemas.laboratory import MeasurementStandard
from schemas.recording import Curve
from schemas.text import text_of
from schemas.tolerance import Decision, LimitDecision
from tasks.certificate.content import content
from tasks.certificate.cover import party_address, party_name, signatures
from tasks.certificate.cover import verdict as verdict_words
from tasks.certificate.dcc.quantities import (
    UNITS,
    DsiUnit,
    Element,
    canonical,
    covariance_result,
    coverage,
    dcc,
    described,
    dsi_unit,
    file,
    gravity_of,
    languages,
    named,
    plain,
    plain_quantity,
    quantity,
    ref_type,
    si,
    text_quantity,
    without_number,
)
from tasks.certificate.equipment import Setting, accuracy, settings
from tasks.certificate.fields import Field, day, given, quoted
from tasks.certificate.figures import figures, of_figure
from tasks.certificate.results import WITHOUT_U, Group, sections
from tasks.certificate.statements import RemarkRow
from tasks.conformity.capabilities import certificate_as_stated
from tasks.conformity.limits import accepted_edges, probability_text, verdict_title
from tasks.specifications.estimate import ITEMS, Specification
from tasks.specifications.register import SPECIFICATIONS
from tasks.uncertainty.equipment import limit_of
from tasks.words import Sayable, clauses, message, say, statement
from tasks.words.numbers import as_given, exact, stated

# The results: every item of the specification by element, as found and as left.


# Measurement conditions: methods and their settings, air, gravity and latitude of the site.

UNCERTAINTY = "JJF 1059.1-2012"


def methods(calibration: Calibration) -> Iterator[Element]:
    """The specification and the settings with which it was followed; the uncertainty."""
    specification = SPECIFICATIONS[calibration.method]
    quantities = [_setting_quantity(setting) for setting in settings(calibration)]
    yield dcc.usedMethod(
        named(message(f"certificate-method.{calibration.method}")),
        described(given(calibration.procedure)),
        plain("norm", specification.standard),
        *([dcc.usedMethodQuantities(*quantities)] if quantities else []),
    )
    yield dcc.usedMethod(
        named(message("certificate-label-uncertainty")),
        plain("norm", UNCERTAINTY),
        refType="basic_methodMeasurementUncertainty",
    )


def _setting_quantity(setting: Setting) -> Element:
    tag = "usedMethodQuantity"
    if setting.number is None:
        return text_quantity(setting.name, setting.value, tag)
    return plain_quantity(setting.name, Decimal(repr(setting.number)), UNITS[setting.unit], tag)


def influences(
    certificate: Certificate, calibration: Calibration, status: str | None
) -> Iterator[Element]:
    """Air and place; status: before or after an adjustment, where there was one."""
    air, station = calibration.environment, certificate.manifest.station
    temperature, humidity = (
        tuple(Decimal(f"{edge:.1f}") for edge in edges or ())
        for edges in (air.temperature_degc, air.humidity_percent)
    )
    gravity, latitude = (
        () if number is None else (Decimal(as_given(number).replace("−", "-")),)
        for number in (station.gravity_m_s2, station.latitude_deg)
    )
    for name, numbers, unit, kind in (
        ("certificate-environment.temperature", temperature, "degC", "basic_temperature"),
        ("certificate-environment.humidity", humidity, "%", "basic_humidityRelative"),
        ("certificate-field.gravity", gravity, "m/s2", "basic_gravity"),
        ("certificate-field.latitude", latitude, "deg", "basic_latitude"),
    ):
        yield _influence(message(name), numbers, UNITS[unit], kind, status)


def _influence(
    name: Sayable, numbers: tuple[Decimal, ...], unit: DsiUnit, kind: str, status: str | None
) -> Element:
    """One number, the smallest and the largest of it, or that it is not known."""
    edges = ("",) if len(numbers) == 1 else ("Min", "Max")
    quantities = [
        plain_quantity(name, number, unit, refType=kind + edge)
        for number, edge in zip(numbers, edges, strict=False)
    ]
    return dcc.influenceCondition(
        named(name),
        *([dcc.status(status)] if status else []),
        dcc.data(*quantities or [without_number(name)]),
        refType=kind,
    )


# The curves of the figures: lists of numbers, in SI units.


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
        _curve_quantity("dcc-curve.x", curve.x, x_unit),
        _curve_quantity("dcc-curve.y", curve.y, y_unit, expanded),
        refType=ref_type(curve.figure, curve.quantity, curve.axis),
    )


def _curve_quantity(
    name: str, numbers: tuple[float, ...], unit: DsiUnit, *more: Element
) -> Element:
    values = si.valueXMLList(_numbers(numbers, unit))
    listed = si.realListXMLList(values, si.unitXMLList(unit.si), *more)
    return dcc.quantity(named(message(name)), listed)


def _numbers(numbers: tuple[float, ...], unit: DsiUnit) -> str:
    return " ".join(str(unit.in_si(Decimal(repr(number)))) for number in numbers)


# The measurement standards used (clause 8 h), and how far off they may be, as numbers.

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


# The software that made the certificate and its results.

RELEASE = re.compile(r"\d{1,3}(\.\d{1,3}){0,3}")


def software(code_version: str) -> Element:
    """This program; its release as DCC wants it, the whole version beside it."""
    release = RELEASE.match(code_version)
    return dcc.software(
        named("mimucal"),
        dcc.release(f"v{release[0] if release else 0}"),
        dcc.type("application"),
        described(given(code_version)),
    )


# The statement of conformity: on the unit, and on each element that has a limit.

CONFORMITY = "basic_conformity"


def status(decided: Decision | LimitDecision) -> list[Element]:
    """DCC's word for a verdict; none where nothing could be decided."""
    if decided.verdict == "inconclusive":
        return []
    verdict: str = decided.verdict
    word = f"conditional{verdict.capitalize()}" if decided.marginal else verdict
    return [dcc.conformity(word)]


def conformity(limit: LimitDecision, unit: DsiUnit) -> Element:
    """One element against its limits, the limits and the acceptance limits as numbers."""
    chance = limit.probability_of_conformity
    lower, upper = accepted_edges(limit) or (None, None)
    edges = [
        plain_quantity(message(f"dcc-limit.{name}"), number, unit, refType=ref_type(name))
        for name, number in (
            ("lower", exact(limit.lower)), ("upper", exact(limit.upper)),
            ("accept-lower", lower), ("accept-upper", upper),
        )
        if number is not None
    ]  # fmt: skip
    sentences: list[Sayable] = [verdict_title(limit)]
    if chance is not None:
        sentences.append(message("dcc-chance", chance=probability_text(chance)))
    return dcc.metaData(
        named(message("certificate-label-conformity")),
        described(*sentences, tag="declaration"),
        *status(limit),
        *([dcc.data(*edges)] if edges else []),
        refType=CONFORMITY,
    )


def verdict(decision: Decision, *sentences: Sayable) -> Element:
    """The verdict on the unit."""
    return dcc.statement(
        named(message("certificate-label-conformity")),
        *([plain("reference", decision.document)] if decision.document else []),
        described(*sentences, tag="declaration"),
        *(status(decision) if decision.limits else []),
        refType=CONFORMITY,
    )


def measurement_results(certificate: Certificate) -> Element:
    """Lists the results as left, those as found, and what is shown beside them, undecided."""
    found = certificate.as_found
    calibration, decision = certificate.calibration, certificate.decision
    after = "afterAdjustment" if found else None
    parts = [_results("dcc-results", certificate, calibration, decision, after)]
    if found:
        before = (found.calibration, found.decision, "beforeAdjustment")
        parts.append(_results("dcc-as-found", certificate, *before))
    if calibration.information:
        shown = (
            _information(certificate, name, each) for name, each in calibration.information.items()
        )
        parts.append(_result_part("dcc-information", certificate, calibration, after, shown))
    if certificate.curves:
        curves = curve_results(certificate)
        parts.append(_result_part("dcc-curves", certificate, calibration, after, curves))
    return dcc.measurementResults(*equipment(certificate), *parts)


def _results(
    title: str, certificate: Certificate, calibration: Calibration, decision: Decision,
    status: str | None,
) -> Element:  # fmt: skip
    """Every item of the specification's appendix, also those without a value; their covariance."""
    specification = SPECIFICATIONS[calibration.method]
    known = list(chain.from_iterable(section.items for section in specification.layout))
    names = known + [name for name in calibration.items if name not in known]
    printed = sections(calibration, decision, specification)
    groups = chain.from_iterable(section.groups for section in printed)
    items = (
        _item(name, group, certificate, calibration, decision)
        for name, group in zip(names, groups, strict=True)
    )
    together = covariance_result(certificate, calibration)
    more = () if together is None else (together,)
    return _result_part(title, certificate, calibration, status, chain(items, more))


def _result_part(
    title: str, certificate: Certificate, calibration: Calibration, status: str | None,
    results: Iterator[Element],
) -> Element:  # fmt: skip
    return dcc.measurementResult(
        named(message(title)),
        dcc.usedMethods(*methods(calibration)),
        dcc.usedSoftware(software(calibration.code_version)),
        dcc.influenceConditions(*influences(certificate, calibration, status)),
        dcc.results(*results),
    )


def _item(
    name: str, group: Group, certificate: Certificate, calibration: Calibration, decision: Decision
) -> Element:
    item = calibration.items.get(name)
    quantities = _quantities(name, item, group, certificate, decision) if item else []
    return dcc.result(
        named(group.title),
        described(group.clause or "", group.kind or "", *group.sentences),
        dcc.data(dcc.list(*quantities) if quantities else without_number(group.title)),
        refType=ref_type(name),
    )


def _quantities(
    name: str, item: Item, group: Group, certificate: Certificate, decision: Decision
) -> list[Element]:
    """Every element of each value that is printed, with what was decided on it."""
    unit = dsi_unit(item.unit, gravity_of(certificate))
    specification = SPECIFICATIONS[certificate.calibration.method]
    made = []
    for column, (which, values, U) in zip(
        group.columns, _values(name, item, specification), strict=False
    ):
        for element, value in values.items():
            number, expanded = stated(value, U.get(element), item.k)
            of = ITEMS[name].element_title(element) if name in ITEMS else given(element)
            title = message("dcc-element", element=of, column=column)
            decided = [
                conformity(limit, unit)
                for limit in decision.limits
                if (limit.item, limit.element, limit.applied_to) == (name, element, which)
            ]
            label = ".".join((name, element) if which == "value" else (name, which, element))
            more = [dcc.measurementMetaData(*decided)] if decided else []
            budget = item.budgets.get(element)
            at = coverage(item.k, budget.coverage_probability if budget else None)
            made.append(quantity(title, label, number, unit, expanded, at, more))
    return made


def _values(
    name: str, item: Item, specification: Specification
) -> Iterator[tuple[str, Elements, Elements]]:
    """The value by the clause, and the one that is printed beside it; each with its U."""
    yield "value", item.value, item.U
    second = ITEMS[name].second_value if name in ITEMS else None
    beside = getattr(item, second) if second and name not in specification.printed_once else None
    if second and beside:
        yield second, beside, item.U_without_earth_rotation or item.U


def _information(certificate: Certificate, name: str, shown: Information) -> Element:
    """Something that the data show beside the items; nothing is decided on it."""
    title = quoted(text_of(shown, "title") or statement(name))
    unit = dsi_unit(shown.unit, gravity_of(certificate))
    U, made = shown.U or {}, []
    for element, value in shown.value.items():
        number, expanded = stated(value, U.get(element), shown.k, WITHOUT_U)
        of_element = message("dcc-element", element=title, column=given(element))
        at = coverage(shown.k)
        made.append(quantity(of_element, f"{name}.{element}", number, unit, expanded, at))
    return dcc.result(
        named(title),
        described(quoted(shown)),
        dcc.data(dcc.list(*made) if made else without_number(title)),
        refType=f"{ref_type('information')} {ref_type(name)}",
    )


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
    performed = iso_day(certificate.calibrated_on or certificate.issued_on)
    used = [dcc.usedLangCodeISO639_1(language) for language in languages()]
    mandatory = [dcc.mandatoryLangCodeISO639_1(language) for language in languages()]
    return dcc.coreData(
        dcc.countryCodeISO3166_1(COUNTRY),
        *used,
        *mandatory,
        plain("uniqueIdentifier", certificate.number),
        *([dcc.receiptDate(iso_day(order.received))] if order else []),
        dcc.beginPerformanceDate(performed),
        dcc.endPerformanceDate(performed),
        dcc.performanceLocation("other" if order and order.place else "laboratory"),
        *([dcc.issueDate(iso_day(certificate.issued_on))] if certificate.state == "issued" else []),
        *_replaced_identifier(certificate),
    )


def iso_day(when: date) -> str:
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


def record_bytes(certificate: Certificate) -> bytes:
    """The record as it is stored, attached to the DCC, and identified by its SHA-256 in the QR
    code.
    """
    return certificate.model_dump_json(indent=1).encode()


def dcc_of(certificate: Certificate) -> bytes:
    """The DCC without a signature, in canonical form (C14N 1.0, UTF-8)."""
    record = record_bytes(certificate)
    stated = certificate_as_stated(certificate)
    return canonical(
        dcc.digitalCalibrationCertificate(
            administration(stated, statements(certificate, record)),
            measurement_results(stated),
            schemaVersion=VERSION,
        )
    )
