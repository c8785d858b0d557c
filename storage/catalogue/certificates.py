"""Certificates in the store: numbered once, never changed, and when their units come back."""

import hashlib
import re
from datetime import UTC, date, datetime
from pathlib import Path

import sqlalchemy as sql
from pydantic import ValidationError

from schemas.base import Frozen, Unusable, first_fault
from schemas.certificate import Certificate, State
from schemas.decision import Verdict
from storage.catalogue import database, lineage, numbers, tables
from storage.catalogue.listing import Run
from storage.catalogue.results import add_result
from storage.catalogue.runs import unit_id
from storage.home import Home
from storage.whole_files import write_once


class Entry(Frozen):
    """A certificate's line in the register. `pdf` and `record` are paths within the home."""

    number: str
    result: str
    run: str
    manufacturer: str
    model: str
    serial: str
    state: State
    verdict: Verdict
    calibrated_on: date | None
    issued_on: date
    due: date
    pdf: str
    pdf_sha256: str
    record: str
    record_sha256: str
    supersedes: str | None
    why: str | None


class Due(Frozen):
    """A unit that comes back for recalibration."""

    unit: str
    certificate: str
    due: date
    state: State


def reserve_number(home: Home, prefix: str, year: int) -> str:
    """The next certificate number, like MIMU-2026-0001; it is never given again.

    A certificate that then fails leaves a gap. Raises Unusable for a prefix that cannot be
    part of a file name.
    """
    _check_name(prefix, "The certificate prefix")
    with database.changing(home) as connection:
        series = numbers.series_of("{prefix}-{year}-{serial:04d}", prefix, year)
        return numbers.next_number(connection, series)


def save(
    certificate: Certificate,
    pdf: bytes,
    home: Home,
    *,
    supersedes: str | None = None,
    why: str | None = None,
) -> tuple[Path, Path]:
    """Keeps a certificate and gives the paths of its PDF and of its record (JSON).

    Its calibration is kept as a result, if it is not yet. `supersedes`: the number of the
    certificate that this one amends or withdraws, and `why`. The same again changes nothing;
    raises Unusable for other content under a number that is taken.
    """
    _check_name(certificate.number, "The certificate number")
    record = certificate.model_dump_json(indent=1).encode()
    pdf_name, record_name = (f"certificates/{certificate.number}{s}" for s in (".pdf", ".json"))
    with database.changing(home) as connection:
        _check_supersedes(connection, certificate, supersedes, why)
        write_once(home.path / pdf_name, pdf)
        write_once(home.path / record_name, record)
        database.add_new(
            connection,
            tables.certificates,
            number=certificate.number,
            result=_result(connection, certificate),
            run=certificate.calibration.run,
            unit=unit_id(connection, certificate.manifest.unit),
            state=certificate.state,
            verdict=certificate.decision.verdict,
            calibrated_on=certificate.calibrated_on,
            issued_on=certificate.issued_on,
            due=certificate.due,
            kept_at=datetime.now(UTC),
            pdf=pdf_name,
            pdf_sha256=hashlib.sha256(pdf).hexdigest(),
            record=record_name,
            record_sha256=hashlib.sha256(record).hexdigest(),
            supersedes=supersedes,
            why=why,
        )
        run, standards = certificate.calibration.run, standards_of(certificate)
        lineage.add_equipment(connection, run, certificate.number, standards)
    return home.path / pdf_name, home.path / record_name


def standards_of(certificate: Certificate) -> list[lineage.Used]:
    """The measurement standards of the laboratory that a certificate prints."""
    printed = certificate.laboratory.equipment if certificate.laboratory else ()
    return [
        lineage.Used(name=each.name, serial=each.serial, certificate=each.certificate)
        for each in printed
    ]


def register(home: Home) -> list[Entry]:
    """The register: every certificate in the order in which they were kept."""
    return _register(home, sql.true())


