"""One unit of a run: its data go to its sink at once and are checked on the way."""

import logging
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Protocol

import numpy as np

from schemas.base import Unusable
from schemas.recording import ACCEL, ANGLE, GYRO, Manifest, Segment, Stream, joined
from schemas.run_log import Alarm, LogEntry, State
from schemas.text import Remark, Statement
from tasks.station.anomalies import FAILURES, Anomaly, touches
from tasks.station.clock import StationClock
from tasks.station.drivers.unit import UnitDriver
from tasks.station.monitor import SegmentMonitor
from tasks.station.run_manifest import ManifestBuilder
from tasks.station.stream_readers import UnitReader
from tasks.words import Message, cause_of, message, worded

ROWS = 400  # the last ones, of which the figures are
MOST_OF = {"gyro": (GYRO, 180.0 / np.pi), "accel": (ACCEL, 1.0)}
DEVICES = {"encoder": "encoders", "table": "table", "air": "chamber"}  # by the codes' beginning
REPEATED = "segment_repeated"  # a change of state, and no anomaly of its own


@dataclass
class LastRows:
    """The last ROWS of each stream."""

    streams: dict[str, Stream] = field(default_factory=dict)

    def add(self, name: str, stream: Stream) -> None:
        """Take in what came next of a stream."""
        if len(stream):
            parts = [self.streams[name], stream] if name in self.streams else [stream]
            if parts[0].columns.keys() != stream.columns.keys():
                parts = [stream]
            self.streams[name] = joined(parts).at(slice(-ROWS, None))

    @property
    def rates_hz(self) -> Mapping[str, float]:
        """Rows of each stream in a second of its time."""
        return {
            name: (len(stream) - 1) / float(stream.t[-1] - stream.t[0])
            for name, stream in self.streams.items()
            if len(stream) > 1
        }

    @property
    def noise(self) -> Mapping[str, float]:
        """Standard deviation of a sample of the noisiest gyro (deg/s) and accelerometer (m/s²).

        From the differences of samples that follow each other, in which a motion does not count.
        """
        imu = self.streams.get("imu")
        if imu is None or len(imu) < 3:
            return {}
        rates = dict(imu.columns)
        for angle, gyro in zip(ANGLE, GYRO, strict=True):
            if angle in imu.columns:
                rates[gyro] = np.gradient(imu.columns[angle], imu.t)
        found = {}
        for name, (channels, scale) in MOST_OF.items():
            known = [rates[channel] for channel in channels if channel in rates]
            if known:
                steps = np.diff(np.stack(known), axis=1)
                found[name] = scale * float(steps.std(axis=1).max()) / np.sqrt(2.0)
        return {name: value for name, value in found.items() if np.isfinite(value)}


class RunLog:
    """What a run goes through, with time and cause; `state` is the present one.

    All of it are events of the run, too, and what was noticed of the device concerned. unit: its
    serial number. origin_s: station time (s) from which the recording counts.
    """

    def __init__(self, unit: str, clock: StationClock, origin_s: float) -> None:
        self.entries: list[LogEntry] = []
        self.state: State = "begun"
        self._unit = unit
        self._clock = clock
        self._origin_s = origin_s
        self._noticed: Counter[tuple[str, str]] = Counter()
        self._noticed_at: dict[tuple[str, str], datetime] = {}
        self._seen = 0

    def enter(self, state: State, cause: Message) -> None:
        """The run enters a state."""
        self.state = state
        self._note(cause)
        logging.getLogger("mimucal.station.run").info(state, extra={"of": self._unit})

    def notice(self, anomalies: Sequence[Anomaly]) -> None:
        """Count what came since; the first of each code and subject is an entry."""
        new, self._seen = anomalies[self._seen :], len(anomalies)
        for anomaly in new:
            kind = (anomaly.code, anomaly.subject)
            if is_first := anomaly.code != REPEATED and kind not in self._noticed:
                self._note(message("station-log-alarm", alarm=_alarm(*kind)))
            device = DEVICES.get(anomaly.code.partition("_")[0], "unit")
            logging.getLogger(f"mimucal.station.{device}").log(
                logging.WARNING if is_first else logging.DEBUG,
                anomaly.code,
                extra={"of": self._unit, "subject": anomaly.subject, "amount": anomaly.amount},
            )
            self._noticed[kind] += 1
            self._noticed_at[kind] = datetime.now(UTC)

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """What was noticed so far, how often, and when last."""
        return tuple(
            Alarm(
                code=code, at=self._noticed_at[code, subject],
                **worded(message("station-log-times", alarm=_alarm(code, subject), count=count)),
            )
            for (code, subject), count in self._noticed.items()
            if code != REPEATED
        )  # fmt: skip

    def _note(self, cause: Message) -> None:
        t = round(self._clock.station_s - self._origin_s, 3)
        at = datetime.now(UTC)
        self.entries.append(LogEntry(at=at, t=t, state=self.state, **worded(cause)))


