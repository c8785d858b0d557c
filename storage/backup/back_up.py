"""A consistent copy of a home while runs go on: catalogue, recordings, certificates, settings."""

import stat
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import sqlalchemy as sql

from schemas.backup import BackupManifest, KeptFile
from schemas.base import Unusable
from storage.backup import catalogue_copy
from storage.backup.objects import Objects
from storage.blobs import Blobs, blobs_of
from storage.catalogue import database
from storage.catalogue.dump import snapshot
from storage.home import Home

ATTEMPTS = 3  # if something in the catalogue was deleted before it was copied
RAW, CERTIFICATES = "raw", "certificates"
# Reproducible from raw, belonging to a run in progress or to this machine only, or kept in another
# way.
LEFT_OUT = {
    RAW, CERTIFICATES, "columns", "acquiring", "locks", "status", "prefect", "upgrade",
    "upgrade-left",
    "catalog.sqlite", "catalog.sqlite-wal", "catalog.sqlite-shm",
}  # fmt: skip

Progress = Callable[[int, int], None]


def back_up(
    home: Home, folder: Path, version: str, progress: Progress
) -> tuple[str, BackupManifest]:
    """Adds a backup of the home to a folder; gives its name and manifest.

    The catalogue is that of one moment, and the recordings and certificates are those it names.
    What the folder has already is not copied again. Raises Unusable for a home that holds nothing,
    and for a folder within the home.
    """
    if folder.resolve().is_relative_to(home.path.resolve()):
        raise Unusable(f"{folder} lies in the home {home.path}; name a folder on another disk.")
    objects = Objects(folder)
    with objects.writing():
        for _ in range(ATTEMPTS):
            manifest = _taken(home, objects, version, progress)
            if not manifest.missing:
                break
        return objects.finish(manifest), manifest


def _taken(home: Home, objects: Objects, version: str, progress: Progress) -> BackupManifest:
    made_at = datetime.now(UTC)
    with snapshot(home) as connection:
        revision = None if connection is None else database.revision_of(connection)
        if connection is None or revision is None:
            raise Unusable(f"{home.path} has no catalogue; there is nothing to back up.")
        tables = catalogue_copy.copied(connection, objects)
        recordings = [f"{RAW}/{each}.mcap" for each in _column(connection, "runs", "digest")]
        papers = [
            name
            for column in ("pdf", "record", "dcc", "evidence")
            for name in _column(connection, "certificates", column)
            if name
        ]
    blobs, known, found = blobs_of(home), _known(objects), list[KeptFile]()
    own = [str(path.relative_to(home.path)) for path in _own_files(home)]
    keep = [
        *(partial(_recording, name, known, blobs, objects) for name in recordings),
        *(partial(_kept, name, home.path / name, objects) for name in (*papers, *own)),
    ]
    for done, each in enumerate(keep, start=1):
        if kept := each():
            found.append(kept)
        progress(done, len(keep))
    missing = {*recordings, *papers} - {each.name for each in found}
    return BackupManifest(
        made_at=made_at, code_version=version, revision=revision, tables=tables,
        files=tuple(found), missing=tuple(sorted(missing)),
    )  # fmt: skip


def _column(connection: sql.Connection, table: str, column: str) -> list[str]:
    """A column of a table of any revision; older ones lack some."""
    names = {each["name"] for each in sql.inspect(connection).get_columns(table)}
    if column not in names:
        return []
    return list(connection.scalars(sql.select(sql.column(column)).select_from(sql.table(table))))


def _known(objects: Objects) -> dict[str, KeptFile]:
    """The recordings of the newest backup by name: they are written once and never changed."""
    if not objects.names():
        return {}
    files = objects.manifest().files
    return {each.name: each for each in files if each.name.startswith(f"{RAW}/")}


def _recording(
    name: str, known: dict[str, KeptFile], blobs: Blobs, objects: Objects
) -> KeptFile | None:
    if name in known and objects.has(known[name].object):
        return known[name]
    if not blobs.exists(name):
        return None
    with blobs.local(name) as path:
        return _kept(name, path, objects)


def _kept(name: str, path: Path, objects: Objects) -> KeptFile | None:
    """None for a file that is gone meanwhile."""
    try:
        about = path.stat()
        sha256 = objects.add_file(path)
    except FileNotFoundError:
        return None
    size = objects.path(sha256).stat().st_size
    return KeptFile(name=name, object=sha256, size=size, mode=stat.S_IMODE(about.st_mode))


def _own_files(home: Home) -> Iterator[Path]:
    """What people and keys put there: settings, limits, stations, keys; no drafts."""
    tops = (path for path in sorted(home.path.iterdir()) if path.name not in LEFT_OUT)
    for path in (each for top in tops for each in (top, *sorted(top.rglob("*")))):
        is_draft = path.name.startswith(".") and path.name.endswith(".part")
        if path.is_file() and not is_draft:
            yield path
