"""What comes in goes to the sink at once, and is checked on the way."""

import asyncio
from dataclasses import asdict
from typing import Protocol

from schemas.procedure import EnvironmentLimits
from schemas.recording import Manifest, Segment, Stream
from schemas.run_log import LogEntry
from tasks.station.anomalies import FAILURES, Anomaly, touches
from tasks.station.bench import Bench
from tasks.station.clock import StationClock
from tasks.station.manifest import ManifestBuilder
from tasks.station.monitor import SegmentMonitor
from tasks.station.readers import ClimateReader, EncoderReader, UnitReader
from tasks.station.run_log import RunLog
from tasks.station.stream_figures import LastRows

FLUSH_S = 0.2  # wall time: what a kill may lose


class Sink(Protocol):
    """Where a recording goes as it is made; what a call gives is soon on the disk."""

    def append(self, name: str, stream: Stream, /) -> object: ...

    def manifest(self, manifest: Manifest, /) -> object: ...


class Recorder:
    """The three streams of a run, written to the sink every FLUSH_S of wall time."""

    def __init__(
        self,
        bench: Bench,
        clock: StationClock,
        limits: EnvironmentLimits,
        sink: Sink,
        manifest: ManifestBuilder,
    ) -> None:
        self.anomalies: list[Anomaly] = []
        self.manifest = manifest
        self.encoders = EncoderReader(bench.table, clock, self.anomalies.append)
        self.climate = ClimateReader(bench.chamber, clock, limits, self.anomalies.append)
        self.unit = UnitReader(bench.unit, clock, self.anomalies.append)
        self.monitor = SegmentMonitor(bench.unit.link)
        self.last_rows = LastRows()
        self.log = RunLog(clock, manifest.origin_s)
        self.log.entries += map(LogEntry.model_validate, manifest.extra.get("log", ()))
        self._sink = sink

    async def run(self) -> None:
        """Flush for ever."""
        while True:
            await asyncio.sleep(FLUSH_S)
            self.flush()

    def flush(self, final: bool = False) -> None:
        """Write what has come. The unit is last: its silence must not cost the other streams."""
        table = self._written("table", self.encoders.take())
        self._written("environment", self.climate.take())
        imu = self._written("imu", self.unit.take(final))
        self.anomalies += self.monitor.run(imu, table)
        self.log.notice(self.anomalies)

    def _written(self, name: str, stream: Stream) -> Stream:
        if len(stream):
            self._sink.append(name, self.manifest.since_start(stream))
            self.last_rows.add(name, stream)
        return stream

    def finish(self, segment: Segment, spin_axis: str | None) -> None:
        """A measured segment is over: label it, and check it when its data are there."""
        self.manifest.add(segment)
        self.monitor.add(segment, spin_axis)
        self.write_manifest()

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
        self.write_manifest()

    def write_manifest(self) -> None:
        """Write the manifest with the segments finished so far."""
        first_s, *again_s = self.unit.clock_shifts_s
        if first_s:
            self.manifest.extra["unit_clock_shift_s"] = first_s
        if again_s:
            since_start = [round(shift_s - self.manifest.origin_s, 6) for shift_s in again_s]
            self.manifest.extra["unit_power_on_s"] = since_start
        if half_width_s := self.encoders.table.time_half_width_s:
            table_time = {"encoder": "polled", "half_width_s": round(half_width_s, 6)}
            self.manifest.extra["table_time"] = table_time
        self.manifest.extra["log"] = [each.model_dump(mode="json") for each in self.log.entries]
        if comparison := self.unit.compared():
            self.manifest.extra["unit_clock"] = asdict(comparison)
        self._sink.manifest(self.manifest.build())
