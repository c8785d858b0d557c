"""Stops a station in the name of whoever pressed, and keeps what became of it."""

import logging
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from threading import Lock

from flows.pages.do.orders import check_may
from flows.pages.line import alarms
from flows.pages.line.models import Acknowledged, LineQuestion, Released, StopShown
from schemas.access import Visitor
from schemas.base import NotThere, Unusable
from storage.home import Home
from storage.station_stop import answer_in, lockout_of, release
from storage.stations import file_of
from tasks.stages.stop import stop_station

LOG = logging.getLogger("mimucal.pages.stop")


class Stops:
    """The last stop of each station that was pressed on these pages."""

    def __init__(self, home: Home) -> None:
        self._home = home
        self._last: dict[str, StopShown] = {}
        self._one_at_a_time = Lock()

    def last(self, station: str) -> StopShown | None:
        """The last one of a station: pressed here since the pages are served, or else the one
        that keeps its orders waiting, if its run answered where the table was.
        """
        lockout, pressed = lockout_of(station, self._home), self._last.get(station)
        if lockout is None or (pressed and pressed.at > lockout.at):
            return pressed
        answer = answer_in(self._home.locks, lockout)
        if answer and answer.at_rest is not None:
            return StopShown(by=lockout.by, at=lockout.at, is_at_rest=answer.at_rest, fault="")
        return pressed

    def press(self, station: str, visitor: Visitor) -> StopShown:
        """Stops the station; whatever fails is said in the answer, and never raised.

        Raises Unusable where the role does not allow it, NotThere for an unknown station.
        """
        check_may("stop", visitor, station, self._home)
        shown = self._stopped(station, visitor.name)
        with self._one_at_a_time:
            self._last[station] = shown
        return shown

    def release(self, station: str, visitor: Visitor) -> Released:
        """Lets the orders of a station go on that was stopped.

        Raises Unusable where the role does not allow it, or it cannot be written, NotThere for an
        unknown station.
        """
        check_may("stop", visitor, station, self._home)
        if lockout_of(station, self._home) is None:
            file_of(station, self._home)
        release(station, visitor.name, self._home)
        LOG.info("station %s released by %s", station, visitor.name)
        return Released(station=station, by=visitor.name)

    def acknowledge(self, key: str, visitor: Visitor) -> Acknowledged:
        """A person saw to an alarm that stands.

        Raises Unusable where the role does not allow it, and where the alarm is over.
        """
        check_may("stop", visitor, key, self._home)
        # late: the data of the page show what was pressed here
        from flows.pages.line.data import data

        for alarm in data(LineQuestion(), self._home).alarms:
            if alarm.key == key:
                return alarms.acknowledge(alarm, visitor.name, self._home)
        raise NotThere(f"there is no alarm {key} any more; look at the page again")

    def _stopped(self, station: str, by: str) -> StopShown:
        try:
            if Path(station).is_file():  # which at a terminal is a station file
                raise NotThere(f"there is no station {station!r}; press Stop on its card")
            stopped = stop_station(station, by, self._home)
        except NotThere:
            raise
        except Exception as error:  # the person must be informed that the table may still turn
            if not isinstance(error, Unusable):
                LOG.exception("station %s was not stopped", station)
            fault = str(error) or type(error).__name__
            return StopShown(by=by, at=datetime.now(UTC), is_at_rest=False, fault=fault)
        return StopShown(
            by=by, at=datetime.now(UTC), is_at_rest=stopped.at_rest, fault=stopped.fault
        )


@cache
def stops_of(home: Home) -> Stops:
    """The stops pressed on the pages of a home in this process."""
    return Stops(home)
