"""The log of a run: every change of its state and the first of each kind of anomaly."""

from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime

from schemas.run_log import LogEntry, State
from schemas.text import Statement
from tasks.station.anomalies import Anomaly
from tasks.station.clock import StationClock
from tasks.words import Message, message, statement, texts

REPEATED = "segment_repeated"  # a change of state, and no anomaly of its own


class RunLog:
    """What a run goes through, with time and cause; `state` is the present one.

    origin_s: station time (s) from which the recording counts.
    """

    def __init__(self, clock: StationClock, origin_s: float) -> None:
        self.entries: list[LogEntry] = []
        self.state: State = "begun"
        self._clock = clock
        self._origin_s = origin_s
        self._noticed: Counter[tuple[str, str]] = Counter()
        self._seen = 0

    def enter(self, state: State, cause: Message) -> None:
        """The run enters a state."""
        self.state = state
        self._note(cause)

    def notice(self, anomalies: Sequence[Anomaly]) -> None:
        """Count what came since; the first of each code and subject is an entry."""
        new, self._seen = anomalies[self._seen :], len(anomalies)
        for anomaly in new:
            kind = (anomaly.code, anomaly.subject)
            if anomaly.code != REPEATED and kind not in self._noticed:
                self._note(message("station-log-alarm", alarm=_alarm(*kind)))
            self._noticed[kind] += 1

    @property
    def alarms(self) -> tuple[Statement, ...]:
        """What was noticed so far, and how often."""
        return tuple(
            statement(message("station-log-times", alarm=_alarm(code, subject), count=count))
            for (code, subject), count in self._noticed.items()
            if code != REPEATED
        )

    def _note(self, cause: Message) -> None:
        t = round(self._clock.station_s - self._origin_s, 3)
        at = datetime.now(UTC)
        self.entries.append(LogEntry(at=at, t=t, state=self.state, **texts(cause)))


def _alarm(code: str, subject: str) -> Message:
    return message(f"station-alarm-{code.replace('_', '-')}", subject=subject)
