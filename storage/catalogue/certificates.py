"""The register of certificates: entries, records, and when units are due."""

from collections.abc import Iterator
from datetime import date
from typing import Any, TypeVar

import sqlalchemy as sql
from pydantic import BaseModel, ConfigDict, ValidationError

from schemas.base import Frozen, Unusable, first_fault
from schemas.certificate import INVALID_RUN, Certificate, Laboratory, Order, State
from schemas.decision import Verdict
from schemas.text import Message, Messages, Statement, texts_of
from storage.catalogue import database, lineage, tables
from storage.catalogue.run_index import Run
from storage.home import Home

Model = TypeVar("Model", bound=BaseModel)
AS_LEFT = "as-left"  # in the purpose of a certificate: its unit was adjusted before the run


class _Serial:
    """A placeholder in a scheme for a serial number that is not yet known."""

    def __format__(self, spec: str) -> str:
        return f"{{serial:{spec}}}"


class Entry(Frozen):
    """A certificate's line in the register. `pdf`, `dcc`, `record` and `evidence` are paths within
    the home.

    number: for a draft, its key; draft: the key under which it was drafted. purpose: null for
    certificates of an earlier version. supersedes: the number of the certificate that this one
    amends.
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
    evidence: str | None
    evidence_sha256: str | None
    purpose: str | None
    draft: str | None
    supersedes: str | None
    why: str | None

    @property
    def files(self) -> dict[str, str]:
        """The SHA-256 of each of its files, by the path within the home."""
        kept = {
            self.pdf: self.pdf_sha256,
            self.record: self.record_sha256,
            self.dcc: self.dcc_sha256,
            self.evidence: self.evidence_sha256,
        }
        return {name: sha256 for name, sha256 in kept.items() if name and sha256}


class Terms(BaseModel):
    """The fields of a certificate's record that determine recalibration; others are ignored."""

    model_config = ConfigDict(frozen=True)

    issued_on: date
    order: Order | None
    laboratory: Laboratory | None


class Reasons(BaseModel):
    """Why a decision is inconclusive; the rest of it is ignored."""

    model_config = ConfigDict(frozen=True)

    reasons: tuple[str, ...] = ()
    reasons_zh: tuple[str, ...] = ()
    reasons_message: Messages = ()


class Decided(BaseModel):
    """The decision of a certificate's record; the rest of it is ignored."""

    model_config = ConfigDict(frozen=True)

    decision: Reasons


class Due(Frozen):
    """A unit due for recalibration. key: its number in the catalogue."""

    unit: str
    key: int
    model: str
    certificate: str
    due: date
    state: State
    record: str


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
    """The certificates based on a run, as found or as left."""
    entries = _register(home, _is_unit(run))
    return [entry for entry in entries if run.id in (entry.run, found_of(entry, home))]


def issued_before(run: Run, day: date, count: int, home: Home) -> list[Entry]:
    """The latest `count` issued certificates of a run's unit, for other runs, calibrated before a
    day.

    Oldest first.
    """
    paper = tables.certificates.c
    met = (paper.state == "issued", paper.run != run.id, paper.calibrated_on < day)
    entries = _register(home, sql.and_(_is_unit(run), *met))
    return sorted(entries, key=lambda entry: (entry.calibrated_on or day, entry.number))[-count:]


def _is_unit(run: Run) -> sql.ColumnElement[bool]:
    unit = tables.units.c
    return sql.and_(
        unit.manufacturer == run.manufacturer, unit.model == run.model, unit.serial == run.serial
    )


def of_unit(unit: int, home: Home) -> list[Entry]:
    """The certificates of a unit, by its number in the catalogue."""
    return _register(home, tables.certificates.c.unit == unit)


def found_of(entry: Entry, home: Home) -> str | None:
    """The as-found run of a certificate; also None for a record that cannot be read."""
    if not may_be_as_left(entry):
        return None
    try:
        found = record_of(entry, home).as_found
    except Unusable:
        return None
    return found.calibration.run if found else None


def may_be_as_left(entry: Entry) -> bool:
    """Whether a record may contain an as-found result, by its purpose."""
    return entry.purpose is None or AS_LEFT in entry.purpose.split()


def find(number: str, home: Home) -> Certificate:
    """The record of a certificate; raises Unusable if there is none or it is damaged."""
    return record_of(entry_of(number, home), home)


