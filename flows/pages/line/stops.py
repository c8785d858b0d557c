"""Stops a station in the name of whoever pressed, and keeps what became of it."""

import logging
from datetime import UTC, datetime
from pathlib import Path

from flows.pages.do.orders import check_may
from flows.pages.line.models import Released, StopPressed, StopShown
from schemas.access import Visitor
from schemas.base import NotThere, Unusable
from storage.home import Home
from storage.station_stop import answer_in, lockout_of, release
from storage.stations import file_of
from tasks.stages.stop import stop_station
from tasks.words import cause_of

LOG = logging.getLogger("mimucal.pages.stop")

_pressed: dict[tuple[Home, str], StopShown] = {}  # by station, since the pages are served


def last_stop(station: str, home: Home) -> StopShown | None:
    """The last stop of a station: pressed here since the pages are served, or else the one that
    keeps its orders waiting, if its run answered where the table was.
    """
    lockout, pressed = lockout_of(station, home), _pressed.get((home, station))
    if lockout is None or (pressed and pressed.at > lockout.at):
        return pressed
    answer = answer_in(home.locks, lockout)
    if answer and answer.at_rest is not None:
        return StopShown(by=lockout.by, at=lockout.at, is_at_rest=answer.at_rest, fault="")
    return pressed


def press(asked: StopPressed, visitor: Visitor, home: Home) -> StopShown:
    """Stops the station; whatever fails is said in the answer, and never raised.

    Raises NotAllowed where the role does not allow it, NotThere for an unknown station.
    """
    station = asked.station
    check_may("stop", visitor, station, home)
    if Path(station).is_file():  # which at a terminal is a station file
        raise NotThere(f"there is no station {station!r}; press Stop on its card")
    is_at_rest, cause = False, None
    try:
        stopped = stop_station(station, visitor.name, home)
        is_at_rest, fault, cause = stopped.at_rest, stopped.fault, stopped.cause
    except NotThere:
        raise
    except Exception as error:  # the person must be informed that the table may still turn
        if not isinstance(error, Unusable):
            LOG.exception("station %s was not stopped", station)
        fault, cause = str(error) or type(error).__name__, cause_of(error)
    shown = StopShown(
        by=visitor.name, at=datetime.now(UTC), is_at_rest=is_at_rest, fault=fault, cause=cause
    )
    _pressed[home, station] = shown
    return shown


def let_go_on(asked: StopPressed, visitor: Visitor, home: Home) -> Released:
    """Lets the orders of a station go on that was stopped.

    Raises NotAllowed where the role does not allow it, NotThere for an unknown station, Unusable
    where it cannot be written.
    """
    check_may("stop", visitor, asked.station, home)
    if lockout_of(asked.station, home) is None:
        file_of(asked.station, home)
    release(asked.station, visitor.name, home)
    LOG.info("station %s released by %s", asked.station, visitor.name)
    return Released(station=asked.station, by=visitor.name)
