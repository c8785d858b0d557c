"""The folder that holds everything, and how files get into it: whole, once, read-only."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from schemas.base import Unusable

DEFAULT = "mimucal-data"


@dataclass(frozen=True)
class Home:
    """Where everything is kept; nothing is made before something is stored."""

    path: Path

    @property
    def raw(self) -> Path:
        """Raw recordings, `<digest>.mcap`."""
        return self.path / "raw"

    @property
    def columns(self) -> Path:
        """The same recordings as columns, `<digest>/`; can be made again from raw."""
        return self.path / "columns"

    @property
    def certificates(self) -> Path:
        """What was printed, and the record it was printed from."""
        return self.path / "certificates"

    @property
    def tolerances(self) -> Path:
        """The limits of each product model, one TOML or JSON file each."""
        return self.path / "tolerances"

    @property
    def acquiring(self) -> Path:
        """Raw recordings that a station is giving; they leave when they are whole runs."""
        return self.path / "acquiring"

    @property
    def prefect(self) -> Path:
        """What the embedded Prefect server keeps."""
        return self.path / "prefect"

    @property
    def demo(self) -> Path:
        """Station file and truth of the demonstration's virtual station."""
        return self.path / "demo"

    @property
    def database_url(self) -> str:
        """The catalogue: MIMUCAL_DATABASE, else a SQLite file in the home."""
        file = quote(str(self.path / "catalog.sqlite"))
        return os.environ.get("MIMUCAL_DATABASE") or f"sqlite:///{file}"


def home() -> Home:
    """The home that MIMUCAL_HOME names, else `mimucal-data` in the current folder."""
    return Home(Path(os.environ.get("MIMUCAL_HOME") or DEFAULT).expanduser().absolute())


def draft_of(path: Path) -> Path:
    """A hidden name beside `path` for what is not whole yet."""
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")


@contextmanager
def writing_to(path: Path) -> Iterator[Path]:
    """Gives a draft to write; on success it is on the disk, read-only, under `path`.

    Makes the folder first. Whatever goes wrong, nothing half stays; a disk that refuses raises
    Unusable.
    """
    draft = draft_of(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield draft
        draft.chmod(0o444)
        _to_disk(draft)
        draft.replace(path)
        _to_disk(path.parent)
    except OSError as error:
        raise Unusable(
            f"{path} cannot be written ({error.strerror or error}); make room or give rights "
            "there, or let MIMUCAL_HOME name a folder that can be written."
        ) from error
    finally:
        if os.path.lexists(draft):
            draft.unlink()


def write_once(path: Path, data: bytes) -> None:
    """Writes a file that stays as it is: whole, on the disk, read-only.

    The same content again is no fault; other content raises Unusable.
    """
    if _holds(path, data):
        return
    with writing_to(path) as draft:
        draft.write_bytes(data)


def _holds(path: Path, data: bytes) -> bool:
    """Whether the file is there with this content; raises Unusable for other content."""
    try:
        found = path.read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError as error:
        raise Unusable(f"{path} cannot be read ({error.strerror}); give rights there.") from error
    if found != data:
        raise Unusable(
            f"{path} is already there with other content, and what is kept is never overwritten; "
            "move that file away, or store this under another name."
        )
    return True


def _to_disk(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
