"""Stages: checks a draft, issues it under a number, withdraws an issued certificate.

Each is one transaction, and what is printed is made within it: a process that ends at any moment
leaves a certificate issued whole, or not at all and its number still to be given.
"""

import unicodedata
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import sqlalchemy as sql

from schemas.access import Authority
from schemas.base import Unusable
from schemas.certificate import DEFAULT_PREFIX, DEFAULT_SCHEME, Certificate, State, Step, StepName
from schemas.text import CONTRACTED, text_fields
from storage import settings
from storage.catalogue import certificates, database, keep_certificate, trail
from storage.catalogue.certificates import Entry, record_of
from storage.environment import environment
from storage.home import Home
from storage.whole_files import is_as_kept
from tasks.certificate.documents import faces_of
from tasks.certificate.mandatory import title_of
from tasks.specifications.register import SPECIFICATIONS
from tasks.stages.authority import check_authorised
from tasks.stages.certificate_inputs import day_of_moment
from tasks.stages.certify import due_date
from tasks.stages.issuable import check_issuable
from tasks.stages.published import Published, published
from tasks.stages.stage import announce, stage
from tasks.words import message

if TYPE_CHECKING:
    from tasks.certificate.sign import Signing

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
        trail.add(
            connection, person, "check", key, at=now, reason=reason,
            sha256=keep_certificate.hashes(connection, key),
        )  # fmt: skip
    keep_certificate.remove_files([entry], files, home)
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
            keep_certificate.change_state(connection, issued.replaces.number, "amended")
        files = _replace(connection, home, entry, issued, draft=key, signing=signing)
        if issued.replaces:
            trail.add(connection, person, "amend", issued.replaces.number, at=now, by=number)
        trail.add(
            connection, person, "issue", number, at=now, reason=reason, draft=key,
            replaces=issued.replaces and issued.replaces.number,
            sha256=keep_certificate.hashes(connection, number),
        )  # fmt: skip
    keep_certificate.remove_files([entry], files, home)
    announce("certificate.issued", entry.serial, certificate=number, person=person)
    return published(number, home)


@stage("withdraw certificate")
def withdraw(number: str, home: Home, person: str, why: str) -> Published:
    """Withdraw an issued certificate; its files stay as they are."""
    with database.changing(home) as connection:
        _at_state(connection, number, home, "issued")
        keep_certificate.change_state(connection, number, "withdrawn")
        trail.add(connection, person, "withdraw", number, reason=why)
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
    entry = keep_certificate.locked(connection, number)
    if entry is None:
        issued = keep_certificate.issued_from(connection, number)
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
    """The sentence for a step that is not the next one."""
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
    keep_certificate.remove(connection, entry)
    evidence = (home.path / entry.evidence).read_bytes() if entry.evidence else None
    faces = faces_of(certificate, signing, evidence)
    return keep_certificate.add(connection, home, certificate, faces, draft=draft)


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
