"""The operator of a station: mounts units, clears faults, tries again, presses stop."""

import json
import random
import socket
import struct
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from urllib.parse import urlsplit

import httpx
import numpy as np

from schemas.recording import RunStatus
from schemas.station import StationFile
from tasks.station.virtual.config import draw_unit
from tests.proof.factory.draw import (
    BY_CHANCE,
    DISTURBED,
    OUT,
    REJECTED,
    STOPPED,
    STOPS_AFTER_S,
    OrderedUnit,
)
from tests.proof.factory.judge import Order
from tests.proof.factory.works import Works

MOST_TRIES = 6  # of an order: what keeps failing is left, and found by the judge
LOOK_S = 1.0
INVALID = " is invalid: "  # as the order says why it failed
MOUNT = ": mount "  # as it says that another unit is on the table
LATE_S = 20.0
IDLE_S = 20.0  # for which orders wait before the operator asks why


@dataclass
class Operator:
    """Keeps one station going. wrong: the order for which the wrong unit is mounted,
    once; late: that whose unit is mounted LATE_S late.
    """

    works: Works
    station: str
    units: dict[str, OrderedUnit]
    rng: random.Random
    wrong: str | None
    late: str | None = None
    events: list[str] = field(default_factory=list)
    _mounted: str | None = None
    _is_faulty: bool = False
    _cleared: set[str] = field(default_factory=set)
    _looked_s: float = 0.0
    _late_since_s: float | None = None
    _idle_since_s: float | None = None

    def tick(self, orders: list[Order]) -> None:
        """Look at the station's orders, and do what is to be done."""
        if time.monotonic() < self._looked_s + LOOK_S:
            return
        self._looked_s = time.monotonic()
        mine = [
            order
            for order in orders
            if order.number in self.units and self.units[order.number].station == self.station
        ]
        for order in mine:
            if order.state == "failed" and self._is_to_be_retried(order):
                self._retry(order)
                return
        for order in mine:
            if order.state == "waiting" and MOUNT in order.fault and order.number == self.wrong:
                self.events.append(f"{order.number} wrong unit: {order.fault[:160]}")
                self._cleared.add(order.number)
        try:
            queue = self._queue()
        except httpx.HTTPError:
            return  # Prefect's server is away
        measuring = {order.number for order in mine if order.state == "running" and not order.runs}
        made = {order.number for order in mine if order.runs}
        due = next(
            (number for number in queue if number in self.units and number not in made), None
        )
        if due is not None and due == self.late and self._late_since_s is None:
            self._late_since_s = time.monotonic()
        if due == self.late and time.monotonic() < (self._late_since_s or 0.0) + LATE_S:
            due = None
        if due is not None and (due not in measuring or self._mounted is None):
            self._mount(self.units[due])
        self._submit_again(is_idle=not queue and any(o.state == "waiting" for o in mine))

    def _queue(self) -> list[str]:
        """The orders of this station that Prefect will carry out, in its sequence."""
        asked = {
            "work_pools": {"name": {"any_": [f"station-{self.station}"]}},
            "flow_runs": {"state": {"type": {"any_": ["SCHEDULED", "PENDING", "RUNNING"]}}},
            "sort": "EXPECTED_START_TIME_ASC",
        }  # fmt: skip
        found = self.works.prefect_api("POST", "/flow_runs/filter", json=asked)
        found.sort(key=lambda each: each["state_type"] == "SCHEDULED")
        numbers = (each["parameters"]["order"].get("number") for each in found)
        return [number for number in numbers if number]  # one of the schedule has none

    def _submit_again(self, *, is_idle: bool) -> None:
        """Orders wait that Prefect lost: give them in again, as the file's sender would."""
        now_s = time.monotonic()
        self._idle_since_s = (self._idle_since_s or now_s) if is_idle else None
        if self._idle_since_s is not None and now_s > self._idle_since_s + IDLE_S:
            self.events.append(f"{self.station}: orders wait, and Prefect has none: given again")
            self._ask("order", "import", self.works.orders)
            self._idle_since_s = None

    def _is_to_be_retried(self, order: Order) -> bool:
        return order.attempts < MOST_TRIES and not (
            order.runs and self.units[order.number].is_rejected
        )

    def _retry(self, order: Order) -> None:
        """Clear what stopped it, and have it go on; an invalid run is a case for a new order."""
        unit = self.units[order.number]
        self.events.append(f"{order.number} {unit.fault or 'sound'}: {order.fault[:160]}")
        if order.runs and INVALID in order.fault:
            self._order_anew(unit)
            return
        self._cleared.add(order.number)
        self._mount(unit)
        self._ask("order", "retry", order.number)

    def _order_anew(self, unit: OrderedUnit) -> None:
        new = replace(unit, number=f"{unit.number}-again", fault=None)
        procedure = self.works.procedure_of(unit.procedure)
        client = self.works.client_order(unit.client)
        words = ("--serial", new.serial, "--procedure", procedure, "--client-order", client)
        if self._ask("order", "add", self.station, *words, "--number", new.number):
            self.units[unit.number] = replace(unit, fault=BY_CHANCE)
            self.units[new.number] = new

    def _ask(self, *words: object) -> bool:
        """Give a command; what it refuses, because something is away, is tried again later."""
        try:
            self.works.command(*words, "--by", "Li Na")
        except RuntimeError as refused:
            self.events.append(str(refused)[-200:])
            return False
        return True

    def _mount(self, unit: OrderedUnit) -> None:
        faults = self._faults(unit)
        serial, seed = unit.serial, unit.seed
        if unit.number == self.wrong and unit.number not in self._cleared:
            serial, seed = "V999999", 999
        if self._mounted == serial and self._is_faulty == bool(faults):
            return
        # Not by $MOUNT, which starts the unit's clock anew: at sixty times the clock on a busy
        # machine, frames arrive too unevenly for two clocks to be compared to 0.2 s of the station.
        self.works.parts[self.station].end()
        self.works.station(self.station, serial, seed, faults).start()
        self._mounted, self._is_faulty = serial, bool(faults)

    def _faults(self, unit: OrderedUnit) -> list[str]:
        if unit.fault in STOPPED and unit.number not in self._cleared:
            return [f"{unit.fault}@{self.works.speed * self.rng.uniform(*STOPS_AFTER_S):.0f}"]
        return [unit.fault] if unit.fault in (*DISTURBED, *REJECTED, OUT) else []

    def came_back(self) -> None:
        """The station was started anew: whatever was on the table is to be mounted again."""
        self._mounted = None


