"""The register of certificates: what it says of each, their records, and when units come back."""

from datetime import date

import sqlalchemy as sql
from pydantic import ValidationError

from schemas.base import Frozen, Unusable, first_fault
from schemas.certificate import Certificate, State
from schemas.decision import Verdict
from storage.catalogue import database, lineage, tables
from storage.catalogue.listing import Run
from storage.home import Home


class Entry(Frozen):
    """A certificate's line in the register. `pdf`, `dcc` and `record` are paths within the home.

    number: of a draft its key; draft: the key under which it was issued. purpose: null for what
    an earlier version made. supersedes: the number of the certificate that this one amends.
    """

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
    due: date | None
    pdf: str
    pdf_sha256: str
    record: str
    record_sha256: str
    dcc: str | None
    dcc_sha256: str | None
    purpose: str | None
    draft: str | None
    supersedes: str | None
    why: str | None

    @property
    def files(self) -> dict[str, str]:
        """The SHA-256 of each of its files, by the path within the home."""
        kept = {self.pdf: self.pdf_sha256, self.record: self.record_sha256}
        return kept | ({self.dcc: self.dcc_sha256} if self.dcc and self.dcc_sha256 else {})


class Due(Frozen):
    """A unit that comes back for recalibration."""

    unit: str
    certificate: str
    due: date
    state: State


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
    return record_of(entry_of(number, home), home)


def entry_of(number: str, home: Home) -> Entry:
    """The line of the register with a number, or a draft's key; raises Unusable for none."""
    entries = _register(home, tables.certificates.c.number == number)
    if not entries:
        raise Unusable(f"There is no certificate {number!r} in {home.path}; see the register.")
    return entries[0]


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
    """Units whose newest issued certificate falls due by a day, the longest overdue first.

    Newest: by the day of calibration (of issue, where that is unknown), then of issue. Neither
    drafts count nor what was amended or withdrawn, and one without an agreed date is due never.
    """
    newest: dict[tuple[str, str, str], Entry] = {}
    for entry in sorted(_register(home, tables.certificates.c.state == "issued"), key=_age):
        newest[entry.manufacturer, entry.model, entry.serial] = entry
    lines = [
        Due(unit=" ".join(unit), certificate=entry.number, due=entry.due, state=entry.state)
        for unit, entry in newest.items()
        if entry.due and entry.due <= until
    ]
    return sorted(lines, key=lambda line: (line.due, line.unit))


def _age(entry: Entry) -> tuple[date, date]:
    return entry.calibrated_on or entry.issued_on, entry.issued_on


def _register(home: Home, which: sql.ColumnElement[bool]) -> list[Entry]:
    table = tables.certificates
    return database.with_units(home, Entry, table, which, table.c.kept_at)
