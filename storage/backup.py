"""Backups: a consistent copy of a home while runs go on, a home made of one, and upgrades."""

import fcntl
import hashlib
import shutil
import stat
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import sqlalchemy as sql
import zstandard
from pydantic import ValidationError

from schemas.base import Progress, Unusable, first_fault
from schemas.recording import ENDED
from schemas.store import BackupManifest, KeptFile, KeptTable
from storage.blobs import Blobs, blobs_of
from storage.catalogue import database, dump
from storage.catalogue.database import engine_of, explained, name_of, url_of
from storage.catalogue.dump import snapshot
from storage.home import RESTORING, Home
from storage.stations import statuses
from storage.verify import StoreFault, verify
from storage.whole_files import drafted, to_disk, writing_in_home

# The folder of a backup: files named by the SHA-256 of their content, and a manifest of each.
#
# objects/ab/abcd… content, written once backups/20261127T211530.000000Z.json manifest, written
# when everything it names is there

PART = 2**20  # bytes at a time
PRIVATE_FOLDER, PRIVATE_FILE = 0o700, 0o400  # it contains keys and password hashes
NAME = "%Y%m%dT%H%M%S.%fZ"

Write = Callable[[Path], None]


class Objects:
    """The folder of a backup; nothing is made before something is kept."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    @contextmanager
    def writing(self) -> Iterator[None]:
        """One writer at a time; incomplete files of an earlier one are removed. Unusable for a
        folder that cannot be written.
        """
        try:
            self._folder.mkdir(mode=PRIVATE_FOLDER, parents=True, exist_ok=True)
            with (self._folder / "lock").open("a") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                for left in self._folder.glob("*/**/.*.part"):
                    left.unlink()
                yield
        except BlockingIOError as error:
            raise Unusable(
                f"another backup into {self._folder} is going on; wait for it."
            ) from error
        except OSError as error:
            raise Unusable(
                f"{error.filename or self._folder} cannot be written ({error.strerror or error}); "
                "make room or give rights there, or name another folder."
            ) from error

    def add(self, write: Write) -> str:
        """Keeps the file that `write` writes; gives its SHA-256."""
        folder = self._folder / "objects"
        folder.mkdir(exist_ok=True)
        draft = folder / ".new.part"
        try:
            write(draft)
            with draft.open("rb") as made:
                sha256 = hashlib.file_digest(made, "sha256").hexdigest()
            if not self.has(sha256):
                draft.chmod(PRIVATE_FILE)
                to_disk(draft)
                self.path(sha256).parent.mkdir(exist_ok=True)
                draft.replace(self.path(sha256))
                to_disk(self.path(sha256).parent)
        finally:
            draft.unlink(missing_ok=True)
        return sha256

    def add_file(self, path: Path) -> str:
        """Keeps a file as it is now; FileNotFoundError if it is not there."""
        with path.open("rb") as opened:
            sha256 = hashlib.file_digest(opened, "sha256").hexdigest()
        if self.has(sha256):
            return sha256
        return self.add(lambda draft: _copied_file(path, draft))

    def has(self, sha256: str) -> bool:
        """Whether a content is kept already."""
        return self.path(sha256).exists()

    def path(self, sha256: str) -> Path:
        """Where a content is kept."""
        return self._folder / "objects" / sha256[:2] / sha256

    def finish(self, manifest: BackupManifest) -> str:
        """Writes the manifest, which makes the backup whole; gives the backup's name."""
        name = manifest.made_at.strftime(NAME)
        path = self._folder / "backups" / f"{name}.json"
        path.parent.mkdir(exist_ok=True)
        with drafted(path) as draft:
            draft.write_text(manifest.model_dump_json(indent=1) + "\n", encoding="utf-8")
            draft.chmod(PRIVATE_FILE)
            to_disk(draft)
        to_disk(path.parent)
        return name

    def names(self) -> list[str]:
        """The whole backups, the oldest first."""
        return sorted(path.stem for path in (self._folder / "backups").glob("[!.]*.json"))

    def manifest(self, name: str | None = None) -> BackupManifest:
        """The manifest of a backup, else of the newest; Unusable if there is none."""
        names = self.names()
        if name is not None and name not in names:
            there = f"there are {', '.join(names)}" if names else "there is none"
            raise Unusable(f"{self._folder} holds no whole backup {name!r}: {there}.")
        if not names:
            raise Unusable(f"{self._folder} holds no whole backup; name the folder of one.")
        path = self._folder / "backups" / f"{name or names[-1]}.json"
        try:
            return BackupManifest.model_validate_json(path.read_bytes())
        except ValidationError as error:
            raise Unusable(
                f"{path}: {first_fault(error)}; restore an earlier backup with --backup."
            ) from error
        except OSError as error:
            raise Unusable(
                f"{path} cannot be read ({error.strerror}); give rights there."
            ) from error

    def check(self, wanted: Iterable[str]) -> Iterator[str]:
        """Reads each content, and gives its SHA-256; Unusable for one that has changed."""
        for sha256 in wanted:
            path = self.path(sha256)
            try:
                with path.open("rb") as opened:
                    is_sound = hashlib.file_digest(opened, "sha256").hexdigest() == sha256
            except OSError as error:
                raise Unusable(
                    f"{path} cannot be read ({error.strerror}); restore an earlier backup with "
                    "--backup, or from another copy of this folder."
                ) from error
            if not is_sound:
                raise Unusable(
                    f"{path} is not as it was kept; restore an earlier backup with --backup, or "
                    "from another copy of this folder."
                )
            yield sha256


