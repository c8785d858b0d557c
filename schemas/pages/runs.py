"""The runs of the store."""

from datetime import date, datetime

from pydantic import Field

from schemas.base import Frozen

AT_ONCE = 100
MOST_AT_ONCE = 1000


class RunsQuestion(Frozen):
    """Which rows of the list: `count` of them after the first `start`."""

    start: int = Field(default=0, ge=0, le=2**31)
    count: int = Field(default=AT_ONCE, ge=0, le=MOST_AT_ONCE)


class RunLine(Frozen):
    """A run as the list shows it."""

    id: str
    manufacturer: str
    model: str
    serial: str
    station: str | None
    procedure: str | None
    standard: str
    recorded_on: date | None
    taken_in_at: datetime
    seconds: float


class RunsShown(Frozen):
    """Rows of the list, the newest first, and how many there are in all."""

    total: int
    runs: tuple[RunLine, ...]
