"""Table, fixture, chamber and unit on one clock."""

import struct
from binascii import crc_hqx
from collections.abc import Iterable
from typing import TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from tasks.station.virtual import table
from tasks.station.virtual.config import (
    EARTH_RATE_RAD_S,
    FRAMES,
    STEP_S,
    Air,
    UnitTruth,
    VirtualStation,
    draw_ahrs,
    draw_unit,
)
from tasks.station.virtual.faults import Condition, StationFault, condition
from tasks.station.virtual.sensors import Ahrs, UnitUnderTest
from tasks.station.virtual.table import VirtualChamber, VirtualFixture, VirtualTable

UP = np.array([0.0, 0.0, 1.0])
STILL_AFTER_S = 1.0  # by then servo and filters are where they are going, to 1e-15
Samples: TypeAlias = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


class Body:
    """Follows the table's angles; what it gives is one step behind what it got."""

    def __init__(self, config: VirtualStation) -> None:
        directions = [np.array(axis.direction) for axis in config.table.axes]
        self._directions = [direction / np.linalg.norm(direction) for direction in directions]
        self._base = table.about(-UP, np.radians([config.heading_deg]))
        mount = Rotation.from_quat(config.mount.quaternion_wxyz, scalar_first=True)
        self._mount = mount.as_quat(scalar_first=True)[:, None]
        latitude = np.radians(config.latitude_deg)
        north_up = np.array([0.0, np.cos(latitude), np.sin(latitude)])
        # rotation of East-North-Up in inertial space during one step, (4, 1)
        self._earth = table.about(north_up, np.array([EARTH_RATE_RAD_S * STEP_S]))
        self._gravity = config.gravity_m_s2
        start = self.attitude(np.zeros((1, len(directions))), self._mount)
        self._attitude = start
        self._rate = self._rates(np.hstack([start, start]))

    def attitude(self, angles: np.ndarray, mount: np.ndarray) -> np.ndarray:
        """R_n_body at the axes' angles (n, axes) and mounts (4, n or 1), as quaternions (4, n)."""
        q = self._base
        for direction, angle in zip(self._directions, angles.T, strict=True):
            q = table.product(q, table.about(direction, angle))
        return table.product(q, mount)

    def _rates(self, attitudes: np.ndarray) -> np.ndarray:
        """Inertial rate (3, n−1) between attitudes (4, n): the exact mean over each step."""
        back = table.conjugate(attitudes[:, :-1])
        turn = table.product(table.product(back, self._earth), attitudes[:, 1:])
        return table.rotation_vector(turn) / STEP_S

    def still(self) -> tuple[np.ndarray, np.ndarray]:
        """Inertial body rate and specific force (3, 1), as long as nothing moves."""
        return self._rate, table.up_in_body(self._attitude) * self._gravity

    def move(
        self, angles: np.ndarray, mount: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Takes the angles (n, axes) after the next n steps; gives the motion one step before each.

        mount: attitude of the unit on the payload, (4, n) or (4, 1); else that of the station.

        Returns inertial body rate (rad/s), angular acceleration (rad/s²) and the specific force
        of a point at rest at the axes' intersection (m/s²), each (3, n) in the body frame. Rate
        and acceleration are those of the middle of two steps, so they are where the time is.
        """
        seat = self._mount if mount is None else mount
        attitudes = np.hstack([self._attitude, self.attitude(angles, seat)])
        rates = np.hstack([self._rate, self._rates(attitudes)])
        self._attitude, self._rate = attitudes[:, -1:], rates[:, -1:]
        up = table.up_in_body(attitudes[:, :-1])
        middle = 0.5 * (rates[:, 1:] + rates[:, :-1])
        return middle, np.diff(rates, axis=1) / STEP_S, up * self._gravity


class Simulation:
    """Moves on in steps of a millisecond of station time."""

    def __init__(self, config: VirtualStation, faults: Iterable[StationFault] = ()) -> None:
        self.config = config
        self.faults = tuple(faults)
        self.table = VirtualTable(config.table)
        self.chamber = VirtualChamber(config.chamber, config.air.temperature_degc)
        self.condition = Condition()
        self.fixture = VirtualFixture(config.mount)
        self.is_supplied = True
        self.supplied_steps = 0  # when the supply was last switched on
        self._held: list[bytes] = []  # frames that are late
        self._clock_errs_from: int | None = None  # number of a sample
        self._body = Body(config)
        self._unit, *self._neighbours = (
            _mounted(truth, config.air.temperature_degc, 0)
            for truth in (config.unit, *config.neighbours)
        )
        self._neighbours_sent = [bytearray() for _ in self._neighbours]

    @property
    def air(self) -> Air:
        """What the chamber measures."""
        now = self.condition
        degc = self.chamber.degc(self.table.now)
        faulty = {
            "temperature_degc": degc if now.air_degc is None else now.air_degc,
            "humidity_percent": now.humidity_percent,
            "supply_v": now.supply_v,
        }
        changed = {name: value for name, value in faulty.items() if value is not None}
        return self.config.air.model_copy(update=changed)

    @property
    def air_degc(self) -> float:
        """Temperature of the chamber's air."""
        return self.air.temperature_degc

    @property
    def is_still(self) -> bool:
        """Whether table and fixture rest."""
        still_since = max(self.table.still_since(), self.fixture.still_since())
        return self.table.now > still_since + STILL_AFTER_S

    def advance(self, steps: int) -> list[bytes]:
        """Lets time pass and returns the frames that the unit sent meanwhile."""
        self._apply_faults()
        if self.is_still:
            self.table.rest(steps)
            still = (*self._body.still(), steps, self.air_degc)
            self._gather(each.rest(*still) for each in self._neighbours)
            return self._send(*self._unit.rest(*still))
        mount = self.fixture.mount((self.table.steps + np.arange(1, steps + 1)) * STEP_S)
        motion = (*self._body.move(self.table.advance(steps), mount), self.air_degc)
        self._gather(each.sense(*motion) for each in self._neighbours)
        return self._send(*self._unit.sense(*motion))

    def neighbours_sent(self) -> list[bytes]:
        """What each neighbour sent since the last call."""
        sent = [bytes(each) for each in self._neighbours_sent]
        for each in self._neighbours_sent:
            each.clear()
        return sent

    def _gather(self, samples: Iterable[Samples]) -> None:
        units = zip(self._neighbours_sent, self.config.neighbours, samples, strict=True)
        for waiting, truth, read in units:
            waiting += b"".join(frames(truth.frame, *read))

    def turn_fixture(self) -> None:
        """Sets the fixture going, where its drive obeys."""
        if not self.condition.fixture_stays:
            self.fixture.turn(self.table.now)

    def supply(self, on: bool) -> None:
        """Switches the unit's supply."""
        if on and not self.is_supplied:
            for each in (self._unit, *self._neighbours):
                each.switch_on(self.air_degc)
            self.supplied_steps = self.table.steps
        elif not on:
            for each in (self._unit, *self._neighbours):
                each.switch_off()
        self.is_supplied = on

    def mount(self, place: int, serial: str, seed: int) -> None:
        """Take the unit off a place and put another of its kind there, whose errors are drawn anew.

        place: 0 that of the unit, then those of its neighbours.
        """
        truths = [self.config.unit, *self.config.neighbours]
        draw = draw_unit if truths[place].angle_lsb is None else draw_ahrs
        truths[place] = draw(seed).model_copy(update={"label": serial})
        unit = _mounted(truths[place], self.air_degc, self.table.steps)
        if not self.is_supplied:
            unit.switch_off()
        if place:
            self._neighbours[place - 1] = unit
        else:
            self._unit, self._clock_errs_from = unit, None
        changed = {"unit": truths[0], "neighbours": tuple(truths[1:])}
        self.config = self.config.model_copy(update=changed)

    def _apply_faults(self) -> None:
        before, self.condition = self.condition, condition(self.faults, self.table.now)
        self.table.hunting_rad = self.condition.hunting_rad
        self.table.rate_factor = self.condition.rate_factor
        self.table.claims_settled = self.condition.claims_settled
        self.table.capture_skips = self.condition.capture_skips
        self.table.captures_nothing = self.condition.captures_nothing
        if self.condition.encoder != before.encoder:
            self.table.encoder = self.condition.encoder.holding(self.table.angle.copy())
        if self.condition.is_supply_cut and self.is_supplied:
            self.supply(False)
        if self.condition.trips - before.trips:
            self.table.trip(self.condition.trips - before.trips)

    def _send(
        self, numbers: np.ndarray, stamps: np.ndarray, counts: np.ndarray, degc: np.ndarray
    ) -> list[bytes]:
        if len(numbers):
            numbers, stamps = self._by_its_clock(numbers, stamps)
        for change in self.condition.counts:
            counts = change(numbers, counts)
        sent = frames(self.config.unit.frame, numbers, stamps, counts, degc)
        for transmit in self.condition.wire:
            sent = transmit(numbers, sent)
        self._held += sent
        if len(self._held) < self.condition.held_frames:
            return []
        sent, self._held = self._held, []
        return sent

    def _by_its_clock(
        self, numbers: np.ndarray, stamps: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Counters and stamps, as the unit's clock has them."""
        if self.condition.stamps and self._clock_errs_from is None:
            self._clock_errs_from = int(numbers[0])
        for change in self.condition.stamps:
            numbers, stamps = change(numbers, stamps, self._clock_errs_from or 0)
        return numbers, stamps


def _mounted(truth: UnitTruth, air_degc: float, step: int) -> UnitUnderTest:
    kind = UnitUnderTest if truth.angle_lsb is None else Ahrs
    return kind(truth, air_degc, step)


def frames(
    kind: str, numbers: np.ndarray, stamps_us: np.ndarray, counts: np.ndarray, degc: np.ndarray
) -> list[bytes]:
    """One frame of a kind of FRAMES for each sample.

    numbers (n,), unit time stamps_us (n,), counts (n, 6), temperature degc (n,).
    """
    frame = FRAMES[kind]
    body_of, crc = struct.Struct(frame.format[:-1]), struct.Struct("<H")
    counters = (numbers % 2**32).tolist()
    centi = np.rint(np.clip(degc, -300.0, 300.0) * 100.0).astype(int).tolist()
    packed = []
    for row in zip(counters, stamps_us.tolist(), counts.tolist(), centi, strict=True):
        counter, stamp, values, temperature = row
        body = body_of.pack(frame.sync, counter, stamp, *values, temperature)
        packed.append(body + crc.pack(crc_hqx(body, 0)))
    return packed