class Sink(Protocol):
    """Where a recording is written during the run; what a call passes is soon on disk."""

    def append(self, name: str, stream: Stream, /) -> object: ...

    def manifest(self, manifest: Manifest, /) -> object: ...


class UnitRecorder:
    """The recording of one unit, with the table and the air of the run in it.

    given_up: why nothing more of it is recorded, as a sentence; cause: the same for the
    pages.
    """

    def __init__(
        self, driver: UnitDriver, clock: StationClock, sink: Sink, manifest: ManifestBuilder
    ) -> None:
        self.anomalies: list[Anomaly] = []
        self.given_up: str | None = None
        self.cause: Statement | None = None
        self.manifest = manifest
        self.driver = driver
        self.unit = UnitReader(driver, clock, self.anomalies.append)
        self.monitor = SegmentMonitor(driver.link)
        self.last_rows = LastRows()
        self.log = RunLog(manifest.serial, clock, manifest.origin_s)
        self.log.entries += map(LogEntry.model_validate, manifest.extra.get("log", ()))
        self._sink = sink

    @property
    def serial(self) -> str:
        return self.manifest.serial

    def write(
        self, table: Stream, environment: Stream, final: bool, time_half_width_s: float
    ) -> None:
        """Write what has come. The unit is last: its silence must not cost the other streams.

        time_half_width_s: by how much an encoder sample's time may be wrong.
        """
        self._write("table", table)
        self._write("environment", environment)
        imu = self.unit.take(final)
        self._write("imu", imu)
        self.anomalies += self.monitor.run(imu, table, time_half_width_s)
        self.log.notice(self.anomalies)

    def _write(self, name: str, stream: Stream) -> None:
        if len(stream):
            self._sink.append(name, self.manifest.since_start(stream))
            self.last_rows.add(name, stream)

    def give_up(self, fault: Unusable) -> None:
        """Record no more of it: it has failed, and its neighbours go on."""
        self.given_up, self.cause = str(fault), cause_of(fault)
        self.driver.end()
        fields = {"of": self.serial, "cause": self.given_up}
        logging.getLogger("mimucal.station.unit").error("given up", extra=fields)
        self.log.enter("stopped", message("station-log-given-up", cause=self.cause))

    def finish(self, segment: Segment, spin_axis: str | None) -> None:
        """A measured segment is over: label it, and check it when its data are there.

        Where the unit has it already, and a neighbour needed it again, it is no more than time.
        """
        if any(each.name == segment.name for each in self.manifest.segments):
            self.manifest.fill("neighbour", "transition", segment.t_end)
            return
        self.manifest.add(segment)
        self.monitor.add(segment, spin_axis)

    def failed(self) -> list[str]:
        """Measured segments whose data are there and not sound."""
        doubts = [anomaly for anomaly in self.anomalies if anomaly.code in FAILURES]
        return [each.name for each in self.manifest.segments if touches(each, doubts)]

    def withdraw(self, name: str) -> None:
        """A measured segment is to be repeated: its data stay, and its label goes."""
        segment = self.manifest.withdraw(name)
        self.anomalies.append(
            Anomaly("segment_repeated", segment.t_start, segment.t_end, subject=name)
        )

    def remember(self, noticed: tuple[Remark, ...]) -> None:
        """Have the manifest say what was noticed, behind what an interrupted run noticed."""
        before = self.manifest.extra.get("station_remarks", [])
        dumped = [remark.model_dump(mode="json") for remark in noticed]
        self.manifest.extra["station_remarks"] = [*before, *dumped]

    def write_manifest(self, time_half_width_s: float) -> None:
        """Write the manifest with the segments finished so far.

        time_half_width_s: by how much an encoder sample's time may be wrong.
        """
        extra = self.manifest.extra
        first_s, *again_s = self.unit.clock_shifts_s
        if first_s:
            extra["unit_clock_shift_s"] = first_s
        if again_s:
            since_start = [round(shift_s - self.manifest.origin_s, 6) for shift_s in again_s]
            extra["unit_power_on_s"] = since_start
        if time_half_width_s:
            self.manifest.polled_within(time_half_width_s)
        extra["log"] = [each.model_dump(mode="json") for each in self.log.entries]
        if comparison := self.unit.compared():
            extra["unit_clock"] = comparison.model_dump()
        self._sink.manifest(self.manifest.build())


def _alarm(code: str, subject: str) -> Message:
    return message(f"station-alarm-{code.replace('_', '-')}", subject=subject)
