"""Whether everything in the home is still as it was stored."""

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

import sqlalchemy as sql

from schemas.base import Frozen, Progress, Unusable
from schemas.certificate import State
from storage import run_statistics
from storage.blobs import Blobs, blobs_of
from storage.catalogue import audit_trail, certificates, database, discrepancies, tables
from storage.catalogue.certificates import Entry, record_of
from storage.catalogue.results import calibration_of, result_id
from storage.catalogue.runs import Run, all_runs, from_columns
from storage.formats.content import fingerprint
from storage.formats.mcap.reader import CutOff, has_readings, read_mcap
from storage.home import Home
from storage.retention import age_s, is_of_draft
from storage.whole_files import is_as_kept

RESTORE = "bring the catalogue back from a backup"
AFTER: dict[str, State] = {
    "draft": "draft",
    "check": "checked",
    "issue": "issued",
    "amend": "amended",
    "withdraw": "withdrawn",
}
Standing = tuple[State, list[str | None]]  # what became of it, and the SHA-256 of its files
DRAFT_AGE_S = 3600.0  # a newer draft may belong to an import in progress
LEFT_OVER = "no certificate in the catalogue has it; move it away"
BROKEN_OFF = (
    "left by a draft that was broken off; `mimucal prune --delete` removes it after an hour"
)
ISSUE_S = 60.0  # a newer file may belong to a certificate that is being stored
SILENT_S = 60.0  # an acquisition writes every second; without writes for so long it has ended
UNKNOWN = "import it if it is a recording that you want, else move it away"
Found = tuple[str, str]  # where a file is, and what is wrong with it
Check = tuple[object, Callable[[], Iterable[str]]]  # of what, and what is wrong with it


class StoreFault(Frozen):
    """What is wrong with what; `why` ends with the way out."""

    what: str
    why: str


def verify(home: Home, progress: Progress | None = None) -> tuple[int, list[StoreFault]]:
    """Reads everything in the store again; gives how many things were checked, and the faults.

    Raw recordings and columns against their digest, results against their id and their run,
    PDFs, DCCs and records against the SHA-256 kept with them and in the trail, records against the
    result they print, the trail and the series of numbers for gaps and edits, files and
    objects that the catalogue does not know, and acquisitions that were broken off.
    `progress(done, total)` is called after each.
    """
    checks = list(_checks(home))
    faults: list[StoreFault] = []
    for done, (what, check) in enumerate(checks, start=1):
        try:
            faults += (StoreFault(what=str(what), why=why) for why in check())
        except Unusable as error:
            faults.append(StoreFault(what=str(what), why=str(error)))
        if progress is not None:
            progress(done, len(checks))
    return len(checks), faults


def _checks(home: Home) -> Iterator[Check]:
    runs, register, blobs = all_runs(home), certificates.register(home), blobs_of(home)
    for run in runs:
        name, columns = f"raw/{run.digest}.mcap", f"columns/{run.digest}"
        yield blobs.where(name), partial(_raw, run, name, blobs)
        if blobs.exists(columns):  # missing columns are made again when needed
            yield blobs.where(columns), partial(_columns, run, home)
    digests = {run.id: run.digest for run in runs}
    for (result,) in database.rows(home, sql.select(tables.results.c.id)):
        yield f"result {result}", partial(_result, result, digests, home)
    for entry in register:
        for name, sha256 in entry.files.items():
            yield home.path / name, partial(_unchanged, home.path / name, sha256)
        yield f"certificate {entry.number}", partial(_record, entry, home)
    if register or audit_trail.entries(home):
        yield "trail", partial(audit_trail.faults, home)
        yield "certificates in the trail", partial(against_trail, home)
        yield "numbers of certificates", partial(number_gaps, home)
    unknown = (*_unknown(blobs, runs), *_unknown_papers(home, register), *_abandoned(home))
    for where, why in unknown:
        yield where, partial(iter, (why,))


def _raw(run: Run, name: str, blobs: Blobs) -> Iterator[str]:
    again = f"import {run.recording_id} again from its source"
    if not blobs.exists(name):
        yield f"the raw recording of run {run.id} is missing; {again}"
        return
    try:
        with blobs.local(name) as path:
            digest = read_mcap(path).digest
    except CutOff as fault:
        yield (
            f"it {fault.why}; move the file away and {again}, or, where there is no source any "
            "more, import what is whole of it with --salvage"
        )
        return
    except Unusable as error:
        why = str(error).removeprefix(blobs.where(name)).lstrip(": ")
        yield f"{why} Move the file away and {again}."
        return
    if digest != run.digest:
        yield (
            f"the content has the digest {digest}, not that of run {run.id}; move the file "
            f"away and {again}"
        )


def _columns(run: Run, home: Home) -> Iterator[str]:
    recording = from_columns(run, home)
    if recording is None or fingerprint(recording) != run.digest:
        yield (
            f"the columns are not those of run {run.id}; delete the folder, and they are made "
            "again from raw when they are needed"
        )


def _result(result: str, digests: dict[str, str], home: Home) -> Iterator[str]:
    (row,) = _rows(result, home)
    calibration = calibration_of(row)
    if calibration.run != row.run or digests.get(row.run) != calibration.digest:
        yield (
            f"it is of run {calibration.run} with digest {calibration.digest}, which is "
            f"not what run {row.run} holds; calibrate run {row.run} again"
        )
    elif not _untouched(row):
        yield f"its document was changed after it was kept; {RESTORE}"


