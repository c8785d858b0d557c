"""How far a run has come."""

from collections.abc import Callable
from dataclasses import dataclass

from tasks.station.clock import StationClock, wall_s

REPORT_EVERY_S = 0.1


@dataclass(frozen=True)
class Progress:
    """What happens now, planned station seconds done and in all, wall seconds left."""

    now: str
    station_s_done: float
    station_s_total: float
    wall_s_left: float


@dataclass
class Tracker:
    """Counts planned time: a segment counts for what was planned, however long it takes."""

    report: Callable[[Progress], None]
    clock: StationClock
    total_s: float
    now: str = ""
    _done_s: float = 0.0
    _planned_s: float = 0.0
    _began_s: float = 0.0
    _reported_wall_s: float = 0.0

    def add(self, planned_s: float) -> None:
        """More is to be done than was planned."""
        self.total_s += planned_s

    def begin(self, now: str, planned_s: float) -> None:
        """Something begins that is planned to take this long; what came before it is done."""
        self._done_s += self._planned_s
        self._planned_s = planned_s
        self._began_s = self.clock.station_s
        self.now = now
        self._reported_wall_s = -REPORT_EVERY_S
        self.tick()

    def tick(self) -> None:
        """Report, unless it was reported just now."""
        now_s = wall_s()
        if now_s - self._reported_wall_s < REPORT_EVERY_S:
            return
        self._reported_wall_s = now_s
        within_s = min(self.clock.station_s - self._began_s, self._planned_s)
        done_s = self._done_s + within_s
        left_s = (self.total_s - done_s) / self.clock.speed
        self.report(Progress(self.now, done_s, self.total_s, left_s))

    def end(self) -> None:
        """Everything is done."""
        self.report(Progress("done", self.total_s, self.total_s, 0.0))
