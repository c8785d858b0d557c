"""Whether everything in the home is still what it was when it was stored."""

import hashlib
import time
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path

import sqlalchemy as sql

from schemas.base import Frozen, Unusable
from schemas.certificate import Certificate
from storage.catalogue import certificates, database, tables
from storage.catalogue.certificates import Entry, record_of
from storage.catalogue.results import calibration_of, result_id
from storage.catalogue.runs import Run, all_runs, from_columns, raw_path
from storage.formats.mcap.reader import read_mcap
from storage.home import Home

DRAFT_AGE_S = 3600.0  # a younger draft may belong to an import that is still running
SILENT_S = 60.0  # an acquisition writes every second; one that is silent so long has ended
RESTORE = "bring the catalogue back from a backup"
UNKNOWN = "import it if it is a recording that you want, else move it away"

Progress = Callable[[int, int], None]


class Fault(Frozen):
    """What is wrong with what; `why` ends with the way out."""

    what: str
    why: str


Check = Callable[[], Iterable[Fault]]


def verify(home: Home, progress: Progress | None = None) -> tuple[int, list[Fault]]:
    """Reads everything in the store again; gives how many things were checked, and the faults.

    Raw recordings and columns against their digest, results against their id and their run,
    PDFs and records against the SHA-256 kept at issue, records against the result they print,
    files that the catalogue does not know, and acquisitions that were broken off.
    `progress(done, total)` is called after each.
    """
    checks = list(_checks(home))
    faults: list[Fault] = []
    for done, check in enumerate(checks, start=1):
        faults += check()
        if progress is not None:
            progress(done, len(checks))
    return len(checks), faults


def _checks(home: Home) -> Iterator[Check]:
    runs, register = all_runs(home), certificates.register(home)
    for run in runs:
        yield partial(_raw, run, home)
        if (home.columns / run.digest).exists():  # missing columns are made again when needed
            yield partial(_columns, run, home)
    digests = {run.id: run.digest for run in runs}
    for (result,) in database.rows(home, sql.select(tables.results.c.id)):
        yield partial(_result, result, digests, home)
    for entry in register:
        yield partial(_unchanged, home.path / entry.pdf, entry.pdf_sha256)
        yield partial(_unchanged, home.path / entry.record, entry.record_sha256)
        yield partial(_record, entry, home)
    for unknown in _unknown_files(home, runs, register):
        yield partial(iter, (unknown,))
    for abandoned in _abandoned(home):
        yield partial(iter, (abandoned,))


def _raw(run: Run, home: Home) -> Iterator[Fault]:
    path = raw_path(run.digest, home)
    again = f"import {run.recording_id} again from its source"
    if not path.exists():
        yield Fault(what=str(path), why=f"the raw recording of run {run.id} is missing; {again}")
        return
    try:
        digest = read_mcap(path).digest
    except Unusable as error:
        yield Fault(what=str(path), why=f"{error} Move the file away and {again}.")
        return
    if digest != run.digest:
        yield Fault(
            what=str(path),
            why=f"the content has the digest {digest}, not that of run {run.id}; move the file "
            f"away and {again}",
        )


def _columns(run: Run, home: Home) -> Iterator[Fault]:
    if from_columns(run, home) is None:
        yield Fault(
            what=str(home.columns / run.digest),
            why=f"the columns are not those of run {run.id}; delete the folder, and they are made "
            "again from raw when they are needed",
        )


def _result(result: str, digests: dict[str, str], home: Home) -> Iterator[Fault]:
    what, table = f"result {result}", tables.results
    (row,) = database.rows(home, sql.select(table).where(table.c.id == result))
    try:
        calibration = calibration_of(row)
    except Unusable as error:
        yield Fault(what=what, why=str(error))
        return
    if calibration.run != row.run or digests.get(row.run) != calibration.digest:
        yield Fault(
            what=what,
            why=f"it is of run {calibration.run} with digest {calibration.digest}, which is "
            f"not what run {row.run} holds; calibrate run {row.run} again",
        )
    elif not _untouched(row):
        yield Fault(what=what, why=f"its document was changed after it was kept; {RESTORE}")


def _untouched(row: sql.Row) -> bool:
    return bool(row.id == result_id(row.supersedes, row.document))


def _unchanged(path: Path, expected: str) -> Iterator[Fault]:
    try:
        with path.open("rb") as opened:
            sha256 = hashlib.file_digest(opened, "sha256").hexdigest()
    except OSError as error:
        yield Fault(what=str(path), why=f"{error.strerror}; bring it back from a backup")
        return
    if sha256 != expected:
        yield Fault(
            what=str(path), why="it was changed after it was kept; bring it back from a backup"
        )


def _record(entry: Entry, home: Home) -> Iterator[Fault]:
    """Whether the record says what the register says."""
    try:
        record = record_of(entry, home)
    except Unusable as error:
        yield Fault(what=f"certificate {entry.number}", why=str(error))
        return
    of_record = (record.number, record.state, record.decision.verdict, record.due)
    if of_record != (entry.number, entry.state, entry.verdict, entry.due):
        yield Fault(
            what=f"certificate {entry.number}",
            why="the register and the record differ in number, state, verdict or due date; "
            f"believe the record, and {RESTORE}",
        )
    yield from _printed(entry, record, home)


def _printed(entry: Entry, record: Certificate, home: Home) -> Iterator[Fault]:
    """Whether the result that a certificate prints is still there and says the same."""
    what, table = f"certificate {entry.number}", tables.results
    rows = database.rows(home, sql.select(table).where(table.c.id == entry.result))
    if not rows:
        yield Fault(what=what, why=f"its result {entry.result} is gone; {RESTORE}")
        return
    (row,) = rows
    if not _untouched(row):
        return  # a fault of the result itself
    if calibration_of(row).model_dump_json() != record.calibration.model_dump_json():
        yield Fault(
            what=what,
            why=f"its record prints another calibration than result {entry.result}, which the "
            f"register names; believe the record, and {RESTORE}",
        )


def _unknown_files(home: Home, runs: list[Run], register: list[Entry]) -> Iterator[Fault]:
    known = {raw_path(run.digest, home) for run in runs}
    known |= {home.columns / run.digest for run in runs}
    known |= {home.path / name for entry in register for name in (entry.pdf, entry.record)}
    for folder in (home.raw, home.columns, home.certificates):
        for path in sorted(folder.glob("*")):
            if path in known:
                continue
            if not path.name.startswith("."):
                yield Fault(what=str(path), why=f"the catalogue does not know it; {UNKNOWN}")
            elif _age_s(path) > DRAFT_AGE_S:
                yield Fault(what=str(path), why="left by what was broken off; delete it")


def _abandoned(home: Home) -> Iterator[Fault]:
    for path in sorted(home.acquiring.glob("*.mcap")):
        if _age_s(path) > SILENT_S:
            yield Fault(
                what=str(path),
                why="an acquisition that was broken off; `mimucal import --salvage` takes in what "
                "is whole of it, then delete the file",
            )


def _age_s(path: Path) -> float:
    return time.time() - path.stat().st_mtime
