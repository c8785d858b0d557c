"""The register of certificates: entries, records, and when units are due."""

import hashlib
from collections.abc import Iterator, Sequence
from datetime import UTC, date, datetime
from typing import Any, Protocol, TypeVar

import sqlalchemy as sql
from pydantic import BaseModel, ConfigDict, ValidationError

from schemas.base import Frozen, Unusable, first_fault
from schemas.certificate import (
    INVALID_RUN,
    LIVE,
    NUMBER,
    Certificate,
    Laboratory,
    Order,
    Signature,
    State,
)
from schemas.text import Message, Messages, Statement, texts_of
from schemas.tolerance import Verdict
from storage.catalogue import audit_trail, database, results, runs, tables
from storage.catalogue.results import add_result
from storage.catalogue.runs import Run, unit_id
from storage.home import Home
from storage.whole_files import writing_to

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


def standards_of(certificate: Certificate) -> list[runs.Used]:
    """The measurement standards of the laboratory that a certificate prints."""
    printed = certificate.laboratory.equipment if certificate.laboratory else ()
    return [
        runs.Used(name=each.name, serial=each.serial, certificate=each.certificate)
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


# Stores a certificate within a transaction, and replaces it by its next version.
#
# Files are whole and on the disk before the row that names them. Those of a draft bear a part of
# their hash in the name, so that a version never takes the place of another one's files; those of
# an issued certificate bear its number alone.

TABLE = tables.certificates
NOT_ISSUED: tuple[State, ...] = ("draft", "checked")
HASH_DIGITS = 12  # hex digits in the names of a draft's files
RUN_CHARACTERS = 8  # of a run's id in the key of its draft
FILES = {"pdf": "pdf", "dcc": "xml", "record": "json", "evidence": "evidence.json"}  # suffixes


class CertificateFiles(Protocol):
    """The stored forms of a certificate: PDF, Digital Calibration Certificate (XML), JSON
    record, and the evidence of its result, if there is any.
    """

    @property
    def pdf(self) -> bytes: ...
    @property
    def dcc(self) -> bytes: ...
    @property
    def record(self) -> bytes: ...
    @property
    def evidence(self) -> bytes | None: ...


def locked(connection: sql.Connection, number: str) -> Entry | None:
    """The certificate with a number or key, locked against changes until the transaction ends.

    Its run is locked first, as by everything that adds to a run.
    """
    run = connection.scalar(sql.select(TABLE.c.run).where(TABLE.c.number == number))
    runs = tables.runs.c.id
    connection.execute(sql.select(runs).where(runs == run).with_for_update())
    connection.execute(sql.select(TABLE.c.run).where(TABLE.c.number == number).with_for_update())
    return next(iter(_entries(connection, TABLE.c.number == number)), None)


def live(connection: sql.Connection, run: str) -> list[Entry]:
    """The certificates of a run that are neither amended nor withdrawn."""
    return _entries(connection, (TABLE.c.run == run) & TABLE.c.state.in_(LIVE))


def drafts_in_place_of(connection: sql.Connection, number: str) -> list[Entry]:
    """The unissued amendment of a certificate, if there is one."""
    return _entries(connection, (TABLE.c.supersedes == number) & TABLE.c.state.in_(NOT_ISSUED))


def issued_from(connection: sql.Connection, key: str) -> str | None:
    """The number under which a draft was issued last."""
    asked = sql.select(TABLE.c.number).where(TABLE.c.draft == key)
    return connection.scalars(asked.order_by(TABLE.c.kept_at.desc())).first()


def free_key(connection: sql.Connection, run: str) -> str:
    """An unused key for a draft of a run."""
    base = f"draft-{run[:RUN_CHARACTERS]}"
    asked = sql.select(TABLE.c.number).where(TABLE.c.number.startswith(base, autoescape=True))
    taken, key, count = set(connection.scalars(asked)), base, 1
    while key in taken:
        count += 1
        key = f"{base}-{count}"
    return key


def result_of(connection: sql.Connection, certificate: Certificate) -> str:
    """The result that the certificate prints, not necessarily the latest; stored if new.

    Others that add to its run wait until the transaction ends.
    """
    table, document = tables.results.c, certificate.calibration.model_dump_json()
    run = certificate.calibration.run
    runs = tables.runs.c.id
    connection.execute(sql.select(runs).where(runs == run).with_for_update())
    same = sql.select(table.id).where(table.run == run, table.document == document)
    kept = connection.scalars(same.order_by(table.made_at.desc())).first()
    return kept or add_result(connection, certificate.calibration, None)


def add(
    connection: sql.Connection,
    home: Home,
    certificate: Certificate,
    faces: CertificateFiles,
    *,
    draft: str | None = None,
) -> list[str]:
    """Writes the files of a certificate, adds it to the register, and returns the files' names.

    draft: the key under which it was drafted. A file under a number that the register does not have
    was left by an interrupted issue, and is replaced. Raises Unusable for a number that is taken,
    and for one that cannot be a file name.
    """
    _check_number(connection, certificate.number)
    replaces, files = certificate.replaces, _written(home, certificate, faces)
    connection.execute(
        sql.insert(TABLE).values(
            number=certificate.number,
            result=result_of(connection, certificate),
            run=certificate.calibration.run,
            unit=unit_id(connection, certificate.manifest.unit),
            state=certificate.state,
            verdict=certificate.decision.verdict,
            purpose=certificate.purpose,
            draft=draft,
            calibrated_on=certificate.calibrated_on,
            issued_on=certificate.issued_on,
            due=certificate.due,
            kept_at=datetime.now(UTC),
            supersedes=replaces and replaces.number,
            why=replaces and replaces.why,
            limits=len(certificate.decision.limits),
            **files,
        )
    )
    results.add_decision(connection, certificate.number, certificate.decision)
    run, standards = certificate.calibration.run, standards_of(certificate)
    runs.add_equipment(connection, run, certificate.number, standards)
    return [files[name] for name in FILES if name in files]


def remove(connection: sql.Connection, entry: Entry) -> None:
    """Removes a draft from the register; its files stay until the transaction is committed."""
    named = tables.equipment.c.document == entry.number
    connection.execute(sql.delete(tables.equipment).where(named))
    decided = tables.decisions.c.certificate == entry.number
    connection.execute(sql.delete(tables.decisions).where(decided))
    connection.execute(sql.delete(TABLE).where(TABLE.c.number == entry.number))


def remove_files(entries: Sequence[Entry], but: Sequence[str], home: Home) -> None:
    """Removes the files of drafts that left the register, except those named."""
    for name in {name for entry in entries for name in entry.files} - set(but):
        (home.path / name).unlink(missing_ok=True)


def hashes(connection: sql.Connection, number: str) -> list[str]:
    """SHA-256 of PDF, DCC and record, as the trail keeps them."""
    columns = (TABLE.c.pdf_sha256, TABLE.c.dcc_sha256, TABLE.c.record_sha256)
    return list(connection.execute(sql.select(*columns).where(TABLE.c.number == number)).one())


def change_state(connection: sql.Connection, number: str, state: State) -> None:
    """Changes the state of a certificate; its files stay as they are."""
    connection.execute(sql.update(TABLE).where(TABLE.c.number == number).values(state=state))


def _entries(connection: sql.Connection, which: sql.ColumnElement[bool]) -> list[Entry]:
    found = connection.execute(database.of_units(Entry, TABLE, which).order_by(TABLE.c.kept_at))
    return [Entry.model_validate(row, from_attributes=True) for row in found]


def _check_number(connection: sql.Connection, number: str) -> None:
    if not NUMBER.fullmatch(number):
        raise Unusable(
            f"The certificate number is {number!r}; it becomes a file name, so use letters, "
            "digits, dots, hyphens and underscores (laboratory.toml: number_scheme)."
        )
    if connection.scalar(sql.select(TABLE.c.number).where(TABLE.c.number == number)):
        raise Unusable(
            f"Certificate {number} is already in the register; give certificate_prefix or "
            "number_scheme of laboratory.toml another form."
        )


def _written(home: Home, certificate: Certificate, faces: CertificateFiles) -> dict[str, Any]:
    """Writes the files and gives the columns that name them."""
    stem = certificate.number
    if certificate.state in NOT_ISSUED:
        stem += "." + hashlib.sha256(faces.pdf + faces.record).hexdigest()[:HASH_DIGITS]
    columns: dict[str, Any] = {}
    for column, suffix in FILES.items():
        content: bytes | None = getattr(faces, column)
        if content is None:
            continue
        name = f"certificates/{stem}.{suffix}"
        with writing_to(home.path / name) as file:
            file.write_bytes(content)
        columns[column] = name
        columns[f"{column}_sha256"] = hashlib.sha256(content).hexdigest()
    return columns


# The signatures of orders that were carried out: each is taken once.


def take(signature: Signature, flow: str, subject: str, flow_run: str | None, home: Home) -> bool:
    """Uses a signature, with an entry in the trail; returns whether it was still unused.

    flow_run: the same flow run may take it again while it has not come to an end, as when Prefect
    tries it again after a crash.
    """
    now, table = datetime.now(UTC), tables.signatures
    taken = {"nonce": signature.nonce, "taken_at": now, "flow_run": flow_run}
    with database.changing(home) as connection:
        if database.add_new(connection, table, **taken):
            audit_trail.add(
                connection, signature.person, f"sign {flow}", subject, at=now,
                signed_at=signature.signed_at.astimezone(UTC).isoformat(),
                signed_on=signature.signed_on, nonce=signature.nonce,
            )  # fmt: skip
            return True
        again = sql.select(table.c.flow_run).where(
            table.c.nonce == signature.nonce, table.c.done_at.is_(None)
        )
        return flow_run is not None and connection.scalar(again) == flow_run


def finish(signature: Signature, home: Home) -> None:
    """No flow run takes it any more: its order was carried out, or refused for good."""
    table = tables.signatures
    done = sql.update(table).where(table.c.nonce == signature.nonce)
    with database.changing(home) as connection:
        connection.execute(done.values(done_at=datetime.now(UTC)))
