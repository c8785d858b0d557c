"""What flows in goes to the sink at once, and is looked at on the way."""

import asyncio
from typing import Protocol

from schemas.procedure import EnvironmentLimits
from schemas.recording import Manifest, Segment, Stream
from tasks.station.checks import Checks
from tasks.station.clock import StationClock
from tasks.station.feeds import ClimateFeed, EncoderFeed, UnitFeed
from tasks.station.findings import Finding
from tasks.station.labels import Labels
from tasks.station.table import Table
from tasks.station.unit import Unit

FLUSH_S = 0.2  # wall time: what a kill may lose


class Sink(Protocol):
    """Where a recording goes as it is made; every call is kept when it returns."""

    def imu(self, stream: Stream, /) -> object: ...

    def table(self, stream: Stream, /) -> object: ...

    def environment(self, stream: Stream, /) -> object: ...

    def manifest(self, manifest: Manifest, /) -> object: ...


class Recorder:
    """The three feeds of a run, written to the sink every FLUSH_S of wall time."""

    def __init__(
        self,
        table: Table,
        unit: Unit,
        clock: StationClock,
        limits: EnvironmentLimits,
        sink: Sink,
        labels: Labels,
    ) -> None:
        self.findings: list[Finding] = []
        self.encoders = EncoderFeed(table, clock, self.findings.append)
        self.climate = ClimateFeed(table.link, clock, limits, self.findings.append)
        self.unit = UnitFeed(unit, clock, self.findings.append)
        self._checks = Checks(unit.link)
        self._sink = sink
        self._labels = labels

    async def run(self) -> None:
        """Flush for ever."""
        while True:
            await asyncio.sleep(FLUSH_S)
            self.flush()

    def flush(self, final: bool = False) -> None:
        """Write what has come. The unit is last: its silence must not cost the other streams."""
        table = self.encoders.take()
        if len(table):
            self._sink.table(self._labels.since_start(table))
            self._checks.table.append(table)
        environment = self.climate.take()
        if len(environment):
            self._sink.environment(self._labels.since_start(environment))
        imu = self.unit.take(final)
        if len(imu):
            self._sink.imu(self._labels.since_start(imu))
            self._checks.imu.append(imu)
        self._checks.run(self.findings.append)

    def begin(self) -> None:
        """Write a manifest that has no segment yet."""
        self._sink.manifest(self._labels.manifest())

    def finish(self, segment: Segment, spin_axis: str | None) -> None:
        """A measured segment is over: label it, and check it when its data are there."""
        self._labels.add(segment)
        self._checks.add(segment, spin_axis)
        self.write_manifest()

    def write_manifest(self) -> None:
        first_s, *again_s = self.unit.shifts_s
        if first_s:
            self._labels.extra["unit_clock_shift_s"] = first_s
        if again_s:
            since_start = [round(shift_s - self._labels.origin_s, 6) for shift_s in again_s]
            self._labels.extra["unit_power_on_s"] = since_start
        self._sink.manifest(self._labels.manifest())

    def has_passed(self, t: float) -> bool:
        """Whether unit and encoders are there up to a station time (s)."""
        return self._checks.passed(t)
