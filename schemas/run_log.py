"""The log of a run, as kept in its manifest (`log`) and in its status."""

from collections.abc import Mapping
from typing import Literal

from pydantic import AwareDatetime

from schemas.base import Finite, Frozen
from schemas.text import Statement

State = Literal[
    "begun", "warming_up", "measuring", "repeating", "paused", "turning_over", "finishing",
    "done", "stopped",
]  # fmt: skip
ENDED: tuple[State, ...] = ("done", "stopped")


class LogEntry(Statement):
    """A change of a run's state, or an anomaly, with its cause as a sentence.

    at: UTC. t: s, on the time base of the recording's segments.
    """

    at: AwareDatetime
    t: Finite
    state: State


class Alarm(Statement):
    """An anomaly of a run, as a sentence with the number of its occurrences.

    code: the kind of anomaly, a message `station-alarm-…` of the catalogues, or `given_up`. at:
    when it was noticed last. Both are empty in a status that an earlier version wrote.
    """

    code: str = ""
    at: AwareDatetime | None = None


class RunStatus(Frozen):
    """The status of a run when its process last wrote it.

    units: serial numbers. at: time of writing. segment of segments: the one being measured.
    rates_hz: rows of each stream per second of station time. noise: standard deviation of single
    samples, deg/s and m/s². cause: why it stopped;
    shown_cause: the same for the pages, null from an earlier version. recordings: raw files being
    written. lock: the computer and the folder in which the run holds its station.
    """

    format: Literal["mimu-status/1"] = "mimu-status/1"
    station: str
    procedure: str
    units: tuple[str, ...] = ()
    process: int
    began_at: AwareDatetime
    at: AwareDatetime
    state: State
    now: str
    segment: int
    segments: int
    station_s_done: Finite
    station_s_total: Finite
    wall_s_left: Finite
    rates_hz: Mapping[str, Finite] = {}
    noise: Mapping[str, Finite] = {}
    alarms: tuple[Alarm, ...] = ()
    cause: str = ""
    shown_cause: Statement | None = None
    recordings: tuple[str, ...] = ()
    lock: str = ""
