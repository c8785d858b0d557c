"""The first page: client, unit, dates (clause 8 a to g, k, l; clause 9), verdict and scope."""

from collections.abc import Iterator
from dataclasses import dataclass

from schemas.calibration import Calibration
from schemas.certificate import Certificate, Laboratory, Party, StepName
from schemas.text import text_of
from schemas.tolerance import Decision
from tasks.certificate.fields import NOT_GIVEN, Field, day, field, given, literal, slug
from tasks.certificate.mandatory import issuer_title, unstated
from tasks.conformity.limits import verdict_title
from tasks.specifications.estimate import ITEMS, Specification
from tasks.words import Message, Sayable, message
from tasks.words.numbers import as_given


@dataclass(frozen=True)
class Signature:
    """A place to sign: the role, the name, the title where there is one, and the date."""

    role: Message
    name: Sayable
    title: Sayable | None = None
    date: Sayable | None = None


def party_name(party: Party | None) -> Sayable:
    return given(text_of(party, "name")) if party else NOT_GIVEN


def party_address(party: Party | None) -> Sayable:
    return given(text_of(party, "address")) if party else NOT_GIVEN


def by_method(what: str, calibration: Calibration, deviates: bool) -> str:
    """The message of a method, or of a calibration by it that missed a condition."""
    deviates = deviates or any(remark.blocks_pass for remark in calibration.remarks)
    return f"certificate-{what}.{calibration.method}" + "-deviating" * deviates


def by_document(what: str, specification: Specification) -> str:
    """The message of the document that is followed."""
    return f"certificate-{what}.{slug(specification.standard)}"


def cover_fields(
    certificate: Certificate, specification: Specification, deviates: bool
) -> tuple[Field, ...]:
    """Clause 8 e), f), g) and clause 9; deviates: whether a condition was not shown to be met."""
    followed = by_method("followed", certificate.calibration, deviates)
    unit, order = certificate.manifest.unit, certificate.order
    client = order.client if order else None
    return (
        field("client", party_name(client)),
        field("client-address", party_address(client)),
        field("object", message(by_document("object", specification))),
        field("manufacturer", given(unit.manufacturer)),
        field("model", given(unit.model)),
        field("serial", given(unit.serial)),
        field("specification", message(followed)),
        field("received", day(order.received if order else None)),
        field("calibrated", day(certificate.calibrated_on)),
        *_report(certificate),
        *_replaced(certificate),
        *_place(certificate),
        *_due(certificate),
    )


def _report(certificate: Certificate) -> Iterator[Field]:
    """That it is no certificate, by which agreement, and what it leaves out."""
    if not certificate.report:
        return
    agreement, left_out = given(certificate.report), [each.what for each in unstated(certificate)]
    if not left_out:
        yield field("report", message("certificate-report", agreement=agreement))
        return
    parts = tuple(left_out)
    yield field(
        "report", message("certificate-report.left-out", agreement=agreement, left_out=parts)
    )


def _replaced(certificate: Certificate) -> Iterator[Field]:
    """Which certificate it takes the place of, and why (ISO/IEC 17025:2017, 7.8.8)."""
    if replaced := certificate.replaces:
        named = message(
            "certificate-replaced", number=replaced.number,
            day=replaced.issued_on.isoformat(), why=given(replaced.why),
        )  # fmt: skip
        yield field("replaces", named)


def _place(certificate: Certificate) -> Iterator[Field]:
    """Where it was calibrated, if not at the laboratory's address: as ordered goes first."""
    for paper in (certificate.order, certificate.laboratory):
        if paper and (place := text_of(paper, "place")):
            yield field("place", place)
            return


def laboratory_fields(laboratory: Laboratory | None) -> Iterator[Field]:
    """Accreditation and contact of the laboratory, where they are known."""
    if laboratory is None:
        return
    if accreditation := text_of(laboratory, "accreditation"):
        yield field("accreditation", accreditation)
    contact = laboratory.contact
    if reached := [literal(way) for way in (contact.phone, contact.e_mail, contact.web) if way]:
        yield field("contact", given(", ".join(reached)))


def _due(certificate: Certificate) -> Iterator[Field]:
    """When the unit comes back, where that was agreed on (ISO/IEC 17025:2017, 7.8.4.3)."""
    if certificate.due is None:
        return
    from_issue = message("certificate-due-from-issue", day=certificate.due.isoformat())
    yield field("due", day(certificate.due) if certificate.calibrated_on else from_issue)


