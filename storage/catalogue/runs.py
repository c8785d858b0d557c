"""Recordings in the store: imported once, identified by their content, read as columns.

The formats are imported where a recording is read or written: lists and manifests need none.
"""

from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import sqlalchemy as sql

from schemas.base import Unusable
from schemas.recording import Manifest, Recording, Unit
from storage.blobs import Unreachable, blobs_of
from storage.catalogue import database, lineage, tables
from storage.catalogue.run_index import Run, find
from storage.formats.manifest import MANIFEST, manifest_of
from storage.home import Home

ID_DIGITS = 12  # hex digits of the digest in a run's id


def add(recording: Recording, home: Home, *, source: Path | None = None) -> tuple[Run, bool]:
    """Adds a recording to the store: raw MCAP, columns, and last its row in the catalogue.

    Returns the run and whether it is new. The same content is the same run, also when it is added
    twice at the same time; missing files of it are written again. `source`, if its bytes alone
    determine the content, is remembered for `imported_before`. Raises Unusable if the home cannot
    be written.
    """
    from storage.formats import recordings
    from storage.formats.content import as_raw, fingerprint
    from storage.formats.mcap.writer import write_mcap

    source_bytes = source and recordings.fingerprint(source)
    recording = as_raw(recording)
    recording = replace(recording, digest=fingerprint(recording))
    blobs_of(home).keep(_raw(recording.digest), partial(write_mcap, recording))
    _write_columns(recording, home)
    with database.changing(home) as connection:
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
            imported_at=datetime.now(UTC),
            seconds=float(t[-1] - t[0]),
            rows=len(t),
            **lineage.provenance(manifest),
        )
        lineage.add_equipment(connection, run, lineage.MANIFEST, lineage.equipment_of(manifest))
        if source_bytes:
            database.add_new(
                connection, tables.sources, fingerprint=source_bytes, run=run, path=str(source)
            )
    return find(run, home), is_new


def imported_before(path: Path, home: Home) -> Run | None:
    """The run of a source whose bytes were imported before; else None."""
    from storage.formats import recordings

    same_bytes = tables.sources.c.fingerprint == recordings.fingerprint(path)
    rows = database.rows(home, sql.select(tables.sources.c.run).where(same_bytes))
    if not rows:
        return None
    run = find(rows[0].run, home)
    return run if blobs_of(home).exists(_raw(run.digest)) else None


def load(run: Run, home: Home) -> Recording:
    """A run's recording, from its columns; if they are missing or damaged, from raw.

    The columns are then made again. Raises Unusable if raw is missing or damaged as well.
    """
    recording = from_columns(run, home)
    if recording is not None:
        return recording
    recording = load_raw(run, home)
    with suppress(Unusable):  # a home that only reads still gives the recording
        blobs_of(home).remove_folder(_columns(run.digest))
        _write_columns(recording, home)
    return recording


def from_columns(run: Run, home: Home) -> Recording | None:
    """A run's recording from its columns; None unless they hold exactly what was imported."""
    from storage.formats.columns import read_columns

    try:
        with blobs_of(home).local(_columns(run.digest)) as folder:
            recording = read_columns(folder)
        return recording if recording.digest == run.digest else None
    except Unreachable:
        raise
    except Exception:  # however they are damaged, raw has it all
        return None


def load_raw(run: Run, home: Home) -> Recording:
    """A run's recording from raw; Unusable if that is missing or not what was imported."""
    from storage.formats.mcap.reader import read_mcap

    blobs, name = blobs_of(home), _raw(run.digest)
    if not blobs.exists(name):
        raise Unusable(
            f"The raw recording {blobs.where(name)} of run {run.id} is missing; import "
            f"{run.recording_id} again from its source."
        )
    with blobs.local(name) as path:
        recording = read_mcap(path)
    if recording.digest != run.digest:
        raise Unusable(
            f"The raw recording {blobs.where(name)} is not what was imported (digest "
            f"{recording.digest[:ID_DIGITS]}); move it away and import {run.recording_id} again "
            "from its source."
        )
    return recording


def manifest(run: Run, home: Home) -> Manifest:
    """A run's manifest, from beside its columns; if it is missing or damaged, from raw."""
    kept = manifest_bytes(run, home)
    if kept is not None:
        with suppress(Unusable):
            return manifest_of(kept, f"{_columns(run.digest)}/{MANIFEST}")
    return load(run, home).manifest


def manifest_bytes(run: Run, home: Home) -> bytes | None:
    """The manifest beside a run's columns; None if it is missing."""
    name = f"{_columns(run.digest)}/{MANIFEST}"
    if not blobs_of(home).exists(name):
        return None
    with blobs_of(home).local(name) as path:
        return bytes(path.read_bytes())


def unit_id(connection: sql.Connection, unit: Unit) -> int:
    """The unit's key in the catalogue, created if needed."""
    identity = {name: getattr(unit, name) for name in ("manufacturer", "model", "serial")}
    database.add_new(connection, tables.units, **identity)
    same = [tables.units.c[name] == value for name, value in identity.items()]
    return int(connection.execute(sql.select(tables.units.c.id).where(*same)).scalar_one())


def _write_columns(recording: Recording, home: Home) -> None:
    from storage.formats.columns import write_columns

    blobs_of(home).keep_folder(_columns(recording.digest), partial(write_columns, recording))


def _raw(digest: str) -> str:
    return f"raw/{digest}.mcap"


def _columns(digest: str) -> str:
    return f"columns/{digest}"
