"""Writes the streams of a run as they arrive: each unit's own, and table and air to all."""

import asyncio
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Literal

from schemas.base import Unusable
from schemas.procedure import EnvironmentLimits, Refix
from schemas.recording import Segment
from schemas.run_log import Alarm, State
from tasks.station.anomalies import Anomaly
from tasks.station.clock import StationClock
from tasks.station.connected_station import Bench
from tasks.station.stream_readers import ClimateReader, EncoderReader
from tasks.station.unit_recorder import UnitRecorder
from tasks.words import Message, message, worded

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
            unit.give_up(its_fault)
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
        """As LastRows has it; of several units, the noisiest's."""
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