def _rows(result: str, home: Home) -> Sequence[sql.Row]:
    table = tables.results
    return database.rows(home, sql.select(table).where(table.c.id == result))


def _untouched(row: sql.Row) -> bool:
    return bool(row.id == result_id(row.supersedes, row.document))


def _unchanged(path: Path, expected: str) -> Iterator[str]:
    try:
        same = is_as_kept(path, expected)
    except OSError as error:
        yield f"{error.strerror}; restore it from a backup"
        return
    if not same:
        yield "it was changed after it was kept; restore it from a backup"


def _record(entry: Entry, home: Home) -> Iterator[str]:
    """Whether the record says what the register says, and what the result that it prints does.

    What became of a certificate after its issue stands in the register alone.
    """
    record = record_of(entry, home)
    since = entry.state in ("amended", "withdrawn")
    state = record.state if since else entry.state
    of_record = (
        record.number, record.state, record.decision.verdict, record.due, record.evidence_sha256,
    )  # fmt: skip
    of_entry = (entry.number, state, entry.verdict, entry.due, entry.evidence_sha256)
    if of_record != of_entry:
        yield (
            "the register and the record differ in number, state, verdict, due date "
            "or evidence; "
            f"believe the record, and {RESTORE}"
        )
    rows = _rows(entry.result, home)
    if not rows:
        yield f"its result {entry.result} is gone; {RESTORE}"
    elif not _untouched(rows[0]):
        return  # a fault of the result itself
    elif calibration_of(rows[0]).model_dump_json() != record.calibration.model_dump_json():
        yield (
            f"its record prints another calibration than result {entry.result}, which the "
            f"register names; believe the record, and {RESTORE}"
        )


def _unknown(blobs: Blobs, runs: list[Run]) -> Iterator[Found]:
    """Recordings and what is made of them in folder or bucket that the catalogue does not name."""
    known = {f"raw/{run.digest}.mcap" for run in runs} | {f"columns/{run.digest}" for run in runs}
    known |= {run_statistics.name_of(run.digest) for run in runs}
    known |= {discrepancies.name_of(run.digest) for run in runs}
    folders = ("raw", "columns", run_statistics.FOLDER, discrepancies.FOLDER)
    for kept in (each for folder in folders for each in blobs.kept(folder)):
        if kept.name not in known:
            yield from _left_over(blobs.where(kept.name), kept.age_s)


def _unknown_papers(home: Home, register: list[Entry]) -> Iterator[Found]:
    known = {home.path / name for entry in register for name in entry.files}
    for path in sorted(home.certificates.glob("*")):
        if path not in known and age_s(path) > ISSUE_S:
            yield str(path), BROKEN_OFF if is_of_draft(path) else LEFT_OVER


def _left_over(where: str, age_s: float) -> Iterator[Found]:
    if not where.rpartition("/")[2].startswith("."):
        yield where, f"the catalogue does not know it; {UNKNOWN}"
    elif age_s > DRAFT_AGE_S:
        yield where, "left by what was broken off; delete it"


def _abandoned(home: Home) -> Iterator[Found]:
    for path in sorted(home.acquiring.glob("*.mcap")):
        if age_s(path) > SILENT_S and has_readings(path):  # the next run removes the others
            yield (
                str(path),
                "an acquisition that was broken off; `mimucal import --salvage` takes in what "
                "is whole of it, then delete the file",
            )


def against_trail(home: Home) -> Iterator[str]:
    """Certificates of which the register does not say what the trail does.

    Looked at twice: what others change in between is no fault.
    """
    first = set(_differences(home))
    if first:
        yield from (fault for fault in _differences(home) if fault in first)


def number_gaps(home: Home) -> Iterator[str]:
    """Numbers that were given and are gone."""
    for number in certificates.missing(home):
        yield f"{number} was given and is not in the register; {RESTORE}"


def _differences(home: Home) -> Iterator[str]:
    standing = _standing(home)
    register = {entry.number: entry for entry in certificates.register(home)}
    for number, (state, hashes) in standing.items():
        entry = register.get(number)
        if entry is None:
            yield f"{number} is {state} in the trail and is not in the register; {RESTORE}"
            continue
        if entry.state != state:
            yield f"{number} is {state} in the trail and {entry.state} in the register; {RESTORE}"
        if hashes and hashes != [entry.pdf_sha256, entry.dcc_sha256, entry.record_sha256]:
            yield f"{number} has other files in the register than in the trail; {RESTORE}"
    for number in register.keys() - standing.keys():
        if register[number].purpose is not None:  # an earlier version kept no trail
            yield f"{number} is in the register, and the trail does not know it; {RESTORE}"


def _standing(home: Home) -> dict[str, Standing]:
    """What the trail says of each certificate; the key of a draft is gone with its issue."""
    standing: dict[str, Standing] = {}
    for entry in audit_trail.entries(home):
        if entry.action not in AFTER:
            continue
        details = json.loads(entry.details)
        for gone in (*details.get("dropped", ()), details.get("draft")):
            standing.pop(gone, None)
        before = standing.get(entry.subject, ("draft", []))[1]
        standing[entry.subject] = AFTER[entry.action], details.get("sha256", before)
    return standing
