"""A home, its store and its catalogue from a backup."""

import shutil
from collections.abc import Callable
from pathlib import Path

import sqlalchemy as sql

from schemas.backup import BackupManifest, KeptFile
from schemas.base import Unusable
from storage.backup import catalogue_copy
from storage.backup.back_up import RAW
from storage.backup.objects import Objects
from storage.blobs import blobs_of
from storage.catalogue import database, dump
from storage.catalogue.connection import engine_of, explained, name_of, url_of
from storage.home import RESTORING, Home
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
            catalogue_copy.make(connection, manifest.tables, manifest.revision, objects)
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
