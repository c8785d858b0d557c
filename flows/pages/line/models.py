"""The stations at this moment, alarms, what waits, and today's output."""

from datetime import date
from typing import Literal

from pydantic import AwareDatetime, Field

from schemas.base import Frozen
from schemas.run_log import RunStatus, State
from schemas.stop import StopRequest
from schemas.text import Statement

# Beside the states of a run. free: nothing runs there, as before the first run and after one that
# is done; lost: its process ended without a word; silent: nothing was heard of it for too long.
StationState = State | Literal["free", "lost", "silent"]
Waits = Literal["waiting", "running"]


class LineQuestion(Frozen):
    """All of the line."""


class AlarmShown(Frozen):
    """Something that a person must see to. station: empty where it is none of a station's; about:
    the unit, certificate or flow run; at: null where nobody knows when. key: identifies the alarm,
    as long as it stands. acknowledged: by whom and when; null while nobody did.
    """

    key: str

    at: AwareDatetime | None
    station: str
    about: str
    cause: Statement
    todo: Statement
    acknowledged: "Acknowledged | None" = None


class Acknowledged(Frozen):
    """A person saw to an alarm."""

    by: str
    at: AwareDatetime


class AlarmPressed(Frozen):
    """Whoever is logged in acknowledges an alarm, by its key."""

    alarm: str = Field(pattern="^[0-9a-f]{16}$")


class StopPressed(Frozen):
    """Whoever is logged in wants a station, by its id, to stop."""

    station: str = Field(min_length=1, max_length=200)


class Released(Frozen):
    """The orders of a station go on, as somebody wants who saw that it may turn."""

    station: str
    by: str


class StopShown(Frozen):
    """The last stop that was pressed for a station, and what became of it.

    is_at_rest: whether the table was read to stand still. fault: why that is not
    known; cause: the same as the page shows it.
    """

    by: str
    at: AwareDatetime
    is_at_rest: bool
    fault: str
    cause: Statement | None = None


class Queued(Frozen):
    """A production order that waits or runs. client: as the order names it. hindrance: what keeps
    one that waits from beginning.
    """

    number: str
    station: str
    serials: tuple[str, ...]
    procedure: str
    client: str
    state: Waits
    since: AwareDatetime
    hindrance: Statement | None = None


class StationNow(Frozen):
    """A station: its state, its last run (null before the first), and what waits for it.

    alarm: the last one of that run. lockout: the stop after which nobody has released it yet.
    """

    station: str
    state: StationState
    run: RunStatus | None
    alarm: AlarmShown | None
    stopped: StopShown | None
    lockout: StopRequest | None
    waiting: tuple[Queued, ...]


class Output(Frozen):
    """What a local day made: runs imported, by the verdict on them and on their units.

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


class FlowRun(Frozen):
    """A run on the Prefect server that is no production order, and what it is about."""

    flow: str
    deployment: str
    subject: str
    state: str
    is_late: bool
    expected_at: AwareDatetime | None
    pool: str


class Flows(Frozen):
    """The runs that the Prefect server holds, the next one of each deployment.

    server: whether one is named (PREFECT_API_URL). fault: why it did not answer.
    """

    server: bool
    fault: str | None = None
    runs: tuple[FlowRun, ...] = ()


class LineNow(Frozen):
    """What each station does, what is to be seen to, what waits, and what today made.

    orders: that wait for or run on any station, in their order. catalogue: why orders and today's
    output are not known (null); the stations are known all the same.
    """

    stations: tuple[StationNow, ...]
    alarms: tuple[AlarmShown, ...]
    orders: tuple[Queued, ...]
    flows: Flows
    today: Output | None
    catalogue: str | None = None
