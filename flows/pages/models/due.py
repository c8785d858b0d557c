"""Due dates of units and equipment, and the messages sent to clients."""

from datetime import date, datetime
from typing import Literal

from pydantic import Field

from schemas.base import Frozen
from schemas.text import Statement

HORIZON_DAYS = 90
MessageState = Literal["sent", "failed", "waiting"]


class DueQuestion(Frozen):
    """What falls due within so many days from now, of a client and a model where they are named."""

    within: int = Field(default=HORIZON_DAYS, ge=0, le=36_500)
    client: str | None = Field(default=None, max_length=1000)
    model: str | None = Field(default=None, max_length=1000)


class UnitDue(Frozen):
    """A unit whose issued certificate has an agreed date. unit: its number in the catalogue;
    client: in English and in Chinese; days: to the date, negative where it is overdue; messages:
    how many went out.
    """

    unit: int
    name: str
    model: str
    client: tuple[str, str]
    certificate: str
    due: date
    days: int
    messages: int


class Month(Frozen):
    """How many units fall due in a month, YYYY-MM."""

    month: str
    units: int


class ClientDue(Frozen):
    """How many units of a client are overdue, and how many more fall due within the time."""

    client: tuple[str, str]
    overdue: int
    coming: int


class MessageShown(Frozen):
    """A message to a client. days: of its occasion, after the due date; fault: of the last try."""

    certificate: str
    days: int
    channel: str
    state: MessageState
    at: datetime
    tries: int
    fault: str | None


class StandardDue(Frozen):
    """A measurement standard with the certificate that counts now."""

    serial: str
    name: Statement
    certificate: str
    valid_until: date | None
    days: int | None


class DueShown(Frozen):
    """units: overdue ones and those within the time, the longest overdue first; months: of the
    next twelve. today: from which the days count. clients, models: that there are to choose from.
    """

    today: date
    units: tuple[UnitDue, ...]
    by_client: tuple[ClientDue, ...]
    months: tuple[Month, ...]
    messages: tuple[MessageShown, ...]
    equipment: tuple[StandardDue, ...]
    clients: tuple[tuple[str, str], ...]
    models: tuple[str, ...]
