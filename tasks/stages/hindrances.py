"""What prevents the issue of a checked certificate."""

import sqlalchemy as sql

from schemas.base import Unusable
from schemas.certificate import Certificate
from storage.catalogue import database, equipment, tables
from storage.catalogue.certificates import Entry
from storage.catalogue.results import calibration_of
from storage.home import Home
from tasks import conformity
from tasks.words import say

AGAIN = "certify the run again"


def check_issuable(
    connection: sql.Connection, entry: Entry, certificate: Certificate, home: Home
) -> None:
    """Raises Unusable with the first reason for which a certificate cannot be issued."""
    _check_limits(certificate)
    _check_equipment(certificate, home)
    _check_run(connection, certificate)
    _check_newest(connection, entry)


def _check_limits(certificate: Certificate) -> None:
    """There is no verdict without limits; a calibration without one has to be ordered."""
    asked = certificate.order is None or certificate.order.conformity
    if not certificate.decision.limits and asked:
        unit = certificate.manifest.unit
        raise Unusable(
            f"{certificate.number} has no verdict, because there are no limits of "
            f"{unit.manufacturer} {unit.model}: give them with --tolerance or in the folder "
            f"tolerances of the home, or let the order say conformity = false, and {AGAIN}."
        )


def _check_equipment(certificate: Certificate, home: Home) -> None:
    """Standards without a valid certificate on the day of calibration, by draft or register."""
    laboratory = certificate.laboratory
    day = certificate.calibrated_on or certificate.issued_on
    late = {standard.serial: standard for standard in equipment.past_due(home, day)}
    listed = laboratory.equipment if laboratory else ()
    for expired in conformity.expired([late.get(each.serial, each) for each in listed], day):
        raise Unusable(
            f"{certificate.number} cannot be issued: {say(expired, 'en').rstrip('.')}; calibrate "
            "with equipment that is in date."
        )


def _check_run(connection: sql.Connection, certificate: Certificate) -> None:
    """A newer result that finds the run invalid."""
    if certificate.calibration.validity.verdict == "invalid":
        return  # and it says so
    table, run = tables.results, certificate.calibration.run
    asked = sql.select(table).where(table.c.run == run, database.newest_results())
    for row in connection.execute(asked):
        validity = calibration_of(row).validity
        if validity.verdict == "invalid":
            raise Unusable(
                f"{certificate.number} cannot be issued: by result {row.id} run {run} is invalid "
                f"({validity.reasons[0].rstrip('.')}); measure again."
            )


def _check_newest(connection: sql.Connection, entry: Entry) -> None:
    """A newer result than the one that it prints."""
    table = tables.results.c
    newer = connection.scalar(sql.select(table.id).where(table.supersedes == entry.result))
    if newer:
        raise Unusable(
            f"{entry.number} prints result {entry.result}, which {newer} superseded; {AGAIN}"
            + (f" (`mimucal amend {entry.supersedes}`)." if entry.supersedes else ".")
        )