def entry_of(number: str, home: Home) -> Entry:
    """The entry with a number, or a draft's key; raises Unusable if there is none."""
    entries = _register(home, tables.certificates.c.number == number)
    if not entries:
        raise Unusable(
            f"There is no certificate {number!r} in {home.path}; see the register.",
            Message("cause-none.certificate", (("name", number),)),
        )
    return entries[0]


def record_of(entry: Entry, home: Home) -> Certificate:
    """The record of an entry; raises Unusable if it is damaged."""
    return _read(entry.record, Certificate, home)


def terms_of(due: Due, home: Home) -> Terms:
    """The recalibration terms of an entry; raises Unusable if its record is damaged."""
    return _read(due.record, Terms, home)


def reasons_in(record: str, home: Home) -> tuple[Statement, ...]:
    """Why a record decides on nothing; none of one that cannot be read."""
    try:
        return texts_of(_read(record, Decided, home).decision, "reasons")
    except Unusable:
        return ()


def _read(record: str, model: type[Model], home: Home) -> Model:
    path = home.path / record
    try:
        return model.model_validate_json(path.read_bytes())
    except OSError as error:
        raise Unusable(
            f"{path} cannot be read ({error.strerror}); restore it from a backup."
        ) from error
    except ValidationError as error:
        raise Unusable(f"{path}: {first_fault(error)}; restore it from a backup.") from error


def due(home: Home, until: date) -> list[Due]:
    """Units whose newest issued certificate is due by a day, the longest overdue first.

    Drafts, amended and withdrawn certificates do not count; without an agreed date nothing is due.
    """
    lines = [
        Due(
            unit=f"{row.manufacturer} {row.model} {row.serial}", key=row.unit, model=row.model,
            certificate=row.number, due=row.due, state=row.state, record=row.record,
        )
        for row in newest_issued(home).values()
        if row.due and row.due <= until
    ]  # fmt: skip
    return sorted(lines, key=lambda line: (line.due, line.unit))


def newest_issued(
    home: Home, which: sql.ColumnElement[bool] | None = None
) -> dict[int, sql.Row[Any]]:
    """The newest issued certificate of each unit, by the unit's number in the catalogue.

    The report of an invalid run certifies nothing and does not count. Newest: by the day of
    calibration (of issue, if that is unknown), then of issue. which: a condition on `certificates`
    and `units`.
    """
    paper, unit = tables.certificates.c, tables.units.c
    age = sql.func.coalesce(paper.calibrated_on, paper.issued_on), paper.issued_on
    columns = (paper.unit, paper.number, paper.state, paper.verdict, paper.due, paper.record)
    asked = sql.select(*columns, unit.manufacturer, unit.model, unit.serial).join_from(
        tables.certificates, tables.units
    )
    of_valid_run = sql.not_(sql.func.coalesce(paper.purpose, "").endswith(INVALID_RUN))
    issued = asked.where(
        paper.state == "issued", of_valid_run, sql.true() if which is None else which
    )
    return {row.unit: row for row in database.rows(home, issued.order_by(*age, paper.kept_at))}


def _register(home: Home, which: sql.ColumnElement[bool]) -> list[Entry]:
    table = tables.certificates
    return database.with_units(home, Entry, table, which, table.c.kept_at)


def series_of(scheme: str, prefix: str, year: int) -> str:
    """A laboratory's scheme with prefix and year filled in, as `MIMU-2026-{serial:04d}`."""
    return scheme.format(prefix=prefix, year=year, serial=_Serial())


def next_number(connection: sql.Connection, series: str) -> str:
    """The next number of a series; others wait for the end of the transaction.

    The number is used up only when the transaction is committed.
    """
    table = tables.series
    insert = database.dialect(connection).insert(table).values(pattern=series, last=1, before=0)
    counted = insert.on_conflict_do_update(
        index_elements=[table.c.pattern], set_={"last": table.c.last + 1}
    )
    serial = connection.execute(counted.returning(table.c.last)).scalar_one()
    return series.format(serial=serial)


def missing(home: Home) -> Iterator[str]:
    """The numbers that were given and are not in the register."""
    given_by = database.rows(home, sql.select(tables.series))  # first: others may go on issuing
    held = {row.number for row in database.rows(home, sql.select(tables.certificates.c.number))}
    for series in given_by:
        given = range(series.before + 1, series.last + 1)
        numbers = (series.pattern.format(serial=serial) for serial in given)
        yield from (number for number in numbers if number not in held)