def signatures(certificate: Certificate) -> tuple[Signature, ...]:
    """Clause 8 k), l): who carried out the measurement, and who took the steps."""
    waiting = certificate.state in ("draft", "checked")
    issued = message("certificate-not-issued") if waiting else day(certificate.issued_on)
    operator, checker, issuer = (
        message(f"certificate-role.{role}") for role in ("operator", "checker", "issuer")
    )
    return (
        Signature(operator, given(certificate.carried_out_by)),
        Signature(checker, _person(certificate, "check")),
        Signature(issuer, _person(certificate, "issue"), given(issuer_title(certificate)), issued),
    )


def _person(certificate: Certificate, name: StepName) -> Sayable:
    """Who took a step; whom the laboratory names, for what was issued when steps were not kept."""
    step, lab = certificate.step(name), certificate.laboratory
    if step is not None:
        return given(step.person)
    if certificate.steps or certificate.state in ("draft", "checked"):
        return message(f"certificate-step-open.{name}")
    named = {"check": lab.checker, "issue": lab.issuer} if lab else {}
    return given(named.get(name))


def verdict(decision: Decision) -> Message:
    """The verdict in words; without any limit there is no statement of conformity."""
    return verdict_title(decision) if decision.limits else message("certificate-no-statement")


def scope(
    calibration: Calibration, decision: Decision, specification: Specification
) -> Message | None:
    """How many of the items the verdict covers; None if it covers none."""
    if calibration.validity.verdict == "invalid":
        return message("conformity-invalid-run")
    if not decision.limits:
        return None
    limited = dict.fromkeys(limit.item for limit in decision.limits)
    failed = {limit.item for limit in decision.limits if limit.verdict == "fail"}
    undecided = {limit.item for limit in decision.limits if limit.verdict == "inconclusive"}
    sentence = message(
        f"certificate-scope.{decision.verdict}",
        limited=len(limited), items=len({*specification.required, *limited}), failed=len(failed),
        decided=len(failed | (limited.keys() - undecided)),
    )  # fmt: skip
    for what, count in (
        ("in-part", sum(not _whole(decision, item) for item in limited)),
        ("near", len({limit.item for limit in decision.limits if limit.marginal})),
    ):
        if count:
            sentence = message(f"certificate-scope.{what}", scope=sentence, count=count)
    return sentence


def _whole(decision: Decision, item: str) -> bool:
    """Whether every element that the specification names has a limit."""
    named = ITEMS[item].elements if item in ITEMS else ()
    limited = {limit.element for limit in decision.limits if limit.item == item}
    return limited == {"all"} or limited >= set(named)


# The calibrated object: its condition, its configuration, and whether it was adjusted.
#
# ISO/IEC 17025:2017, 7.8.2.1 g), 7.8.4.1 d) and 7.8.5.

NUMBERS = ("rate_range_deg_s", "accel_range_g", "output_rate_hz", "bandwidth_hz")


def calibrated_object(certificate: Certificate) -> tuple[Field, ...]:
    """What is known of the unit as it was calibrated; condition and range also where nobody says.

    A certificate without results as found is of a unit that was not adjusted.
    """
    configuration = certificate.configuration
    adjusted = "no" if certificate.as_found is None else "yes"
    return (
        field("condition", given(text_of(configuration, "condition"))),
        *_configuration(certificate),
        field("adjustment", message(f"certificate-adjusted.{adjusted}")),
        field("sampling", message("certificate-sampling")),
    )


def _configuration(certificate: Certificate) -> Iterator[Field]:
    configuration = certificate.configuration
    for name in NUMBERS:
        value: float | None = getattr(configuration, name)
        if value is not None:
            yield field(_label(name), _quantity(name, value))
        elif name == "rate_range_deg_s":
            yield field(_label(name), given(None))
    if configuration.firmware:
        yield field("firmware", given(configuration.firmware))


def _label(name: str) -> str:
    return name.removesuffix("_deg_s").removesuffix("_g").removesuffix("_hz").replace("_", "-")


def _quantity(name: str, value: float) -> Sayable:
    """A range counts on either side of zero."""
    if name.endswith("_hz"):
        return given(f"{as_given(value)} Hz")
    return given(f"±{as_given(value)} {'°/s' if name.endswith('_deg_s') else 'g'}")
