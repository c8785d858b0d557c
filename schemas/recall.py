"""Who is reminded of recalibration, and how (recall.toml in the home folder), and of what."""

from datetime import date, time
from typing import Annotated, Literal, Self
from zoneinfo import ZoneInfo

from pydantic import Field, field_validator, model_validator

from schemas.base import Frozen
from schemas.text import CONTRACTED, Language

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
