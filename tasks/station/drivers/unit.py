"""The unit under test: frames on its line, its silences and restarts."""

import numpy as np

from schemas.base import Unusable
from schemas.recording import Stream
from schemas.unit_link import AnyFrame, BinaryFrame, UnitLink
from tasks.station.clock import wall_s
from tasks.station.drivers.frames import find_binary, find_text
from tasks.station.drivers.samples import (
    FrameSearch,
    counter_turn,
    no_samples,
    stamp_turn_us,
    to_stream,
)
from tasks.station.ports import Line
from tasks.words import message

LONGEST_STEP_US = 3_000_000
STEPS = 10  # of a slow unit, that a step may be long
SILENCE_S = 3.0
LOOK_S = 0.5


class StampSequence:
    """Takes the samples found, and returns those with consistent stamps.

    A sample whose stamp does not follow the previous one counts only if the next one follows it:
    the unit was silent, or was restarted. Otherwise garbage happened to look like a frame, and
    `rejected` counts it. Stamps continue where the unit's own wrap; without a stamp in the frame
    they are those of the counter, at the rate of the link, or of arrival.
    """

    def __init__(self, link: UnitLink) -> None:
        self.rejected = 0
        self._link = link
        self._turn_us = self._turn()
        self._longest_us = max(LONGEST_STEP_US, STEPS * 1e6 / link.rate_hz)
        self._held = no_samples(link.frame)
        self._last_us: int | None = None  # as the unit tells it
        self._own_us: int | None = None  # of the last sample given
        self._before_us = 0  # what it has turned over by

    def _turn(self) -> int | None:
        if not self._link.frame.has("time") and self._link.frame.has("counter"):
            return round(counter_turn(self._link.frame) * 1e6 / self._link.rate_hz)
        return stamp_turn_us(self._link.frame)

    def take(self, samples: np.ndarray, arrived_s: float) -> np.ndarray:
        """The samples (n,) whose place is known now; the last may be kept for the next call."""
        self._stamp(samples, arrived_s)
        waiting = np.concatenate([self._held, samples])
        kept = self._following(waiting)
        self._run_on(kept)
        return kept

    def _stamp(self, samples: np.ndarray, arrived_s: float) -> None:
        """Stamps for frames that have none. Those that came together are a period apart."""
        period_us = 1e6 / self._link.rate_hz
        if self._link.frame.has("time"):
            return
        if self._link.frame.has("counter"):
            samples["stamp"] = np.rint(samples["counter"] * period_us)
            return
        back = np.arange(len(samples) - 1, -1, -1)
        samples["stamp"] = np.rint(arrived_s * 1e6 - back * period_us)
        if self._last_us is not None and len(samples):
            late_us = self._last_us + 1 - int(samples["stamp"][0])
            samples["stamp"] += max(late_us, 0)

    def _following(self, waiting: np.ndarray) -> np.ndarray:
        stamps = waiting["stamp"]
        if self._last_us is not None:
            before = np.concatenate([[self._last_us], stamps[:-1]])
            if self._follows(before, stamps).all():
                self._held = waiting[:0]
                self._last_us = int(stamps[-1]) if len(stamps) else self._last_us
                return waiting.copy()
        return self._sound(waiting)

    def _sound(self, waiting: np.ndarray) -> np.ndarray:
        """The consistent samples, in order; the last is held back if the next one must decide."""
        stamps, kept, last_us = waiting["stamp"].tolist(), [], self._last_us
        self._held = waiting[:0]
        for place, stamp in enumerate(stamps):
            follows = self._comes_after(last_us, stamp)
            if not follows and place + 1 == len(stamps):
                self._held = waiting[place:]
            elif follows or self._is_borne_out(last_us, stamp, stamps[place + 1]):
                kept.append(place)
                last_us = stamp
            else:
                self.rejected += 1
        self._last_us = last_us
        return waiting[kept]

    def _is_borne_out(self, last_us: int | None, stamp: int, following: int) -> bool:
        """Whether the sample behind it follows it, and not the one before it."""
        return self._comes_after(stamp, following) and not self._comes_after(last_us, following)

    def _comes_after(self, last_us: int | None, stamp: int) -> bool:
        return last_us is not None and bool(self._follows(last_us, stamp))

    def _follows(self, before: np.ndarray | int, stamps: np.ndarray | int) -> np.ndarray:
        steps = np.asarray(stamps) - np.asarray(before)
        if self._turn_us is not None:
            steps = steps % self._turn_us
        return np.asarray((steps > 0) & (steps <= self._longest_us))

    def _run_on(self, samples: np.ndarray) -> None:
        """Adds the wraps of the stamps; a restart is none."""
        if self._turn_us is None or not len(samples):
            return
        own = samples["stamp"].copy()
        before = np.concatenate([[self._own_us if self._own_us is not None else own[0]], own])
        turns = (np.diff(before) < 0) & self._follows(before[:-1], before[1:])
        samples["stamp"] += self._before_us + np.cumsum(turns) * self._turn_us
        self._before_us += int(turns.sum()) * self._turn_us
        self._own_us = int(own[-1])


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
            raise self._silent()
        if self._line.broken:
            raise Unusable(self._line.broken, message("station-cause.line", unit=self.link.url))
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
                f"start again",
                message("station-cause.unit-restarted", unit=self.link.url),
            )
        self._may_restart = False
        return int(back[0])

    def _silent(self) -> Unusable:
        kind, what, look = "nothing-sent", "nothing", "its supply"
        if self._bytes_since:
            kind, what = "no-frame", f"{self._bytes_since} bytes and no whole frame"
            look = "unit_link.frame of the station file, its baud rate"
        seconds = f"{SILENCE_S:g}"
        return Unusable(
            f"the unit on {self.link.url} has sent {what} for {seconds} s: check {look} and the "
            f"cable",
            message(f"station-cause.{kind}", unit=self.link.url, seconds=seconds),
        )


def find_frames(data: bytes, frame: AnyFrame) -> FrameSearch:
    """Every whole frame in some bytes, by its description."""
    if isinstance(frame, BinaryFrame):
        return find_binary(data, frame)
    return find_text(data, frame)
