"""Why a certificate cannot be issued: everything at once."""

from collections.abc import Iterator

import sqlalchemy as sql

from schemas.base import Unusable
from schemas.certificate import Certificate
from storage import settings
from storage.catalogue import database, equipment, tables
from storage.catalogue.certificates import Entry
from storage.catalogue.results import calibration_of
from storage.home import Home
from tasks import conformity
from tasks.certificate.mandatory import missing, standards_of
from tasks.specifications.register import SPECIFICATIONS
from tasks.stages.authority import why_not
from tasks.stages.equipment_in_use import contradictions, of_manifest
from tasks.station.run_manifest import PERSONS
from tasks.words import say

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
