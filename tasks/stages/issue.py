"""Stages: checks a draft, issues it under a number, withdraws an issued certificate.

Each is one transaction, and what is printed is made within it: a process that ends at any moment
leaves a certificate issued whole, or not at all and its number still to be given.
"""

import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import sqlalchemy as sql

from schemas.access import Authority
from schemas.base import Unusable
from schemas.certificate import (
    DEFAULT_PREFIX,
    DEFAULT_SCHEME,
    Certificate,
    Order,
    Replaced,
    State,
    Step,
    StepName,
)
from schemas.orders import AmendOrder, Estimation
from schemas.text import CONTRACTED, text_fields
from schemas.tolerance import Tolerance
from storage import settings
from storage.catalogue import audit_trail, certificates, database, equipment, tables
from storage.catalogue.certificates import Entry, entry_of, record_of
from storage.catalogue.results import calibration_of
from storage.home import Home, environment
from storage.whole_files import is_as_kept
from tasks import conformity
from tasks.certificate.mandatory import missing, standards_of, title_of
from tasks.certificate.pdf import faces_of
from tasks.specifications.register import SPECIFICATIONS
from tasks.stages.authority import check_authorised, why_not
from tasks.stages.certificate_inputs import CertificateInputs, day_of_moment, read_inputs
from tasks.stages.certify import Published, due_date, published
from tasks.stages.estimate import contradictions, how_made, of_manifest
from tasks.stages.stage import announce, stage
from tasks.station.run_manifest import PERSONS
from tasks.words import message, say

if TYPE_CHECKING:
    from tasks.certificate.sign import Signing


# Why a certificate cannot be issued: everything at once.

AGAIN = "certify the run again"
AS_REPORT = (
    "state it and certify the run again, or report less by agreement with the client (--report)"
)


def check_issuable(
    connection: sql.Connection, entry: Entry, certificate: Certificate, home: Home
) -> None:
    """Raises Unusable with every reason for which a certificate cannot be issued."""
    reasons = (
        *_of_limits(certificate),
        *_of_content(certificate),
        *_of_equipment(certificate, home),
        *_of_operator(certificate, home),
        *_of_run(connection, certificate),
        *_of_result(connection, entry),
    )
    if reasons:
        raise Unusable(f"{entry.number} cannot be issued: {'; '.join(reasons)}.")


def _of_limits(certificate: Certificate) -> Iterator[str]:
    """Without limits there is no verdict; a calibration without one must be ordered as such."""
    asked = certificate.order is None or certificate.order.conformity
    if not certificate.decision.limits and asked:
        unit = certificate.manifest.unit
        yield (
            f"it has no verdict, because there are no limits of {unit.manufacturer} {unit.model}: "
            "give them with --tolerance or in the folder tolerances of the home, or let the order "
            f"say conformity = false, and {AGAIN}"
        )


def _of_content(certificate: Certificate) -> Iterator[str]:
    """What clause 8 asks for and it does not state."""
    if absent := [say(each) for each in missing(certificate)]:
        yield f"{'; '.join(absent)}: {AS_REPORT}"


def _of_equipment(certificate: Certificate, home: Home) -> Iterator[str]:
    """Standards that the run contradicts, or without a valid certificate on the day."""
    day = certificate.calibrated_on or certificate.issued_on
    listed = standards_of(certificate)
    yield from contradictions(certificate.manifest, listed, home, day)
    unlisted = {each.serial: each.name for each in of_manifest(certificate.manifest)}
    for serial in unlisted.keys() - {each.serial for each in listed} if listed else ():
        yield f"it does not list {unlisted[serial]} ({serial}), which the run names: {AGAIN}"
    late = {standard.serial: standard for standard in equipment.past_due(home, day)}
    for expired in conformity.expired([late.get(each.serial, each) for each in listed], day):
        yield f"{say(expired).rstrip('.')}; calibrate with equipment that is in date"


def _of_operator(certificate: Certificate, home: Home) -> Iterator[str]:
    """Whoever carried out the measurement, and was not authorised to on its day."""
    standard = SPECIFICATIONS[certificate.calibration.method].standard
    day = certificate.calibrated_on or certificate.issued_on
    laboratory = settings.laboratory(home) or certificate.laboratory
    for person in (certificate.carried_out_by or "").split(PERSONS):
        if why := why_not(laboratory, person or None, "acquire", standard, day):
            yield why


