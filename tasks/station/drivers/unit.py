"""The unit under test: frames on its line, its silences and restarts."""

import numpy as np

from schemas.base import Unusable
from schemas.recording import Stream
from schemas.unit_link import AnyFrame, BinaryFrame, UnitLink
from tasks.station.clock import wall_s
from tasks.station.drivers.binary_frames import find_binary
from tasks.station.drivers.samples import FrameSearch, counter_turn, no_samples, to_stream
from tasks.station.drivers.stamps import StampSequence
from tasks.station.drivers.text_frames import find_text
from tasks.station.ports import Line

SILENCE_S = 3.0
LOOK_S = 0.5


class UnitDriver:
    """Takes samples from a line that has just been opened.

    Raises Unusable if the line breaks, carries no whole frame for SILENCE_S of wall time (a pause
    in which nobody looked counts as LOOK_S at most), or if the unit restarts its clock without
    having been switched off and on between `switched_off` and `switched_on`.
    """

    def __init__(self, link: UnitLink, line: Line) -> None:
        self.link = link
        self.arrived_s = self._looked_s = wall_s()
        self._silent_s = 0.0
        self._line = line
        self._rest = b""
        self._bytes_since = 0
        self._bad_frames = 0
        self._sequence = StampSequence(link)
        self._last_stamp = -1
        self.is_off = False
        self._may_restart = False

    @property
    def bad_frames(self) -> int:
        """Frames with a wrong check sum, and what only passed for one."""
        return self._bad_frames + self._sequence.rejected

    def end(self) -> None:
        """Read what is on the line now, and no more."""
        self._line.end()

    def switched_off(self) -> None:
        """From now on the unit may be silent, and then restart its clock once."""
        self.is_off = self._may_restart = True

    def switched_on(self) -> None:
        """From now on its silence counts again."""
        self.is_off = False
        self._silent_s = 0.0
        self.arrived_s = wall_s()

    def take(self) -> tuple[np.ndarray, np.ndarray]:
        """The samples that came since the last call: before and after its restart, if it had one.

        Records (n,) and (m,) of drivers.samples; n, m or both may be 0, and m is while it has not
        been restarted. `arrived_s` is the wall time at which the last came.
        """
        data, arrived_s = self._line.received()
        found = find_frames(self._rest + data, self.link.frame)
        self._rest = found.rest
        self._bad_frames += found.bad
        samples = self._sequence.take(found.samples, arrived_s)
        self._bytes_since = 0 if len(samples) else self._bytes_since + len(data)
        now_s = wall_s()
        self._silent_s += min(now_s - self._looked_s, LOOK_S)
        self._looked_s = now_s
        if len(samples):
            self._silent_s = 0.0
            self.arrived_s = arrived_s or self.arrived_s
            restart = self._restart_in(samples["stamp"])
            return samples[:restart], samples[restart:]
        if self._silent_s > SILENCE_S and not self.is_off:
            raise Unusable(self._silence())
        if self._line.broken:
            raise Unusable(self._line.broken)
        return no_samples(self.link.frame), no_samples(self.link.frame)

    def stream(self, samples: np.ndarray, shift_us: int = 0) -> Stream:
        """Samples over their own time stamps, moved by `shift_us`."""
        return to_stream(samples, self.link.frame, shift_us)

    def lost(self, samples: np.ndarray) -> np.ndarray:
        """Samples missing between neighbours, (n,) -> (n - 1,): by the counter, else by time."""
        if self.link.frame.has("counter"):
            return (np.diff(samples["counter"]) - 1) % counter_turn(self.link.frame)
        periods = np.rint(np.diff(samples["stamp"]) / 1e6 * self.link.rate_hz)
        return np.maximum(periods.astype(np.int64) - 1, 0)

    def _restart_in(self, stamps: np.ndarray) -> int:
        """The index in the stamps (n,) at which the unit's clock restarts; n if it does not."""
        before = np.concatenate([[self._last_stamp], stamps[:-1]])
        back = np.flatnonzero(stamps <= before)
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
        if self._bytes_since:
            return (
                f"{unit} has sent {self._bytes_since} bytes and no whole frame for "
                f"{SILENCE_S:g} s: check unit_link.frame of the station file, its baud rate and "
                f"the cable"
            )
        return f"{unit} has sent nothing for {SILENCE_S:g} s: check its supply and the cable"


def find_frames(data: bytes, frame: AnyFrame) -> FrameSearch:
    """Every whole frame in some bytes, by its description."""
    if isinstance(frame, BinaryFrame):
        return find_binary(data, frame)
    return find_text(data, frame)
