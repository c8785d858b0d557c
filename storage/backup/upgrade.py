"""A catalogue of an earlier version brought to this one's tables, with a way back.

The way back is a copy of the catalogue as it was, in the home's folder `upgrade`, until the upgrade
is confirmed. Recordings and certificates are not touched by either.
"""

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory

import sqlalchemy as sql

from schemas.backup import BackupManifest
from schemas.base import Unusable
from schemas.run_log import ENDED
from storage.backup import catalogue_copy
from storage.backup.objects import Objects
from storage.catalogue import database, dump
from storage.catalogue.connection import engine_of, name_of, url_of
from storage.home import Home
from storage.station_lock import statuses
from storage.verify import StoreFault, verify
from storage.whole_files import writing_in_home

ROOM = 4  # times the catalogue: a copy, its rehearsal, the migration's own log, and one to spare
LEAST_ROOM = 64 * 2**20  # bytes

Progress = Callable[[int, int], None]


def is_needed(home: Home) -> bool:
    """Whether the catalogue is of an earlier version; Unusable for one of a later."""
    made = database.for_reading(home)
    if made is None:
        return False
    with dump.snapshot(home) as connection:
        revision = None if connection is None else database.revision_of(connection)
    database.check_known(revision, f"The catalogue {name_of(home)}")
    if revision is None or revision < database.HEAD:
        return revision is not None
    database.check_revision(made, revision)
    return False


def rehearse(home: Home, version: str, progress: Progress) -> list[StoreFault]:
    """Upgrades a copy of the catalogue and verifies the whole store by it; gives the faults.

    Raises Unusable where the way back of an earlier upgrade is not given up yet, a run is going
    on, or the disk has too little room. The catalogue stays as it is.
    """
    if _objects(home).names():
        raise Unusable(
            "The last upgrade is not confirmed: `mimucal upgrade --confirm` gives up its way back, "
            "`mimucal upgrade --back` takes it."
        )
    going = [status.station for status, is_dead in statuses(home)
             if status.state not in ENDED and not is_dead]  # fmt: skip
    if going:
        raise Unusable(f"A run is going on at station {', '.join(going)}: wait for its end.")
    _check_room(home)
    with _room_beside(home) as folder:
        objects, copy = Objects(Path(folder)), Home(home.path, f"sqlite:///{folder}/copy.sqlite")
        with objects.writing(), dump.snapshot(home) as connection:
            assert connection is not None
            kept = _kept(connection, objects, version)
        with dump.alone(copy) as connection:
            catalogue_copy.make(connection, kept.tables, kept.revision, objects)
            database.bring_to(connection, database.HEAD)
        return verify(copy, progress)[1]


@contextmanager
def _room_beside(home: Home) -> Iterator[str]:
    """A folder on the home's disk, for the length of the block."""
    place = home.path / "upgrade"
    with writing_in_home(place):
        place.mkdir(exist_ok=True)
        try:
            with TemporaryDirectory(dir=place) as folder:
                yield folder
        finally:
            place.rmdir()


def upgrade(home: Home, version: str) -> str:
    """Keeps the way back and brings the catalogue to HEAD; gives the earlier revision.

    Nobody else writes meanwhile, and it is all or nothing.
    """
    objects = _objects(home)
    with writing_in_home(home.path / "upgrade"), objects.writing():
        try:
            with dump.alone(home) as connection:
                kept = _kept(connection, objects, version)
                objects.finish(kept)
                database.bring_to(connection, database.HEAD)
        except BaseException:
            shutil.rmtree(home.path / "upgrade")
            raise
    return kept.revision


def back(home: Home, version: str) -> tuple[str, dict[str, int]]:
    """Puts the catalogue back as it was before the upgrade; gives its revision, and how many rows
    of which table came since: they are left out, and kept in the home's folder `upgrade-left`.

    Raises Unusable where there is no way back.
    """
    objects, left = _objects(home), Objects(home.path / "upgrade-left")
    if not objects.names():
        raise Unusable("There is no upgrade to go back from: none was made, or it was confirmed.")
    kept = objects.manifest()
    for _ in objects.check({table.object for table in kept.tables}):
        pass
    with writing_in_home(home.path / "upgrade"), left.writing(), dump.alone(home) as connection:
        now = _kept(connection, left, version)
        left.finish(now)
        dump.drop(connection)
        catalogue_copy.make(connection, kept.tables, kept.revision, objects)
    shutil.rmtree(home.path / "upgrade")
    before = {table.name: table.rows for table in kept.tables}
    more = {table.name: table.rows - before.get(table.name, 0) for table in now.tables}
    return kept.revision, {name: count for name, count in more.items() if count > 0}


def confirm(home: Home) -> None:
    """Gives up the way back; Unusable where there is none."""
    if not _objects(home).names():
        raise Unusable("There is no upgrade to confirm: none was made, or it was confirmed.")
    shutil.rmtree(home.path / "upgrade")


def _objects(home: Home) -> Objects:
    return Objects(home.path / "upgrade")


def _kept(connection: sql.Connection, objects: Objects, version: str) -> BackupManifest:
    revision = database.revision_of(connection)
    assert revision is not None
    return BackupManifest(
        made_at=datetime.now(UTC), code_version=version, revision=revision,
        tables=catalogue_copy.copied(connection, objects),
    )  # fmt: skip


def _check_room(home: Home) -> None:
    url = url_of(home)
    size = 0
    if url.get_backend_name() == "sqlite":
        for end in ("", "-wal"):
            with suppress(FileNotFoundError):
                size += Path(f"{url.database}{end}").stat().st_size
    else:
        with engine_of(url, database.BUSY_S).connect() as connection:
            asked = sql.select(sql.func.pg_database_size(sql.func.current_database()))
            size = int(connection.scalar(asked) or 0)
    needed, free = max(ROOM * size, LEAST_ROOM), shutil.disk_usage(home.path).free
    if free < needed:
        raise Unusable(
            f"The disk of {home.path} has {free / 2**20:.0f} MB free, and the upgrade of "
            f"{name_of(home)} needs {needed / 2**20:.0f} MB: make room."
        )