def _of_run(connection: sql.Connection, certificate: Certificate) -> Iterator[str]:
    """A newer result, by the standard's terms alone, that finds the run invalid."""
    if certificate.calibration.validity.verdict == "invalid":
        return  # and it says so
    table, run = tables.results, certificate.calibration.run
    asked = sql.select(table).where(table.c.run == run, database.newest_results())
    for row in connection.execute(asked):
        made = calibration_of(row)
        validity = made.validity
        if validity.verdict == "invalid" and not made.terms:
            yield (
                f"by result {row.id} run {run} is invalid ({validity.reasons[0].rstrip('.')}); "
                "measure again"
            )


def _of_result(connection: sql.Connection, entry: Entry) -> Iterator[str]:
    """A newer result than the one that it prints."""
    table = tables.results.c
    newer = connection.scalar(sql.select(table.id).where(table.supersedes == entry.result))
    if newer:
        amend = f" (`mimucal amend {entry.supersedes}`)" if entry.supersedes else ""
        yield f"it prints result {entry.result}, which {newer} superseded; {AGAIN}{amend}"


ANYBODY = "?"  # who will issue, where the laboratory names nobody
DONE: dict[StepName, str] = {"draft": "drafted", "check": "checked", "issue": "issued"}


@stage("check certificate")
def check(key: str, home: Home, person: str, reason: str | None = None) -> Published:
    """Record that a person checked a draft; Unusable for anything else, for its own author, and for
    a draft that nobody may issue as it is.
    """
    now = datetime.now(UTC)
    with database.changing(home) as connection:
        entry, draft = _at_state(connection, key, home, "draft")
        check_person(draft, person, "check", home)
        checked = _with_step(draft, "check", person, now, reason, "checked", home)
        _check_that_somebody_may_issue(connection, entry, checked, now, home)
        files = _replace(connection, home, entry, checked)
        audit_trail.add(
            connection, person, "check", key, at=now, reason=reason,
            sha256=certificates.hashes(connection, key),
        )  # fmt: skip
    certificates.remove_files([entry], files, home)
    return published(key, home)


@stage("issue certificate")
def issue(key: str, home: Home, person: str, reason: str | None = None) -> Published:
    """Issue a certificate that was checked: it gets its number, and is never changed again.

    It is signed with the laboratory's key, if the home names one. The day of issue is that where
    this program runs. The certificate that it replaces becomes amended. Raises Unusable for what is
    not checked, and with everything at once for which it may not be issued.
    """
    now = datetime.now(UTC)
    signing = signing_for(home, now)
    with database.changing(home) as connection:
        entry, checked = _at_state(connection, key, home, "checked")
        check_person(checked, person, "issue", home)
        issued = _with_step(checked, "issue", person, now, reason, "issued", home)
        check_issuable(connection, entry, issued, home)
        issued = _numbered(connection, issued, now)
        number = issued.number
        if issued.replaces:
            # The certificate that is replaced is still issued, and becomes amended.
            _at_state(connection, issued.replaces.number, home, "issued")
            certificates.change_state(connection, issued.replaces.number, "amended")
        files = _replace(connection, home, entry, issued, draft=key, signing=signing)
        if issued.replaces:
            audit_trail.add(connection, person, "amend", issued.replaces.number, at=now, by=number)
        audit_trail.add(
            connection, person, "issue", number, at=now, reason=reason, draft=key,
            replaces=issued.replaces and issued.replaces.number,
            sha256=certificates.hashes(connection, number),
        )  # fmt: skip
    certificates.remove_files([entry], files, home)
    announce("certificate.issued", entry.serial, certificate=number, person=person)
    return published(number, home)


@stage("withdraw certificate")
def withdraw(number: str, home: Home, person: str, why: str) -> Published:
    """Withdraw an issued certificate; its files stay as they are."""
    with database.changing(home) as connection:
        _at_state(connection, number, home, "issued")
        certificates.change_state(connection, number, "withdrawn")
        audit_trail.add(connection, person, "withdraw", number, reason=why)
    return published(number, home)


