"""What the store can do without: recordings that nothing depends on, columns beside raw files,
and files of interrupted drafts.

A run with a result or a certificate, as found or as left, of whatever state, keeps its raw
recording for good. Its columns can be made again from it.
"""

import re
import time
from collections.abc import Collection, Iterator
from datetime import UTC, date, datetime
from functools import partial
from pathlib import Path

import sqlalchemy as sql

from schemas.base import Progress, Unusable
from schemas.history import Dispensable, Refused
from storage import run_statistics
from storage.blobs import Blobs, blobs_of
from storage.catalogue import audit_trail, certificates, database, discrepancies, runs, tables
from storage.catalogue.certificates import Entry, record_of
from storage.catalogue.runs import Run, runs_where
from storage.home import Home

# Draft files left behind by a process that ended before the catalogue knew of them.

BY_NAME = re.compile(r"draft-.+\.[0-9a-f]{12}\.(pdf|xml|json)|\..+\.part")
AGE_S = 3600.0  # a newer one may belong to a draft that is being stored


def is_of_draft(path: Path) -> bool:
    """Whether a file among the certificates has the name of a draft's, whole or half-written."""
    return BY_NAME.fullmatch(path.name) is not None


def left_drafts(home: Home, known: Collection[Path]) -> Iterator[Path]:
    """Files of drafts that are not known, an hour after they were written."""
    for path in sorted(home.certificates.glob("*")):
        if is_of_draft(path) and path not in known and age_s(path) > AGE_S:
            yield path


def age_s(path: Path) -> float:
    """Seconds since a file was written."""
    return time.time() - path.stat().st_mtime


OF_RUN = (  # rows that go with their run
    tables.findings, tables.explained, tables.reprocessed, tables.equipment, tables.sources,
)  # fmt: skip


def dispensable(before: date, home: Home) -> list[Dispensable]:
    """What was imported before a day (UTC) and may be deleted, the oldest first."""
    begins = datetime.combine(before, datetime.min.time(), UTC)
    older, needed = runs_where(home, tables.runs.c.imported_at < begins), _needed(home)
    blobs = blobs_of(home)
    sizes = {each.name: each.size for name in ("raw", "columns") for each in blobs.kept(name)}
    of_runs = [each for run in older for each in _of_run(run, run.id in needed, sizes, blobs)]
    return [*of_runs, *(draft for draft in _drafts(home) if draft.imported_at < begins)]


def delete(
    found: list[Dispensable], person: str, home: Home, progress: Progress
) -> tuple[list[Dispensable], list[Refused]]:
    """Deletes what was found, each with an entry in the trail; gives what went and what did not.

    Whether something came to need it meanwhile is asked again within each transaction, and columns
    go only where the raw recording was read and is what was imported. An end in between leaves
    files that the catalogue does not know, never a run without its recording.
    """
    deleted, refused = [], []
    for done, each in enumerate(found, start=1):
        try:
            DELETE[each.what](each, person, home)
            deleted.append(each)
        except Unusable as why:
            refused.append(Refused(run=each.run, what=each.what, where=each.where, why=str(why)))
        progress(done, len(found))
    return deleted, refused


def _of_run(run: Run, needed: bool, sizes: dict[str, int], blobs: Blobs) -> Iterator[Dispensable]:
    raw, columns = f"raw/{run.digest}.mcap", f"columns/{run.digest}"
    dispensable = partial(
        Dispensable, run=run.id, recording_id=run.recording_id, imported_at=run.imported_at
    )
    if not needed:
        size = sizes.get(raw, 0) + sizes.get(columns, 0)
        yield dispensable(what="recording", where=blobs.where(raw), size=size)
    elif raw in sizes and columns in sizes:
        yield dispensable(what="columns", where=blobs.where(columns), size=sizes[columns])


def _drafts(home: Home) -> Iterator[Dispensable]:
    register = certificates.register(home)
    known = {home.path / name for entry in register for name in entry.files}
    for path in left_drafts(home, known):
        file = path.stat()
        written = datetime.fromtimestamp(file.st_mtime, UTC)
        yield Dispensable(what="draft", imported_at=written, where=str(path), size=file.st_size)


def _needed(home: Home) -> set[str]:
    """Runs that a result or a certificate stands on.

    A certificate whose record cannot be read may print any run of its unit as found.
    """
    with_result = database.rows(home, sql.select(tables.results.c.run).distinct())
    needed = {row.run for row in with_result}
    for entry in certificates.register(home):
        needed |= {entry.run, *_as_found(entry, home)}
    return needed


def _as_found(entry: Entry, home: Home) -> set[str]:
    try:
        found = record_of(entry, home).as_found
    except Unusable:
        of_unit = [
            tables.units.c[name] == getattr(entry, name)
            for name in ("manufacturer", "model", "serial")
        ]
        return {run.id for run in runs_where(home, sql.and_(*of_unit))}
    return {found.calibration.run} if found else set()


def _delete_recording(each: Dispensable, person: str, home: Home) -> None:
    if each.run in _needed(home):
        raise Unusable("a result or a certificate now depends on it; it stays.")
    run = tables.runs.c
    with database.changing(home) as connection:
        mine = sql.select(run.digest).where(run.id == each.run).with_for_update()
        digest = connection.scalar(mine)
        if digest is None:
            raise Unusable("it is no longer in the catalogue; somebody else deleted it.")
        for table in (tables.results, tables.certificates):
            if connection.scalar(sql.select(sql.exists().where(table.c.run == each.run))):
                raise Unusable("a result or a certificate now depends on it; it stays.")
        for table in OF_RUN:
            connection.execute(sql.delete(table).where(table.c.run == each.run))
        connection.execute(sql.delete(tables.runs).where(run.id == each.run))
        _log(connection, each, person, digest)
    blobs = blobs_of(home)
    blobs.remove_file(f"raw/{digest}.mcap")
    blobs.remove_folder(f"columns/{digest}")
    blobs.remove_file(run_statistics.name_of(digest))
    blobs.remove_file(discrepancies.name_of(digest))


def _delete_columns(each: Dispensable, person: str, home: Home) -> None:
    (run,) = runs_where(home, tables.runs.c.id == each.run)
    runs.load_raw(run, home)
    with database.changing(home) as connection:
        _log(connection, each, person, run.digest)
    blobs_of(home).remove_folder(f"columns/{run.digest}")


def _delete_draft(each: Dispensable, person: str, home: Home) -> None:
    path = Path(each.where)
    if each not in _drafts(home):
        raise Unusable("a certificate came to have it, or somebody else deleted it.")
    with database.changing(home) as connection:
        audit_trail.add(connection, person, "delete draft", path.name, size=each.size)
    path.unlink(missing_ok=True)


DELETE = {"recording": _delete_recording, "columns": _delete_columns, "draft": _delete_draft}


def _log(connection: sql.Connection, each: Dispensable, person: str, digest: str) -> None:
    assert each.run is not None
    audit_trail.add(
        connection, person, f"delete {each.what}", each.run,
        recording_id=each.recording_id, digest=digest, size=each.size,
        imported_at=each.imported_at.isoformat(),
    )  # fmt: skip