def _copied_file(path: Path, draft: Path) -> None:
    with path.open("rb") as source, draft.open("wb") as target:
        shutil.copyfileobj(source, target, PART)


# The catalogue as contents of a backup's folder, and a catalogue from them.

LEVEL = 3  # of compression: documents shrink to a tenth, faster than a disk takes them


def copied(connection: sql.Connection, objects: Objects) -> tuple[KeptTable, ...]:
    """Keeps every table of a transaction's catalogue, of whatever revision."""
    return tuple(_copied_table(connection, table, objects) for table in dump.tables_of(connection))


def _copied_table(connection: sql.Connection, table: sql.Table, objects: Objects) -> KeptTable:
    rows, digest = 0, hashlib.sha256()

    def write(draft: Path) -> None:
        nonlocal rows
        packer = zstandard.ZstdCompressor(level=LEVEL)
        with draft.open("wb") as file, packer.stream_writer(file) as packed:
            for line in dump.lines(connection, table):
                packed.write(line)
                digest.update(line)
                rows += 1

    kept = objects.add(write)
    return KeptTable(
        name=table.name, columns=dump.columns_of(table), rows=rows, lines=digest.hexdigest(),
        object=kept,
    )  # fmt: skip


def lines_of(table: KeptTable, objects: Objects) -> Iterator[bytes]:
    """The rows of a kept table."""
    with objects.path(table.object).open("rb") as file:
        unpacked, rest = zstandard.ZstdDecompressor().read_to_iter(file), b""
        for part in unpacked:
            *whole, rest = (rest + part).split(b"\n")
            yield from (line + b"\n" for line in whole)


def make(
    connection: sql.Connection, kept: tuple[KeptTable, ...], revision: str, objects: Objects
) -> None:
    """Makes a catalogue of a revision in an empty database, and fills it.

    Raises Unusable where it then does not hold what was kept.
    """
    database.bring_to(connection, revision)
    tables, of_name = dump.tables_of(connection), {each.name: each for each in kept}
    if {table.name for table in tables} != of_name.keys():
        named = ", ".join(sorted({table.name for table in tables} ^ of_name.keys()))
        raise Unusable(f"The backup has other tables than revision {revision} ({named}).")
    pointing = []
    for table in tables:
        each = of_name[table.name]
        rows = lines_of(each, objects)
        pointing.append((table, list(dump.load(connection, table, each.columns, rows))))
    for table, rows_of_table in pointing:
        dump.point(connection, table, rows_of_table)
    dump.count_on(connection, tables)
    for table in tables:
        digest = hashlib.sha256()
        for line in dump.lines(connection, table):
            digest.update(line)
        if digest.hexdigest() != of_name[table.name].lines:
            raise Unusable(
                f"The table {table.name} does not hold what the backup has; nothing was restored. "
                "Restore an earlier backup with --backup."
            )


ATTEMPTS = 3  # if something in the catalogue was deleted before it was copied
RAW, CERTIFICATES = "raw", "certificates"
# Reproducible from raw, belonging to a run in progress or to this machine only, or kept in another
# way.
LEFT_OUT = {
    RAW, CERTIFICATES, "columns", "acquiring", "locks", "status", "prefect", "upgrade",
    "upgrade-left",
    "catalog.sqlite", "catalog.sqlite-wal", "catalog.sqlite-shm",
}  # fmt: skip


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
        tables = copied(connection, objects)
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


# A home, its store and its catalogue from a backup.


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
            make(connection, manifest.tables, manifest.revision, objects)
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
            kept = _manifest_of(connection, objects, version)
        with dump.alone(copy) as connection:
            make(connection, kept.tables, kept.revision, objects)
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
                kept = _manifest_of(connection, objects, version)
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
        now = _manifest_of(connection, left, version)
        left.finish(now)
        dump.drop(connection)
        make(connection, kept.tables, kept.revision, objects)
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


def _manifest_of(connection: sql.Connection, objects: Objects, version: str) -> BackupManifest:
    revision = database.revision_of(connection)
    assert revision is not None
    return BackupManifest(
        made_at=datetime.now(UTC), code_version=version, revision=revision,
        tables=copied(connection, objects),
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
