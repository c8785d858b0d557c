"""The folder of a backup: files named by the SHA-256 of their content, and a manifest of each.

objects/ab/abcd…             content, written once
backups/20261127T211530.000000Z.json   manifest, written when everything it names is there
"""

import fcntl
import hashlib
import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from pydantic import ValidationError

from schemas.backup import BackupManifest
from schemas.base import Unusable, first_fault
from storage.whole_files import drafted, to_disk

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
        return self.add(lambda draft: _copied(path, draft))

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


def _copied(path: Path, draft: Path) -> None:
    with path.open("rb") as source, draft.open("wb") as target:
        shutil.copyfileobj(source, target, PART)