def of_run(run: Run, home: Home) -> list[Entry]:
    """The certificates on which a run stands, as found or as left."""
    unit = (run.manufacturer, run.model, run.serial)
    entries = register(home)
    of_unit = [e for e in entries if (e.manufacturer, e.model, e.serial) == unit]
    return [entry for entry in of_unit if run.id in (entry.run, found_of(entry, home))]


def found_of(entry: Entry, home: Home) -> str | None:
    """The run as found of a certificate; None for a record that cannot be read, too."""
    try:
        found = record_of(entry, home).as_found
    except Unusable:
        return None
    return found.calibration.run if found else None


def find(number: str, home: Home) -> Certificate:
    """The record of a certificate; raises Unusable when there is none or it was damaged."""
    entries = _register(home, tables.certificates.c.number == number)
    if not entries:
        raise Unusable(f"There is no certificate {number!r} in {home.path}; see the register.")
    return record_of(entries[0], home)


def record_of(entry: Entry, home: Home) -> Certificate:
    """The record that a line of the register names; raises Unusable when it was damaged."""
    path = home.path / entry.record
    try:
        return Certificate.model_validate_json(path.read_bytes())
    except OSError as error:
        raise Unusable(
            f"{path} cannot be read ({error.strerror}); bring it back from a backup."
        ) from error
    except ValidationError as error:
        raise Unusable(f"{path}: {first_fault(error)}; bring it back from a backup.") from error


def due(home: Home, until: date) -> list[Due]:
    """Units whose newest valid certificate falls due by a day, the longest overdue first.

    Valid: neither withdrawn nor superseded by another. Newest: by the day of calibration (of
    issue, where that is unknown), then of issue. Drafts count.
    """
    entries = register(home)
    superseded = {entry.supersedes for entry in entries}
    newest: dict[tuple[str, str, str], Entry] = {}
    for entry in sorted(entries, key=_age):
        if entry.number not in superseded and entry.state != "withdrawn":
            newest[entry.manufacturer, entry.model, entry.serial] = entry
    lines = [
        Due(unit=" ".join(unit), certificate=entry.number, due=entry.due, state=entry.state)
        for unit, entry in newest.items()
        if entry.due <= until
    ]
    return sorted(lines, key=lambda line: (line.due, line.unit))


def _age(entry: Entry) -> tuple[date, date]:
    return entry.calibrated_on or entry.issued_on, entry.issued_on


def _register(home: Home, which: sql.ColumnElement[bool]) -> list[Entry]:
    table = tables.certificates
    return database.with_units(home, Entry, table, which, table.c.kept_at)


def _check_name(text: str, what: str) -> None:
    if not re.fullmatch(r"\w[\w.-]{0,63}", text):
        raise Unusable(
            f"{what} is {text!r}; it becomes a file name, so use letters, digits, dots, hyphens "
            "and underscores (laboratory.toml: certificate_prefix)."
        )


def _check_supersedes(
    connection: sql.Connection, certificate: Certificate, supersedes: str | None, why: str | None
) -> None:
    if supersedes is None:
        return
    if not why:
        raise Unusable(f"Certificate {certificate.number} supersedes {supersedes}; say why.")
    table = tables.certificates.c
    older = sql.select(table.number).where(table.number == supersedes).with_for_update()
    if connection.execute(older).one_or_none() is None:
        raise Unusable(f"There is no certificate {supersedes!r} to supersede; see the register.")
    newer = connection.scalar(sql.select(table.number).where(table.supersedes == supersedes))
    if newer not in (None, certificate.number):
        raise Unusable(f"{supersedes} is already superseded by {newer}; supersede that one.")


def _result(connection: sql.Connection, certificate: Certificate) -> str:
    """The result that the certificate prints, which need not be the latest any more."""
    table, document = tables.results.c, certificate.calibration.model_dump_json()
    same = sql.select(table.id).where(
        table.run == certificate.calibration.run, table.document == document
    )
    kept = connection.scalars(same.order_by(table.made_at.desc())).first()
    return kept or add_result(connection, certificate.calibration, None)
