"""Progress and state of a run."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from schemas.recording import Alarm, State
from tasks.station.clock import StationClock, wall_s
from tasks.station.recorder import Recorder
from tasks.words import message

REPORT_EVERY_S = 0.1


@dataclass(frozen=True)
class Progress:
    """What happens now, planned station seconds done and in all, wall seconds left.

    segment of segments: which is being measured. rates_hz, noise: of the streams, as LastRows
    has them. alarms: what was noticed, and how often.
    """

    now: str
    station_s_done: float
    station_s_total: float
    wall_s_left: float
    state: State = "begun"
    segment: int = 0
    segments: int = 0
    rates_hz: Mapping[str, float] = field(default_factory=dict)
    noise: Mapping[str, float] = field(default_factory=dict)
    alarms: tuple[Alarm, ...] = ()


@dataclass
class Tracker:
    """Counts planned time: a segment counts for what was planned, however long it takes.

    Every state goes to the recorder's log.
    """

    report: Callable[[Progress], None]
    clock: StationClock
    recorder: Recorder
    total_s: float
    segments: int
    segment: int = 0
    now: str = ""
    _done_s: float = 0.0
    _planned_s: float = 0.0
    _began_s: float = 0.0
    _reported_wall_s: float = 0.0

    def add(self, planned_s: float) -> None:
        """A segment more is to be measured than was planned."""
        self.total_s += planned_s
        self.segments += 1

    def begin(self, state: State, now: str, planned_s: float) -> None:
        """Something begins that is planned to take this long; what came before it is done."""
        self._done_s += self._planned_s
        self._planned_s = planned_s
        self._began_s = self.clock.station_s
        self.segment += state in ("measuring", "repeating")
        self.enter(state, now)

    def enter(self, state: State, now: str) -> None:
        """The run enters a state within what was begun."""
        self.now = now
        cause = message(
            f"station-log-{state.replace('_', '-')}",
            now=now, number=self.segment, count=self.segments,
        )  # fmt: skip
        self.recorder.enter(state, cause)
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
        self._report(done_s, (self.total_s - done_s) / self.clock.speed)

    def end(self) -> None:
        """Everything is done."""
        self.enter("done", "done")
        self._report(self.total_s, 0.0)

    def _report(self, done_s: float, left_s: float) -> None:
        recorder = self.recorder
        self.report(
            Progress(
                now=self.now,
                station_s_done=done_s,
                station_s_total=self.total_s,
                wall_s_left=left_s,
                state=recorder.state,
                segment=self.segment,
                segments=self.segments,
                rates_hz=recorder.rates_hz,
                noise=recorder.noise,
                alarms=recorder.alarms,
            )
        )