def _check_that_somebody_may_issue(
    connection: sql.Connection, entry: Entry, checked: Certificate, now: datetime, home: Home
) -> None:
    """Raises what `issue` would raise today, for the first of those who issue, where it would for
    each: another draft costs less before the check than after it.
    """
    laboratory = settings.laboratory(home) or checked.laboratory
    listed = laboratory.authorised if laboratory else ()
    named = [each.name for each in listed if "issue" in each.may]
    if not named and laboratory and laboratory.issuer:
        named = [laboratory.issuer]
    faults = []
    for issuer in named or [ANYBODY]:
        try:
            if named:
                check_person(checked, issuer, "issue", home)
            issued = _with_step(checked, "issue", issuer, now, None, "issued", home)
            check_issuable(connection, entry, issued, home)
        except Unusable as fault:
            faults.append(fault)
        else:
            return
    raise faults[0]


def check_issued(entry: Entry, home: Home) -> Certificate:
    """The record of a certificate that is issued; raises Unusable for any other."""
    _check_state(entry, "issued")
    return _unchanged(entry, home)


def _at_state(
    connection: sql.Connection, number: str, home: Home, state: State
) -> tuple[Entry, Certificate]:
    """A certificate that nobody else changes, and its record; Unusable where it is not there."""
    entry = certificates.locked(connection, number)
    if entry is None:
        issued = certificates.issued_from(connection, number)
        raise Unusable(
            f"Draft {number} is issued, as certificate {issued}."
            if issued
            else f"There is no certificate {number!r} in {home.path}; `mimucal table certificates` "
            "lists them.",
            message("cause-state.issued", number=number)
            if issued
            else message("cause-none.certificate", name=number),
        )
    _check_state(entry, state)
    return entry, _unchanged(entry, home)


def _check_state(entry: Entry, state: State) -> None:
    number = entry.number
    if entry.state == state and (entry.purpose or state == "issued"):
        return
    if entry.purpose is None and entry.state == "draft":
        raise Unusable(
            f"{number} was drafted by an earlier version; certify run {entry.run} again, and issue "
            "that.",
            message("cause-state.earlier", number=number),
        )
    next_step = {
        "draft": f"is a draft: `mimucal check {number}` comes first",
        "checked": f"is checked already: `mimucal issue {number}` comes next",
        "issued": f"is issued already: `mimucal amend {number}` replaces it",
        "amended": "is amended: take the certificate that replaced it",
        "withdrawn": "is withdrawn: certify its run again",
    }
    if state == "issued" and entry.state == "checked":
        next_step["checked"] = f"is not issued yet: `mimucal issue {number}` comes first"
    cause = message(f"cause-state.{entry.state}", number=number)
    raise Unusable(f"{number} {next_step[entry.state]}.", cause)


def _unchanged(entry: Entry, home: Home) -> Certificate:
    """The record, if its files are those that were kept."""
    for name, sha256 in entry.files.items():
        path = home.path / name
        try:
            same = is_as_kept(path, sha256)
        except OSError as error:
            raise Unusable(
                f"{path} cannot be read ({error.strerror}); restore it from a backup."
            ) from error
        if not same:
            raise Unusable(
                f"{path} was changed after it was kept; restore it from a backup, or certify "
                f"run {entry.run} again."
            )
    return record_of(entry, home)


def _with_step(
    certificate: Certificate,
    step: StepName,
    person: str,
    now: datetime,
    reason: str | None,
    state: State,
    home: Home,
) -> Certificate:
    """The certificate after a step, with the person's title as the home's laboratory has it."""
    title = title_of(settings.laboratory(home) or certificate.laboratory, person)
    titled = text_fields("title", title, CONTRACTED) if title else {}
    taken = Step(step=step, person=person, at=now, reason=reason, **titled)
    return certificate.model_copy(update={"state": state, "steps": (*certificate.steps, taken)})


def _numbered(connection: sql.Connection, certificate: Certificate, now: datetime) -> Certificate:
    """With the next number of its laboratory, and the days that follow from the issue."""
    laboratory, today = certificate.laboratory, day_of_moment(now)
    prefix = laboratory.certificate_prefix if laboratory else DEFAULT_PREFIX
    scheme = laboratory.number_scheme if laboratory else DEFAULT_SCHEME
    series = certificates.series_of(scheme, prefix, today.year)
    dated: dict[str, object] = {"issued_on": today}
    if certificate.calibrated_on is None:
        dated["due"] = due_date(today, certificate.order, certificate.calibration)
    number = certificates.next_number(connection, series)
    return certificate.model_copy(update={"number": number, **dated})


