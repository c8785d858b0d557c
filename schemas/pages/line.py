"""The stations as they are now."""

from schemas.base import Frozen
from schemas.run_log import RunStatus


class LineQuestion(Frozen):
    """All of the line."""


class StationNow(Frozen):
    """The last run of a station. is_dead: its process ended without a word."""

    status: RunStatus
    is_dead: bool


class LineNow(Frozen):
    """What each station does."""

    stations: tuple[StationNow, ...]
