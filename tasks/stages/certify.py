"""Stage: compares the result with the limits and makes a certificate."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, date, datetime
from pathlib import Path

import sqlalchemy as sql

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.certificate import AsFound, Certificate, Laboratory, Order, Replaced, State, Step
from schemas.laboratory import MeasurementStandard
from schemas.recording import Manifest
from schemas.station import configuration_of
from schemas.text import texts_of
from schemas.tolerance import Decision
from storage import settings
from storage.catalogue import audit_trail, certificates, database, runs
from storage.catalogue.certificates import Entry, entry_of, record_of
from storage.catalogue.runs import Run
from storage.home import Home
from tasks import conformity, reminders
from tasks.calibrate.evidence_file import why_none
from tasks.certificate.content import differences
from tasks.certificate.figures import curves_of_run, history_curves
from tasks.certificate.mandatory import missing
from tasks.certificate.pdf import faces_of
from tasks.conformity.capabilities import certificate_as_stated
from tasks.specifications.register import SPECIFICATIONS
from tasks.stages.certificate_inputs import (
    CertificateInputs,
    check_order,
    day_of,
    day_of_calibration,
    day_of_moment,
    manifest_fields,
    operator_of,
    tolerance_of,
    with_appearance,
)
from tasks.stages.estimate import (
    as_text,
    contradictions,
    evidence_of,
    in_use,
    standards_in_use,
)
from tasks.stages.stage import announce, stage
from tasks.validation import record
from tasks.words import Message, message, statement

# A certificate as it stands in the store.


@dataclass(frozen=True)
class Published:
    """A certificate, what became of it, and where it lies.

    state: its record's own, or amended or withdrawn since. missing: what keeps a draft from being
    issued, a sentence for each entry of clause 8 that it does not state.
    """

    certificate: Certificate
    state: State
    pdf: Path
    dcc: Path | None
    record: Path
    evidence: Path | None
    missing: tuple[Message, ...]

    @property
    def due(self) -> date | None:
        """The day of recalibration; None once another certificate or none counts."""
        return None if self.state in ("amended", "withdrawn") else self.certificate.due


def published(number: str, home: Home) -> Published:
    """The certificate with a number, or the draft with a key; raises Unusable for none."""
    entry = entry_of(number, home)
    certificate = record_of(entry, home)
    return Published(
        certificate=certificate,
        state=entry.state,
        pdf=home.path / entry.pdf,
        dcc=home.path / entry.dcc if entry.dcc else None,
        record=home.path / entry.record,
        evidence=home.path / entry.evidence if entry.evidence else None,
        missing=_missing(certificate, home) if entry.state in ("draft", "checked") else (),
    )


def _missing(certificate: Certificate, home: Home) -> tuple[Message, ...]:
    """With the titles of those who may issue, which the record does not hold."""
    laboratory, own = certificate.laboratory, settings.laboratory(home)
    if laboratory and own:
        laboratory = laboratory.model_copy(update={"authorised": own.authorised})
    return missing(certificate.model_copy(update={"laboratory": laboratory}))


# Stores a draft certificate: one for each run and purpose, the latest.

DRAFT = "draft"  # the number of a draft that has no key yet
UNNAMED_DRAFTER = "not named"  # who drafted, if not named


def keep_draft(
    certificate: Certificate, home: Home, now: datetime, evidence: bytes | None = None
) -> Published:
    """Keeps a draft in the place of the one before it of the same run and purpose.

    Raises Unusable where a certificate of that run and purpose is issued, unless this one amends
    it, and where the draft before amends another certificate and this one does not.
    """
    with database.changing(home) as connection:
        result = certificates.result_of(connection, certificate)
        before = _before(connection, certificate, home)
        run = certificate.calibration.run
        earlier = [entry for entry in before if entry.purpose is None]  # has a number: it stays
        dropped = [entry for entry in before if entry.purpose is not None]
        own = next((entry.number for entry in dropped if entry.run == run), None)
        key = own or certificates.free_key(connection, run)
        for entry in dropped:
            certificates.remove(connection, entry)
        for entry in earlier:
            certificates.change_state(connection, entry.number, "withdrawn")
        draft = certificate.model_copy(update={"number": key})
        files = certificates.add(connection, home, draft, faces_of(draft, None, evidence))
        step, replaces = draft.step("draft"), draft.replaces
        person = step.person if step else UNNAMED_DRAFTER
        for entry in earlier:
            audit_trail.add(
                connection, person, "withdraw", entry.number, at=now, reason=f"draft {key}"
            )
        audit_trail.add(
            connection, person, "draft", key, at=now, run=run, result=result,
            purpose=draft.purpose, reason=step.reason if step else None,
            replaces=replaces and replaces.number, dropped=[entry.number for entry in dropped],
            sha256=certificates.hashes(connection, key),
        )  # fmt: skip
    certificates.remove_files(dropped, files, home)
    return published(key, home)


def _before(connection: sql.Connection, certificate: Certificate, home: Home) -> list[Entry]:
    """The drafts that this one replaces; raises Unusable if it may not."""
    run, replaces = certificate.calibration.run, certificate.replaces
    found = {
        entry.number: entry
        for entry in certificates.live(connection, run)
        if (entry.purpose or _purpose_of(entry, home)) == certificate.purpose
    }
    if replaces:
        found |= {
            entry.number: entry
            for entry in certificates.drafts_in_place_of(connection, replaces.number)
        }
        found.pop(replaces.number, None)
    for entry in found.values():
        if entry.state == "issued":
            raise Unusable(
                f"run {run} has certificate {entry.number}, issued on {entry.issued_on}; "
                f"`mimucal amend {entry.number} --why REASON` makes another one in its place.",
                message("cause-state.issued", number=entry.number),
            )
        other = entry.supersedes if not replaces or replaces.number != entry.supersedes else None
        if other and _is_issued(connection, other):
            raise Unusable(
                f"draft {entry.number} of run {run} amends certificate {entry.supersedes}; "
                f"`mimucal amend {entry.supersedes} --why REASON` makes it again."
            )
    return list(found.values())


def _is_issued(connection: sql.Connection, number: str) -> bool:
    """Otherwise it cannot be replaced any more: it was withdrawn, or already amended."""
    entry = certificates.locked(connection, number)
    return entry is not None and entry.state == "issued"


def _purpose_of(entry: Entry, home: Home) -> str | None:
    """The purpose of what an earlier version kept; None for a record that cannot be read."""
    try:
        return record_of(entry, home).purpose
    except Unusable:
        return None


MOST = 20  # the last ones show how a unit moves


@stage("decide and publish")
def certify(
    run: Run,
    calibration: Calibration,
    home: Home,
    inputs: CertificateInputs,
    as_found: tuple[Run, Calibration] | None = None,
    replaces: Replaced | None = None,
) -> Published:
    """Decide on the unit and keep a draft certificate, in the place of the one before it.

    Limits and laboratory come from the home where they are not given. The certificate stays a
    draft, without a number, until one person has checked and another has issued it. as_found: of
    the unit before it was adjusted, decided by the same limits. replaces: the certificate that this
    one amends; the draft says what is different. Dates are days where this program runs. Raises
    Unusable for an invalid run, unless its report is asked for, and for papers that contradict the
    run.
    """
    _check_run(run, calibration, inputs)
    recording = runs.load(run, home)
    manifest = recording.manifest
    free = manifest_fields(manifest.model_extra or {}, run)
    tolerance = tolerance_of(inputs, run, manifest.unit, home)
    in_run = in_use(recording, home, inputs.laboratory)
    given = laboratory = in_run.laboratory
    recording = in_run.certified
    order, now = inputs.order, datetime.now(UTC)
    today = day_of_moment(now)
    calibrated_on = day_of_calibration(free, inputs, run)
    operator = operator_of(free, inputs, run)
    equipment = _standards(manifest, home, laboratory, calibrated_on)
    if laboratory:
        laboratory = laboratory.model_copy(update={"equipment": equipment})
        laboratory = with_appearance(laboratory, home)
    check_order(order, calibrated_on, today)
    if laboratory:
        conformity.check_capabilities(laboratory.capabilities)
    validated = settings.validation(home) or record.shipped()
    on = calibrated_on or today
    configuration = configuration_of(manifest.unit, order.configuration if order else None)
    waived = order.waived_conditions if order else ()

    def decide(result: Calibration, used: tuple[MeasurementStandard, ...]) -> Decision:
        deviating = conformity.deviations(result, configuration, waived)
        unmet = (each.printed for each in deviating if not each.waived)
        doubts = record.doubts_of(validated, result)
        standing = (
            *(() if conformity.is_virtual(used) else conformity.untraceable(used)),
            *conformity.expired(used, on),
            *conformity.failed_checks(used),
            *conformity.smaller_than_stated(result, used, on),
        )
        stated = conformity.as_stated(result, laboratory)
        return conformity.decide(stated, tolerance, (*standing, *unmet), doubts)

    decision = decide(calibration, equipment)
    evidence = None
    if why_none(calibration) is None:
        stated = conformity.as_stated(calibration, laboratory)
        evidence = as_text(evidence_of(stated, in_run, decision)).encode()
    found = as_found and _as_found(as_found, (run, calibration), home, inputs, given, decide)
    named = statement(record.named(validated, calibration))
    drafter = inputs.by or (laboratory.operator if laboratory else None)
    reason = replaces.why if replaces else None
    drafted = Step(step="draft", person=drafter, at=now, reason=reason) if drafter else None
    certificate = Certificate(
        number=DRAFT,
        state="draft",
        calibrated_on=calibrated_on,
        issued_on=today,
        due=due_date(on, order, calibration),
        laboratory=laboratory,
        order=order,
        manifest=manifest,
        calibration=calibration,
        decision=decision,
        tolerance=tolerance,
        operator=operator,
        report=inputs.report,
        as_found=found,
        budgets=inputs.budget,
        validation=named.pair,
        validation_message=named.message,
        curves=curves_of_run(recording, calibration),
        steps=(drafted,) if drafted else (),
        replaces=replaces,
        evidence_sha256=hashlib.sha256(evidence).hexdigest() if evidence else None,
    )
    earlier = map(certificate_as_stated, earlier_certificates(run, calibrated_on, home))
    moved = tuple(history_curves(certificate_as_stated(certificate), tuple(earlier)))
    drawn = certificate.model_copy(update={"curves": (*certificate.curves, *moved)})
    if replaces:
        changed = differences(certificates.find(replaces.number, home), drawn)
        named_changes = replaces.model_copy(update={"changes": changed})
        drawn = drawn.model_copy(update={"replaces": named_changes})
    return keep_draft(drawn, home, now, evidence)


def _standards(
    manifest: Manifest, home: Home, laboratory: Laboratory | None, day: date | None
) -> tuple[MeasurementStandard, ...]:
    """The standards of a run; Unusable, with both values, where other papers contradict it."""
    listed = laboratory.equipment if laboratory else ()
    if found := contradictions(manifest, listed, home, day):
        raise Unusable(
            f"{'; '.join(found)}: correct laboratory.toml, the register or the station file, so "
            "that they agree on what was used"
        )
    return standards_in_use(manifest, home, laboratory, day)


def due_date(from_day: date, order: Order | None, calibration: Calibration) -> date | None:
    """When a unit comes back that was calibrated on a day (ISO/IEC 17025:2017, 7.8.4.3).

    None where the order agrees on none, and after an invalid run, which calibrated nothing.
    """
    invalid = calibration.validity.verdict == "invalid"
    if invalid or order is None or not order.agrees_on_recalibration:
        return None
    months = order.interval_months or SPECIFICATIONS[calibration.method].interval_months
    return reminders.due_date(from_day, months)


def _as_found(
    found: tuple[Run, Calibration],
    left: tuple[Run, Calibration],
    home: Home,
    inputs: CertificateInputs,
    laboratory: Laboratory | None,
    decide: Callable[[Calibration, tuple[MeasurementStandard, ...]], Decision],
) -> AsFound:
    """The result as found, beside that as left; Unusable where they cannot be of one adjustment."""
    (run, calibration), (left_run, left_calibration) = found, left
    _check_run(run, calibration, inputs)
    if run.id == left_run.id:
        raise Unusable(
            f"--as-found {run.id} is the run to certify itself; name the run that was taken before "
            "the unit was adjusted."
        )
    for name, its, others in (
        ("unit", _unit_of(run), _unit_of(left_run)),
        ("method", calibration.method, left_calibration.method),
    ):
        if its != others:
            raise Unusable(
                f"the {name} of run {run.id} (as found) is {its}, but that of run {left_run.id} "
                f"(as left) is {others}; name a run of the same {name} with --as-found."
            )
    manifest, left_manifest = (runs.load(each, home).manifest for each in (run, left_run))
    moment = manifest_fields(manifest.model_extra or {}, run).moment
    left_moment = manifest_fields(left_manifest.model_extra or {}, left_run).moment
    if moment and left_moment and _is_after(moment, left_moment):
        raise Unusable(
            f"run {run.id} (as found) was recorded at {moment}, after run {left_run.id} (as left), "
            f"at {left_moment}; swap them."
        )
    used = _standards(manifest, home, laboratory, day_of(moment))
    return AsFound(
        calibrated_on=day_of(moment), calibration=calibration, decision=decide(calibration, used)
    )


def _unit_of(run: Run) -> str:
    return f"{run.manufacturer} {run.model} {run.serial}"


def _is_after(one: datetime | date, other: datetime | date) -> bool:
    """By the instants where both say their offset from UTC, else by the days."""
    if isinstance(one, datetime) and isinstance(other, datetime) and one.tzinfo and other.tzinfo:
        return one > other
    return (day_of(one) or date.min) > (day_of(other) or date.min)


def _check_run(run: Run, calibration: Calibration, inputs: CertificateInputs) -> None:
    """Refuses an invalid run with its first reason."""
    validity = calibration.validity
    if validity.verdict == "invalid":
        announce(
            "run.invalid", run.serial, run=run.id, station=run.station or "",
            why=validity.reasons[0],
        )  # fmt: skip
    if validity.verdict == "invalid" and not inputs.invalid_run:
        more = len(validity.reasons) - 1
        others = f" (and {more} more reasons)" if more else ""
        raise Unusable(
            f"run {run.id} is invalid: {validity.reasons[0].rstrip('.')}{others}; measure again "
            "(`mimucal acquire`, or a new order), or ask for a report of the invalid run with "
            "--invalid-run",
            message("station-cause.invalid", reason=texts_of(validity, "reasons")[0]),
        )


def earlier_certificates(run: Run, day: date | None, home: Home) -> list[Certificate]:
    """Records of the last issued certificates of a run's unit before a day, the oldest first.

    None where the day is not known. A record that cannot be read shows nothing: `verify` finds it.
    """
    if day is None:
        return []
    found = []
    for entry in certificates.issued_before(run, day, MOST, home):
        try:
            found.append(certificates.record_of(entry, home))
        except Unusable:
            continue
    return found