def _replace(
    connection: sql.Connection,
    home: Home,
    entry: Entry,
    certificate: Certificate,
    draft: str | None = None,
    signing: "Signing | None" = None,
) -> list[str]:
    """The next version of a draft in the place of the one before; gives its files' names."""
    certificates.remove(connection, entry)
    evidence = (home.path / entry.evidence).read_bytes() if entry.evidence else None
    faces = faces_of(certificate, signing, evidence)
    return certificates.add(connection, home, certificate, faces, draft=draft)


def check_person(certificate: Certificate, person: str, step: StepName, home: Home) -> None:
    """Raises Unusable for a person who is not authorised or took an earlier step, and for a draft
    of nobody.

    The laboratory of the home says whether they have to be different persons; where there is
    none, that of the certificate.
    """
    laboratory = settings.laboratory(home) or certificate.laboratory
    standard = SPECIFICATIONS[certificate.calibration.method].standard
    act: Authority = "issue" if step == "issue" else "check"
    check_authorised(laboratory, person, act, standard, day_of_moment(datetime.now(UTC)))
    if laboratory is not None and not laboratory.separate_persons:
        return
    number, run = certificate.number, certificate.calibration.run
    if certificate.step("draft") is None:
        raise Unusable(
            f"{number} does not say who drafted it; certify run {run} again with --by NAME, or "
            "name the operator in laboratory.toml."
        )
    for earlier in certificate.steps:
        if _plain(earlier.person) == _plain(person):
            raise Unusable(
                f"{earlier.person} {DONE[earlier.step]} {number}, so another person must "
                f"{step} it; separate_persons = false in laboratory.toml lets one person take "
                "every step.",
                message(f"cause-person.{step}", person=earlier.person, number=number),
            )


def _plain(name: str) -> str:
    return " ".join(unicodedata.normalize("NFKC", name).split()).casefold()


def signing_for(home: Home, at: datetime) -> "Signing | None":
    """The key of `[signing]` in the home's laboratory.toml, opened; None where it names none."""
    laboratory = settings.laboratory(home)
    if laboratory is None or laboratory.signing is None:
        return None
    from tasks.certificate.sign import signing_of

    return signing_of(laboratory.signing, home.path, environment().signing_passphrase, at)


# What an amendment takes over from the certificate it replaces.


@dataclass(frozen=True)
class Amendment:
    """How a run is certified again. run, as_found: ids of runs, or paths of recordings."""

    run: str
    as_found: str | None
    how: Estimation
    inputs: CertificateInputs
    replaces: Replaced


def amendment(order: AmendOrder, home: Home) -> Amendment:
    """The certificate that is to come in the place of an issued one; Unusable for any other.

    Method, terms and way to the uncertainties are those of before. Of another run neither the day
    nor the run as found is taken over.
    """
    entry = entry_of(order.certificate, home)
    old = check_issued(entry, home)
    before = old.calibration.run
    same_run = order.run in (None, before)
    found = old.as_found.calibration.run if old.as_found and same_run else None
    return Amendment(
        run=order.run or before,
        as_found=order.as_found or found,
        how=how_made(old.calibration),
        inputs=_inputs(order, old, same_run),
        replaces=Replaced(number=old.number, issued_on=old.issued_on, why=order.why),
    )


def _inputs(order: AmendOrder, old: Certificate, same_run: bool) -> CertificateInputs:
    given = read_inputs(order)
    client_order = given.order or old.order
    return replace(
        given,
        tolerance=given.tolerance or _limits(old, client_order),
        laboratory=given.laboratory or old.laboratory,
        order=client_order,
        calibrated_on=given.calibrated_on or (old.calibrated_on if same_run else None),
        budget=given.budget or old.budgets,
        invalid_run=given.invalid_run or old.calibration.validity.verdict == "invalid",
        operator=given.operator or (old.operator if same_run else None),
        report=given.report or old.report,
    )


def _limits(old: Certificate, client_order: Order | None) -> Tolerance | None:
    """The limits of the verdict; Unusable where a record of an earlier version lacks them."""
    decided = old.decision.limits and (client_order is None or client_order.conformity)
    if old.tolerance is None and decided:
        raise Unusable(
            f"the record of {old.number} is of an earlier version and does not hold the limits of "
            "its verdict: give them with --tolerance"
        )
    return old.tolerance
