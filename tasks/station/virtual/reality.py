"""Table, chamber and unit on one clock."""

from collections.abc import Iterable

import numpy as np

from tasks.station.virtual.body import Body
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import Condition, Fault, condition
from tasks.station.virtual.frames import frames
from tasks.station.virtual.sensors import UnitUnderTest
from tasks.station.virtual.table import Table


class Reality:
    """Moves on in steps of a millisecond of station time."""

    def __init__(self, config: VirtualStation, faults: Iterable[Fault] = ()) -> None:
        self.config = config
        self.faults = tuple(faults)
        self.table = Table(config.table)
        self.condition = Condition()
        self._body = Body(config)
        self._unit = UnitUnderTest(config.unit, config.air.temperature_degc)

    @property
    def air_degc(self) -> float:
        """Temperature of the chamber's air."""
        hot = self.condition.air_degc
        return self.config.air.temperature_degc if hot is None else hot

    def advance(self, steps: int) -> list[bytes]:
        """Lets time pass and returns the frames that the unit sent meanwhile."""
        self._suffer()
        motion = self._body.follow(self.table.advance(steps))
        numbers, stamps, counts, degc = self._unit.sense(*motion, self.air_degc)
        return self._send(numbers, stamps, counts, degc)

    def _suffer(self) -> None:
        before, self.condition = self.condition, condition(self.faults, self.table.now)
        self.table.hunting_rad = self.condition.hunting_rad
        self.table.rate_factor = self.condition.rate_factor
        if self.condition.trips - before.trips:
            self.table.trip(self.condition.trips - before.trips)

    def _send(
        self, numbers: np.ndarray, stamps: np.ndarray, counts: np.ndarray, degc: np.ndarray
    ) -> list[bytes]:
        for change in self.condition.counts:
            counts = change(numbers, counts)
        sent = frames(numbers, stamps, counts, degc)
        for transmit in self.condition.wire:
            sent = transmit(numbers, sent)
        return sent
