"""Stores a certificate within a transaction, and replaces it by its next version.

Files are whole and on the disk before the row that names them. Those of a draft bear a part of
their hash in the name, so that a version never takes the place of another one's files; those of an
issued certificate bear its number alone.
"""

import hashlib
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any, Protocol

import sqlalchemy as sql

from schemas.base import Unusable
from schemas.certificate import LIVE, NUMBER, Certificate, State
from storage.catalogue import database, lineage, result_rows, tables
from storage.catalogue.certificates import Entry, standards_of
from storage.catalogue.results import add_result
from storage.catalogue.runs import unit_id
from storage.home import Home
from storage.whole_files import writing_to

TABLE = tables.certificates
NOT_ISSUED: tuple[State, ...] = ("draft", "checked")
HASH_DIGITS = 12  # hex digits in the names of a draft's files
RUN_CHARACTERS = 8  # of a run's id in the key of its draft
FILES = {"pdf": "pdf", "dcc": "xml", "record": "json", "evidence": "evidence.json"}  # suffixes


class Faces(Protocol):
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
    faces: Faces,
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
    result_rows.add_decision(connection, certificate.number, certificate.decision)
    run, standards = certificate.calibration.run, standards_of(certificate)
    lineage.add_equipment(connection, run, certificate.number, standards)
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


def _written(home: Home, certificate: Certificate, faces: Faces) -> dict[str, Any]:
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
