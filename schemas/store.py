"""Documents of a store: its backup, what `doctor` examined, and reminders of recalibration."""

from datetime import date, time
from pathlib import PurePosixPath
from typing import Annotated, Literal, Self
from zoneinfo import ZoneInfo

from pydantic import AfterValidator, AwareDatetime, Field, field_validator, model_validator

from schemas.base import Frozen
from schemas.text import CONTRACTED, Language

# What a backup holds: its tables, files and recordings, each by the SHA-256 of its content.

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


# Problems of a machine, and their remedies.


class Examined(Frozen):
    """One thing that was examined. remedy: what to do; None if nothing is wrong."""

    what: str
    found: str
    remedy: str | None = None


class Diagnosis(Frozen):
    """Everything that `mimucal doctor` examined, in order."""

    format: Literal["mimu-doctor/1"] = "mimu-doctor/1"
    examined: tuple[Examined, ...]

    @property
    def faults(self) -> tuple[Examined, ...]:
        """The faults that somebody has to put right."""
        return tuple(one for one in self.examined if one.remedy is not None)


# Who is reminded of recalibration, and how (recall.toml in the home folder), and of what.

CHANNEL = "an Apprise URL; ${NAME} in it is taken from the environment"


class SilentHours(Frozen):
    """The hours in which nothing is sent, in a time zone."""

    since: time
    until: time
    timezone: str

    @field_validator("timezone")
    @classmethod
    def _is_known(cls, name: str) -> str:
        try:
            ZoneInfo(name)
        except (ValueError, OSError, LookupError) as error:
            raise ValueError(f"{name!r} is not a time zone; give one like Asia/Shanghai") from error
        return name


class RecallClient(Frozen):
    """A client as named in the orders, and the channels that reach it."""

    name: str = Field(min_length=1)
    language: Language = CONTRACTED[0]
    channels: dict[str, Annotated[str, Field(description=CHANNEL)]]


class Operators(Frozen):
    """Who is alerted when something of the line or the program fails, at any hour."""

    language: Language = CONTRACTED[0]
    channels: dict[str, Annotated[str, Field(description=CHANNEL)]] = Field(min_length=1)


class RecallFile(Frozen):
    """Reminders of recalibration: who gets them on which channels, and when none is sent.

    operators: who gets alerts.
    """

    format: Literal["mimu-recall/1"] = "mimu-recall/1"
    silent: SilentHours | None = None
    clients: tuple[RecallClient, ...] = ()
    operators: Operators | None = None

    @model_validator(mode="after")
    def _each_client_once(self) -> Self:
        names = [client.name for client in self.clients]
        if twice := [name for name in names if names.count(name) > 1]:
            raise ValueError(f"the client {twice[0]!r} is listed twice")
        return self


class DueUnit(Frozen):
    """A unit due for recalibration, with the issued certificate that agreed the interval.

    key: the unit's number in the catalogue. client, laboratory: the name in English and in Chinese.
    """

    unit: str
    key: int
    model: str
    certificate: str
    issued_on: date
    due: date
    client: tuple[str, str]
    laboratory: tuple[str, str]
