"""The unit under test: the frames in what its line brings, its silences and restarts."""

import numpy as np

from schemas.base import Unusable
from schemas.station import FRAMES, AnyLink
from tasks.station.clock import wall_s
from tasks.station.drivers.frames import RECORDS, find_frames
from tasks.station.ports import Line

SILENCE_S = 3.0
LOOK_S = 0.5


class UnitDriver:
    """Takes frames from a line; made when the line has just been opened.

    Raises Unusable where the line breaks, carries no whole frame for SILENCE_S of wall time (a
    pause in which nobody looked counts as LOOK_S at most), or where the unit starts its clock anew
    without having been switched off and on between `switched_off` and `switched_on`.
    """

    def __init__(self, link: AnyLink, line: Line) -> None:
        self.link = link
        self.bad_frames = 0
        self.arrived_s = self._looked_s = wall_s()
        self._silent_s = 0.0
        self._line = line
        self._rest = b""
        self._bytes_since = 0
        self._last_stamp = -1
        self.is_off = False
        self._may_restart = False
        self._other_kind: str | None = None

    def end(self) -> None:
        """Read what is on the line now, and no more."""
        self._line.end()

    def switched_off(self) -> None:
        """From now on it may be silent, and then start its clock anew, once."""
        self.is_off = self._may_restart = True

    def switched_on(self) -> None:
        """From now on its silence counts again."""
        self.is_off = False
        self._silent_s = 0.0
        self.arrived_s = wall_s()

    def take(self) -> tuple[np.ndarray, np.ndarray]:
        """The frames that came since the last call: before and after its restart, if it had one.

        Records (n,) and (m,) of the unit's frame; n, m or both may be 0, and m is while it has not
        been restarted. `arrived_s` is the wall time at which the last came.
        """
        data, arrived_s = self._line.received()
        found = find_frames(self._rest + data, self.link.frame)
        if data and not len(found.frames):
            for kind in FRAMES:
                if len(find_frames(self._rest + data, kind).frames):
                    self._other_kind = kind
        self._rest = found.rest
        self.bad_frames += found.bad
        self._bytes_since = 0 if len(found.frames) else self._bytes_since + len(data)
        now_s = wall_s()
        self._silent_s += min(now_s - self._looked_s, LOOK_S)
        self._looked_s = now_s
        if len(found.frames):
            self._silent_s = 0.0
            self.arrived_s = arrived_s
            restart = self._restart_in(found.frames["stamp"])
            return found.frames[:restart], found.frames[restart:]
        if self._silent_s > SILENCE_S and not self.is_off:
            raise Unusable(self._silence())
        if self._line.broken:
            raise Unusable(self._line.broken)
        return np.empty(0, RECORDS[self.link.frame]), np.empty(0, RECORDS[self.link.frame])

    def _restart_in(self, stamps: np.ndarray) -> int:
        """Where in the stamps (n,) the unit's clock starts anew; n where it does not."""
        before = np.concatenate([[self._last_stamp], stamps[:-1].astype(np.int64)])
        back = np.flatnonzero(stamps.astype(np.int64) <= before)
        self._last_stamp = int(stamps[-1])
        if not len(back):
            return len(stamps)
        if not self._may_restart or len(back) > 1:
            raise Unusable(
                f"the unit's time stamp went back from {before[back[-1]] / 1e6:.6f} s to "
                f"{stamps[back[-1]] / 1e6:.6f} s, as after a restart: check its supply and "
                f"start again"
            )
        self._may_restart = False
        return int(back[0])

    def _silence(self) -> str:
        unit = f"the unit on {self.link.url}"
        if self._other_kind:
            return (
                f"{unit} sends frames of {self._other_kind} where unit_link.frame of the station "
                f"file says {self.link.frame}: correct the station file, or set the unit to send "
                f"{self.link.frame}"
            )
        if self._bytes_since:
            return (
                f"{unit} has sent {self._bytes_since} bytes and no whole frame for "
                f"{SILENCE_S:g} s: check its frame layout, its baud rate and the cable"
            )
        return f"{unit} has sent nothing for {SILENCE_S:g} s: check its supply and the cable"
