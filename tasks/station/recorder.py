"""Writes the streams of a run as they arrive: each unit's own, and table and air to all."""

import asyncio
import logging
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Literal, Protocol

import numpy as np

from schemas.base import Unusable
from schemas.procedure import EnvironmentLimits, Refix
from schemas.recording import (
    ACCEL,
    ANGLE,
    GYRO,
    Alarm,
    LogEntry,
    Manifest,
    Segment,
    State,
    Stream,
    joined,
)
from schemas.text import Remark, Statement
from tasks.station.clock import StationClock
from tasks.station.connected_station import Bench
from tasks.station.drivers.unit import UnitDriver
from tasks.station.monitor import FAILURES, Anomaly, SegmentMonitor, touches
from tasks.station.run_manifest import ManifestBuilder
from tasks.station.stream_readers import ClimateReader, EncoderReader, UnitReader
from tasks.words import Message, cause_of, message, worded

# One unit of a run: its data go to its sink at once and are checked on the way.

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
                code=code,
                at=self._noticed_at[code, subject],
                **worded(message("station-log-times", alarm=_alarm(code, subject), count=count)),
            )
            for (code, subject), count in self._noticed.items()
            if code != REPEATED
        )

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

    def abandon(self, fault: Unusable) -> None:
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


FLUSH_S = 0.2  # wall time: what a kill may lose
MOST_REPEATED = 12
GIVEN_UP = "given_up"  # the code of the alarm that a unit is no longer recorded


class Recorder:
    """The recordings of a run's units, written every FLUSH_S of wall time.

    A unit that fails is given up as long as another is sound; the last one's failure is the run's.
    """

    def __init__(
        self,
        bench: Bench,
        clock: StationClock,
        limits: EnvironmentLimits,
        units: Sequence[UnitRecorder],
    ) -> None:
        self.units = tuple(units)
        self.encoders = EncoderReader(bench.table, clock, self.note)
        self.climate = ClimateReader(bench.chamber, clock, limits, self.note)

    @property
    def sound(self) -> tuple[UnitRecorder, ...]:
        """The units that are still recorded."""
        return tuple(unit for unit in self.units if unit.given_up is None)

    def note(self, anomaly: Anomaly) -> None:
        """Something about the table or the air, which every unit shares."""
        for unit in self.sound:
            unit.anomalies.append(anomaly)

    async def run(self) -> None:
        """Flush for ever."""
        while True:
            await asyncio.sleep(FLUSH_S)
            self.flush()

    def flush(self, final: bool = False) -> None:
        """Write what has come. Raises Unusable where no unit is left."""
        table, environment = self.encoders.take(), self.climate.take()
        half_width_s = self.encoders.table.time_half_width_s
        faults: list[tuple[UnitRecorder, Unusable]] = []
        for unit in self.sound:
            try:
                unit.write(table, environment, final, half_width_s)
            except Unusable as fault:
                faults.append((unit, fault))
        if faults and len(faults) == len(self.sound):
            raise faults[-1][1]
        for unit, its_fault in faults:
            unit.abandon(its_fault)
            unit.write_manifest(half_width_s)

    @property
    def t_end(self) -> float:
        """The station time (s) up to which the run is labelled."""
        return self.sound[0].manifest.segments[-1].t_end

    @property
    def reached_s(self) -> float:
        """The station time (s) up to which the table's data and every unit's have come."""
        return min(unit.monitor.reached_s for unit in self.sound)

    def fill(self, name: str, kind: Literal["settle", "transition"], t_end: float) -> None:
        """Label what lies between the last segment and a time (s)."""
        for unit in self.sound:
            unit.manifest.fill(name, kind, t_end)

    def finish(self, segment: Segment, spin_axis: str | None) -> None:
        """A measured segment is over."""
        for unit in self.sound:
            unit.finish(segment, spin_axis)
        self.write_manifests()

    def failed(self, among: Collection[str]) -> dict[str, list[UnitRecorder]]:
        """Which of some segments are to be repeated, and for which units.

        Where more than MOST_REPEATED of a unit fail, the bench or the unit itself does.
        """
        found: dict[str, list[UnitRecorder]] = {}
        for unit in self.sound:
            names = [name for name in unit.failed() if name in among]
            for name in names if len(names) <= MOST_REPEATED else ():
                found.setdefault(name, []).append(unit)
        return found

    def withdraw(self, name: str, units: Iterable[UnitRecorder]) -> None:
        """A measured segment is to be repeated for some units."""
        for unit in units:
            unit.withdraw(name)
        self.write_manifests()

    def turned_over(self, refix: Refix | None) -> None:
        """The units' attitude in their fixture, not known while it is turned."""
        for unit in self.sound:
            unit.manifest.turned_over(refix)

    def switched_off(self) -> None:
        """The units are to be switched off: they may be silent now."""
        for unit in self.sound:
            unit.unit.switched_off()

    def switched_on(self, station_s: float | None) -> None:
        """They were switched on again, at a station time (s) where that is known."""
        for unit in self.sound:
            unit.unit.switched_on(station_s)

    def write_manifests(self) -> None:
        """Write every manifest with the segments finished so far."""
        for unit in self.sound:
            unit.write_manifest(self.encoders.table.time_half_width_s)

    def enter(self, state: State, cause: Message) -> None:
        """The run enters a state."""
        for unit in self.sound:
            unit.log.enter(state, cause)

    @property
    def state(self) -> State:
        return self.sound[0].log.state

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """What was noticed so far, of which unit where there are several."""
        of_each = [
            (unit, alarm) for unit in self.units for alarm in (*unit.log.alarms, *_given_up(unit))
        ]
        if len(self.units) == 1:
            return tuple(alarm for _, alarm in of_each)
        return tuple(
            Alarm(
                **worded(message("station-of-unit", unit=unit.serial, alarm=alarm)),
                code=alarm.code,
                at=alarm.at,
            )
            for unit, alarm in of_each
        )

    @property
    def rates_hz(self) -> Mapping[str, float]:
        """Rows of each stream in a second of its time; of several units, the slowest's."""
        return _most((unit.last_rows.rates_hz for unit in self.sound), min)

    @property
    def noise(self) -> Mapping[str, float]:
        """The noise as LastRows has it; that of the noisiest of several units."""
        return _most((unit.last_rows.noise for unit in self.sound), max)


def _given_up(unit: UnitRecorder) -> tuple[Alarm, ...]:
    if unit.given_up is None:
        return ()
    cause = message("station-log-given-up", cause=unit.cause or unit.given_up)
    return (Alarm(code=GIVEN_UP, at=unit.log.entries[-1].at, **worded(cause)),)


def _most(
    figures: Iterable[Mapping[str, float]], choose: Callable[[list[float]], float]
) -> dict[str, float]:
    found: dict[str, list[float]] = {}
    for each in figures:
        for name, value in each.items():
            found.setdefault(name, []).append(value)
    return {name: choose(values) for name, values in found.items()}
