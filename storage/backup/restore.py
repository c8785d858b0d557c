"""A home, its store and its catalogue from a backup."""

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory

import sqlalchemy as sql

from schemas.base import Unusable
from schemas.recording import ENDED
from schemas.store import BackupManifest, KeptFile
from storage.backup import back_up
from storage.backup.back_up import RAW, Objects
from storage.blobs import blobs_of
from storage.catalogue import database, dump
from storage.catalogue.database import engine_of, explained, name_of, url_of
from storage.home import RESTORING, Home
from storage.stations import statuses
from storage.verify import StoreFault, verify
from storage.whole_files import drafted, writing_in_home

Progress = Callable[[int, int], None]
EMPTY = (
    "restore onto an empty one: let MIMUCAL_HOME, MIMUCAL_DATABASE and MIMUCAL_STORE name new ones"
)


def restore(
    folder: Path, name: str | None, home: Home, progress: Progress
) -> tuple[str, BackupManifest]:
    """Puts a backup, else the newest of a folder, into an empty home; gives its name and manifest.

    Every content is read and checked before anything is written, and the catalogue is compared with
    what was kept before it counts. The same call continues an interrupted restore; until it is
    complete, no command accepts the home. Raises Unusable for a home, database or store that holds
    anything, and for a backup of a newer program or of before the first release.
    """
    objects = Objects(folder)
    manifest = objects.manifest(name)
    name = name or objects.names()[-1]
    if manifest.revision > database.HEAD:
        raise Unusable(
            f"The backup {name} has revision {manifest.revision}, which this program (revision "
            f"{database.HEAD}) does not know; update mimucal."
        )
    database.check_known(manifest.revision, f"The backup {name}")
    _check_empty(home, name)
    wanted = {each.object for each in manifest.tables} | {each.object for each in manifest.files}
    steps = len(wanted) + len(manifest.files)
    for done, _ in enumerate(objects.check(wanted), start=1):
        progress(done, steps)
    with writing_in_home(home.path / RESTORING):
        (home.path / RESTORING).write_text(name, encoding="utf-8")
        for done, each in enumerate(manifest.files, start=len(wanted) + 1):
            _put(each, objects.path(each.object), home)
            progress(done, steps)
        with dump.alone(home) as connection:
            back_up.make(connection, manifest.tables, manifest.revision, objects)
            database.bring_to(connection, database.HEAD)
        (home.path / RESTORING).unlink()
    return name, manifest


def _check_empty(home: Home, name: str) -> None:
    marker = home.path / RESTORING
    goes_on = marker.exists() and marker.read_text(encoding="utf-8") == name
    if not goes_on and home.path.exists() and any(home.path.iterdir()):
        raise Unusable(f"The home {home.path} is not empty; {EMPTY}.")
    if not goes_on and (there := blobs_of(home).kept(RAW)):
        raise Unusable(f"{blobs_of(home).where(there[0].name)} is there already; {EMPTY}.")
    url = url_of(home)
    if url.get_backend_name() == "sqlite" and not Path(url.database or "").exists():
        return
    made = engine_of(url, database.BUSY_S)
    with explained(made), made.connect() as connection:
        if sql.inspect(connection).get_table_names():
            raise Unusable(f"The database {name_of(home)} is not empty; {EMPTY}.")


def _put(each: KeptFile, content: Path, home: Home) -> None:
    if each.name.startswith(f"{RAW}/"):
        blobs_of(home).keep(each.name, lambda draft: _copied(content, draft))
        return
    path = home.path / each.name
    path.parent.mkdir(parents=True, exist_ok=True)
    with drafted(path) as draft:
        draft.touch(mode=0o600)
        _copied(content, draft)
        draft.chmod(each.mode)


def _copied(content: Path, draft: Path) -> None:
    shutil.copyfile(content, draft)


# A catalogue of an earlier version brought to this one's tables, with a way back.
#
# The way back is a copy of the catalogue as it was, in the home's folder `upgrade`, until the
# upgrade is confirmed. Recordings and certificates are not touched by either.

ROOM = 4  # times the catalogue: a copy, its rehearsal, the migration's own log, and one to spare
LEAST_ROOM = 64 * 2**20  # bytes


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
            back_up.make(connection, kept.tables, kept.revision, objects)
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
        back_up.make(connection, kept.tables, kept.revision, objects)
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
        tables=back_up.copied(connection, objects),
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
