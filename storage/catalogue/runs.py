"""Recordings in the store: imported once, identified by their content, read as columns.

The formats are imported where a recording is read or written: lists and manifests need none.
"""

import os
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, date, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import sqlalchemy as sql

from schemas.base import Frozen, Unusable
from schemas.recording import Manifest, Recording, Unit
from schemas.text import Message
from storage.blobs import Unreachable, blobs_of
from storage.catalogue import database, tables
from storage.home import Home

if TYPE_CHECKING:
    from schemas.recording import Manifest


# The runs in the catalogue: listed, and found by what a person calls them.
#
# Apart from `runs`, which reads and writes recordings and loads numpy and their formats for it.


class Run(Frozen):
    """A recording in the store. `seconds`: from its first row to its last one.

    station, procedure and recorded_on are what the manifest says; null where it says nothing, and
    until `lineage.complete` for a run of an earlier version.
    """

    id: str
    digest: str
    recording_id: str
    manufacturer: str
    model: str
    serial: str
    standard: str
    imported_at: datetime
    seconds: float
    rows: int
    station: str | None = None
    procedure: str | None = None
    recorded_on: date | None = None


def find(reference: str, home: Home) -> Run:
    """The run with this id, digest or recording_id, or the only one with this beginning.

    Raises Unusable for none and for several.
    """
    table = tables.runs.c
    begins = [column.startswith(reference, autoescape=True) for column in (table.id, table.digest)]
    for meant in (
        sql.or_(table.id == reference, table.digest == reference),
        table.recording_id == reference,
        sql.or_(*begins),
    ):
        matching = runs_where(home, meant) if reference else []
        if len(matching) > 1:
            raise Unusable(
                f"{reference!r} means {len(matching)} runs ({_listed(matching)}); give the id of "
                "one, as `mimucal runs` lists them.",
                Message("cause-several-runs", (("name", reference), ("count", len(matching)))),
            )
        if matching:
            return matching[0]
    path = ", and no file or folder of that name" if os.sep in reference else ""
    raise Unusable(
        f"There is no run {reference!r} in {home.path}{path}; `mimucal runs` lists them.",
        Message("cause-none.run", (("name", reference),)),
    )


def _listed(several: list[Run]) -> str:
    ids = [run.id for run in several]
    return ", ".join(ids if len(ids) <= 4 else [*ids[:4], "…"])


def all_runs(home: Home) -> list[Run]:
    """Every run, in the order of import."""
    return runs_where(home, sql.true())


def runs_where(home: Home, which: sql.ColumnElement[bool]) -> list[Run]:
    """The runs that meet a condition on `runs` and `units`, in the order of import."""
    return database.with_units(home, Run, tables.runs, which, tables.runs.c.imported_at)


# Where a run was recorded and with which measurement standards, as the catalogue keeps it.
#
# The measurement standards of a run are those that its manifest names, and those of the
# laboratory on each certificate that stands on the run.

STANDARD_DOCUMENT = (
    "manifest"  # the document that names a standard; else the number of a certificate
)


class Used(Frozen):
    """A measurement standard, and the calibration certificate under which a run used it."""

    name: str
    serial: str
    certificate: str


def provenance(manifest: "Manifest") -> dict[str, Any]:
    """station, procedure and recorded_on of a manifest; None where it states none.

    The day is that of the station's own clock (`recorded_at`), else of the first row
    (`acquired_at` of mimu-recording/1).
    """
    free = manifest.model_extra or {}
    procedure = free.get("procedure")
    return {
        "station": manifest.station.id,
        "procedure": procedure if isinstance(procedure, str) else None,
        "recorded_on": stated_day(free.get("recorded_at")) or stated_day(free.get("acquired_at")),
    }


def equipment_of(manifest: "Manifest") -> list[Used]:
    """The measurement standards of a manifest; incomplete entries are left out."""
    listed = (manifest.model_extra or {}).get("equipment")
    records = listed if isinstance(listed, list | tuple) else ()
    named = [each for each in records if isinstance(each, Mapping)]
    return [
        Used(**{name: str(each.get(name) or "") for name in Used.model_fields}) for each in named
    ]


def add_equipment(
    connection: sql.Connection, run: str, document: str, used: Iterable[Used]
) -> None:
    """Records the measurement standards that a document names for a run."""
    for each in used:
        row = {"run": run, "document": document, **each.model_dump()}
        database.add_new(connection, tables.equipment, **row)


def named_by(name: str) -> sql.ColumnElement[bool]:
    """The condition on `equipment` that a name, serial number or certificate is the given one."""
    used = tables.equipment.c
    return sql.or_(used.name == name, used.serial == name, used.certificate == name)


def stated_day(moment: object) -> date | None:
    """The day of a moment in ISO 8601, in the time zone of that text; None where it is none."""
    try:
        return datetime.fromisoformat(moment).date() if isinstance(moment, str) else None
    except ValueError:
        return None


ID_DIGITS = 12  # hex digits of the digest in a run's id


def add(recording: Recording, home: Home, *, source: Path | None = None) -> tuple[Run, bool]:
    """Adds a recording to the store: raw MCAP, columns, and last its row in the catalogue.

    Returns the run and whether it is new. The same content is the same run, also when it is added
    twice at the same time; missing files of it are written again. `source`, if its bytes alone
    determine the content, is remembered for `imported_before`. Raises Unusable if the home cannot
    be written.
    """
    from storage.formats import recordings
    from storage.formats.content import canonical, fingerprint
    from storage.formats.mcap.writer import write_mcap

    source_bytes = source and recordings.fingerprint(source)
    recording = canonical(recording)
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
            **provenance(manifest),
        )
        add_equipment(connection, run, STANDARD_DOCUMENT, equipment_of(manifest))
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
    from storage.formats.content import read_columns

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
    from storage.formats.manifest import MANIFEST, manifest_of  # late: lists start without numpy

    name, blobs = f"{_columns(run.digest)}/{MANIFEST}", blobs_of(home)
    if blobs.exists(name):
        with blobs.local(name) as path:
            kept = path.read_bytes()
        with suppress(Unusable):
            return manifest_of(kept, name)
    return load(run, home).manifest


def unit_id(connection: sql.Connection, unit: Unit) -> int:
    """The unit's key in the catalogue, created if needed."""
    identity = {name: getattr(unit, name) for name in ("manufacturer", "model", "serial")}
    database.add_new(connection, tables.units, **identity)
    same = [tables.units.c[name] == value for name, value in identity.items()]
    return int(connection.execute(sql.select(tables.units.c.id).where(*same)).scalar_one())


def _write_columns(recording: Recording, home: Home) -> None:
    from storage.formats.content import write_columns

    blobs_of(home).keep_folder(_columns(recording.digest), partial(write_columns, recording))


def _raw(digest: str) -> str:
    return f"raw/{digest}.mcap"


def _columns(digest: str) -> str:
    return f"columns/{digest}"
