"""A stop of a station: the request, the answer of the run, and the outcome."""

from typing import Literal

from pydantic import AwareDatetime, Field

from schemas.base import Finite, Frozen
from schemas.text import Statement


class StopRequest(Frozen):
    """Somebody wants a station to stop. key: identifies this request."""

    format: Literal["mimu-stop/1"] = "mimu-stop/1"
    key: str = Field(min_length=1)
    station: str
    by: str = Field(min_length=1)
    at: AwareDatetime


class AxisReading(Frozen):
    """An axis as it was read last: angle (deg) and rate (deg/s)."""

    name: str
    angle_deg: Finite
    rate_deg_s: Finite


class StopAnswer(Frozen):
    """The answer of a run's process to the request with this key: every axis was commanded to stop.

    at_rest: null while the axes still turn and are being read.
    """

    key: str
    process: int
    at_rest: bool | None = None
    axes: tuple[AxisReading, ...] = ()


class Stopped(Frozen):
    """What came of a stop.

    at_rest: whether the table was read to be at rest. axes: as read last. way: whether the run's
    own process stopped the table, or the stop itself on a connection of its own. recordings: what
    the run had recorded. fault: why it could not be confirmed; cause: the same for the
    pages. seconds: since the button was pressed.
    """

    format: Literal["mimu-stopped/1"] = "mimu-stopped/1"
    station: str
    by: str
    at_rest: bool
    axes: tuple[AxisReading, ...] = ()
    way: Literal["run", "directly"]
    recordings: tuple[str, ...] = ()
    fault: str = ""
    cause: Statement | None = None
    seconds: Finite