# The stop that an operator presses once while a table turns.

WITHIN_S = 2.0  # from the press to the table's rest
FROM_SEGMENT = 5  # of a run: what was measured before is to be there when it goes on
MEASURING = "measuring"
AT_REST_RAD_S = np.radians(1.0)  # that a gyro may read
RESTS_WITHIN_S = 20.0  # wall time: ten times that of the watchdog and the ramps
LOOKED_AT = 40  # frames
FRAME = struct.Struct("<HIQ3i3ihH")  # deploy/station.md, the frame of rates


@dataclass
class Stop:
    """Pressed at the first run that is well under way. answer: what the command answered."""

    works: Works
    station: str = ""
    order: str | None = None
    seconds: float | None = None
    is_at_rest: bool = False
    answer: str = ""

    @property
    def is_over(self) -> bool:
        return self.order is not None

    def tick(self, orders: list[Order], after: int) -> None:
        """after: orders that are to be done before."""
        done = sum(order.state == "done" for order in orders)
        running = [each for each in orders if each.state == "running" and not each.runs]
        for status in self._statuses() if not self.is_over and done >= after else ():
            mine = [each for each in running if each.serial in status.units]
            if mine and status.state == MEASURING and (status.segment or 0) >= FROM_SEGMENT:
                self.station = status.station
                self._press(mine[0])
                return

    def _statuses(self) -> Iterator[RunStatus]:
        for file in (self.works.home / "status").glob("*.json"):
            with suppress(OSError, ValueError):
                yield RunStatus.model_validate_json(file.read_bytes())

    def _press(self, order: Order) -> None:
        self.order = order.number
        try:
            answer = self.works.command("station", "stop", self.station, "--by", "Li Na", "--json")
        except RuntimeError as fault:
            self.answer = str(fault)
            return
        self.seconds = float(json.loads(answer)["seconds"])
        self.answer = answer.strip()
        station = StationFile.model_validate_json(
            self.works.station_file(self.station).read_bytes()
        )
        self.is_at_rest = comes_to_rest(station, draw_unit(1).gyro.lsb)
        self.works.command("station", "release", self.station)


def comes_to_rest(station: StationFile, lsb: float) -> bool:
    """Whether the table comes to rest soon, by the gyros of its unit, whose step is lsb (rad/s).

    The unit tells it also where the table's controller answers no more, and asking it is no sign
    of life that would keep a watchdog waiting.
    """
    unit = urlsplit(station.unit_link.url)
    place = str(unit.hostname), int(unit.port or 0)
    end_s = time.monotonic() + RESTS_WITHIN_S
    with socket.create_connection(place, RESTS_WITHIN_S) as line:
        while time.monotonic() < end_s:
            data = b""
            while len(data) < LOOKED_AT * FRAME.size:
                data += (part := line.recv(LOOKED_AT * FRAME.size - len(data)))
                if not part:
                    return False
            counts = np.array([frame[3:6] for frame in FRAME.iter_unpack(data)])
            if np.abs(np.median(counts, axis=0)).max() * lsb < AT_REST_RAD_S:
                return True
    return False
