"""Recordings in the store: imported once, known by their content, read as columns."""

import shutil
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import sqlalchemy as sql

from schemas.base import Unusable
from schemas.recording import Recording, Unit
from storage.catalogue import database, lineage, tables
from storage.catalogue.listing import Run, find
from storage.formats import recordings
from storage.formats.columns import read_columns, write_columns
from storage.formats.content import as_raw, fingerprint
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import write_mcap
from storage.home import Home
from storage.whole_files import writing_in_home, writing_to

ID_DIGITS = 12  # hex digits of the digest in a run's id


def add(recording: Recording, home: Home, *, source: Path | None = None) -> tuple[Run, bool]:
    """Takes a recording into the store: raw MCAP, columns, and last its row in the catalogue.

    Gives the run and whether it is new. The same content again is the same run, whoever brings
    it at the same time; files of it that went missing are written again. `source`, where its
    bytes alone say all of it, is remembered for `imported_before`.
    Raises Unusable when the home cannot be written.
    """
    source_bytes = source and recordings.fingerprint(source)
    recording = as_raw(recording)
    recording = replace(recording, digest=fingerprint(recording))
    raw = raw_path(recording.digest, home)
    if not raw.exists():
        with writing_to(raw) as draft:
            write_mcap(recording, draft)
    _write_columns(recording, home)
    with database.changing(home) as connection:
        run, is_new = _add(connection, recording)
        if source_bytes:
            database.add_new(
                connection, tables.sources, fingerprint=source_bytes, run=run, path=str(source)
            )
    return find(run, home), is_new


def imported_before(path: Path, home: Home) -> Run | None:
    """The run that a source became, if its bytes were imported before; else None."""
    same_bytes = tables.sources.c.fingerprint == recordings.fingerprint(path)
    rows = database.rows(home, sql.select(tables.sources.c.run).where(same_bytes))
    if not rows:
        return None
    run = find(rows[0].run, home)
    return run if raw_path(run.digest, home).exists() else None


def load(run: Run, home: Home) -> Recording:
    """A run's recording, from its columns; if they are missing or damaged, from raw.

    Then the columns are made again. Raises Unusable when raw is missing or damaged as well.
    """
    recording = from_columns(run, home)
    if recording is not None:
        return recording
    recording = _load_raw(run, home)
    shutil.rmtree(home.columns / run.digest, ignore_errors=True)
    with suppress(Unusable):  # a home that only reads still gives the recording
        _write_columns(recording, home)
    return recording


def from_columns(run: Run, home: Home) -> Recording | None:
    """A run's recording from its columns; None unless they hold exactly what was imported."""
    try:
        recording = read_columns(home.columns / run.digest)
        return recording if recording.digest == run.digest else None
    except Exception:  # however they are damaged, raw has it all
        return None


def raw_path(digest: str, home: Home) -> Path:
    """Where the raw recording of a digest is kept."""
    return home.raw / f"{digest}.mcap"


def unit_id(connection: sql.Connection, unit: Unit) -> int:
    """The unit's key in the catalogue, new if it must be."""
    identity = {name: getattr(unit, name) for name in ("manufacturer", "model", "serial")}
    database.add_new(connection, tables.units, **identity)
    same = [tables.units.c[name] == value for name, value in identity.items()]
    return int(connection.execute(sql.select(tables.units.c.id).where(*same)).scalar_one())


def _add(connection: sql.Connection, recording: Recording) -> tuple[str, bool]:
    manifest, t = recording.manifest, recording.imu.t
    run = f"r{recording.digest[:ID_DIGITS]}"
    is_new = database.add_new(
        connection,
        tables.runs,
        id=run,
        digest=recording.digest,
        recording_id=manifest.recording_id,
        unit=unit_id(connection, manifest.unit),
        standard=manifest.standard,
        taken_in_at=datetime.now(UTC),
        seconds=float(t[-1] - t[0]),
        rows=len(t),
        **lineage.provenance(manifest),
    )
    lineage.add_equipment(connection, run, lineage.MANIFEST, lineage.equipment_of(manifest))
    return run, is_new


def _write_columns(recording: Recording, home: Home) -> None:
    folder = home.columns / recording.digest
    if folder.exists():
        return
    with writing_in_home(folder), suppress(FileExistsError):  # somebody was faster with the same
        write_columns(recording, folder)


def _load_raw(run: Run, home: Home) -> Recording:
    path = raw_path(run.digest, home)
    if not path.exists():
        raise Unusable(
            f"The raw recording {path} of run {run.id} is missing; import {run.recording_id} "
            "again from its source."
        )
    recording = read_mcap(path)
    if recording.digest != run.digest:
        raise Unusable(
            f"The raw recording {path} is not what was taken in (digest "
            f"{recording.digest[:ID_DIGITS]}); move it away and import {run.recording_id} again "
            "from its source."
        )
    return recording
