"""The stations at this moment, today's output, and the queue."""

from datetime import date

from pydantic import AwareDatetime

from schemas.base import Frozen
from schemas.run_log import RunStatus


class LineQuestion(Frozen):
    """All of the line."""


class StationNow(Frozen):
    """The last run of a station. is_dead: its process ended without a word."""

    status: RunStatus
    is_dead: bool


class Output(Frozen):
    """What a day made, in UTC: runs taken in, by the verdict on them and on their units.

    not_judged: runs without a result. issued: certificates that were issued on that day.
    """

    day: date
    runs: int
    by_station: dict[str, int]
    valid: int
    remarks: int
    invalid: int
    not_judged: int
    passed: int
    failed: int
    issued: int


class Queued(Frozen):
    """A flow run that Prefect holds: its name, its state and when it is expected to start."""

    name: str
    state: str
    expected_at: AwareDatetime | None


class Queue(Frozen):
    """What waits or runs on the Prefect server.

    server: whether one is named (PREFECT_API_URL). fault: why it did not answer.
    """

    server: bool
    fault: str | None = None
    waiting: tuple[Queued, ...] = ()


class LineNow(Frozen):
    """What each station does, what today made, and what waits."""

    stations: tuple[StationNow, ...]
    today: Output
    queue: Queue
