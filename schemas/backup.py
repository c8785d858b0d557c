"""What a backup holds: its tables, files and recordings, each by the SHA-256 of its content."""

from pathlib import PurePosixPath
from typing import Annotated, Literal

from pydantic import AfterValidator, AwareDatetime, Field

from schemas.base import Frozen

Sha256 = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


def _is_within(name: str) -> str:
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or not path.parts:
        raise ValueError("names no file within the home")
    return name


Name = Annotated[str, AfterValidator(_is_within)]


class KeptTable(Frozen):
    """A table of the catalogue. lines: SHA-256 of its rows as lines of JSON; object: of the file
    that holds them, compressed.
    """

    name: str
    columns: tuple[str, ...]
    rows: int
    lines: Sha256
    object: Sha256


class KeptFile(Frozen):
    """A file of the home, or a raw recording of its store; mode: who may read it."""

    name: Name
    object: Sha256
    size: int
    mode: int


class BackupManifest(Frozen):
    """A whole backup: it is written last. missing: what the catalogue names and is not there."""

    format: Literal["mimu-backup/1"] = "mimu-backup/1"
    made_at: AwareDatetime
    code_version: str
    revision: str
    tables: tuple[KeptTable, ...]
    files: tuple[KeptFile, ...] = ()
    missing: tuple[Name, ...] = ()
