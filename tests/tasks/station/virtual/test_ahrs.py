"""The virtual AHRS and its fixture against arithmetic done here: angles, rests, restarts."""

import numpy as np
import pytest

from schemas.recording import Mount
from tasks.station.drivers.frames import find_binary
from tasks.station.virtual.config import VirtualStation, station_file, virtual_station
from tasks.station.virtual.protocol import MODES
from tasks.station.virtual.simulation import Simulation

DEG = np.pi / 180.0
EARTH = 7.292115e-5
G = 9.8015
EYE = np.eye(3).tolist()
NOTHING = (0.0, 0.0, 0.0)
HALF = 0.5**0.5


def perfect(**changes: object) -> VirtualStation:
    """A station whose AHRS has no errors and no noise."""
    station = virtual_station(1, ahrs=True)
    clean = {"scale": EYE, "bias": NOTHING, "bias_per_kelvin": NOTHING, "white": 0, "flicker": 0}
    fields = station.unit.model_dump() | {
        "gyro": station.unit.gyro.model_dump() | clean,
        "accel": station.unit.accel.model_dump() | clean | {"lsb": 1e-6},
        "angle_lsb": 1e-9,
        "places_m": [NOTHING] * 3,
    }
    unit = type(station.unit).model_validate(fields | changes)
    return station.model_copy(update={"unit": unit})


class Bench:
    """A station that goes on, and the frames that its unit has sent."""

    def __init__(self, station: VirtualStation, slice_steps: int = 1000) -> None:
        self.simulation = Simulation(station)
        self._lsb = station.unit.angle_lsb
        self.slice_steps = slice_steps
        self._sent: list[bytes] = []

    def pass_(self, seconds: float) -> None:
        left = round(seconds * 1000)
        while left:
            steps = min(left, self.slice_steps)
            self._sent += self.simulation.advance(steps)
            left -= steps

    def turn(self, mode: str, angle: float = 0.0, rate: float = 100.0) -> None:
        drive = self.simulation.table.drives[0]
        drive.target_angle, drive.target_rate = angle * DEG, rate * DEG
        self.simulation.table.command(0, MODES[mode])

    def refix(self, *quaternion: float) -> None:
        self.simulation.fixture.wanted[:] = quaternion
        self.simulation.turn_fixture()

    @property
    def frames(self) -> np.ndarray:
        frame = station_file(self.simulation.config, 1, "nowhere", 1, 2).unit_link.frame
        return find_binary(b"".join(self._sent), frame).samples

    @property
    def angle(self) -> np.ndarray:
        """The accumulated angles (n, 3), rad."""
        return self.frames["values"][:, :3]


def test_ten_turns_about_the_vertical_add_up_and_come_back():
    bench = Bench(perfect())
    bench.pass_(2.0)
    before = bench.angle[-1, 2]
    bench.turn("angle", 3600.0)
    bench.pass_(42.0)
    up = EARTH * np.sin(39.9 * DEG)
    assert bench.angle[-1, 2] - before == pytest.approx(20 * np.pi + 42.0 * up, abs=1e-7)
    bench.turn("angle", 0.0)
    bench.pass_(42.0)
    assert bench.angle[-1, 2] - before == pytest.approx(84.0 * up, abs=1e-7)


def test_at_rest_earth_turns_it_the_same_whether_it_is_worked_out_step_by_step_or_at_once():
    earth = EARTH * np.array([0.0, np.cos(39.9 * DEG), np.sin(39.9 * DEG)])
    bench = Bench(perfect())
    bench.pass_(60.0)
    t = bench.frames["stamp"] / 1e6
    assert t[-1] == pytest.approx(59.9, abs=1e-6)
    np.testing.assert_allclose(bench.angle, t[:, None] * earth, atol=1e-7)


def test_what_is_worked_out_at_once_goes_over_into_motion_without_a_jump():
    cut_fine, at_once = Bench(perfect(), 7), Bench(perfect(), 1000)
    for bench in (cut_fine, at_once):
        bench.pass_(5.0)
        bench.turn("rate", rate=30.0)
        bench.pass_(3.0)
        bench.turn("stop")
        bench.pass_(6.0)
    np.testing.assert_allclose(cut_fine.angle, at_once.angle, atol=3e-9)
    np.testing.assert_allclose(
        cut_fine.frames["values"][:, 3:6], at_once.frames["values"][:, 3:6], atol=2e-6
    )  # counts of 1e-6 m/s²


def test_turning_the_fixture_over_turns_the_unit_and_it_feels_it():
    bench = Bench(perfect())
    bench.pass_(2.0)
    before = bench.angle[-1]
    bench.refix(HALF, HALF, 0.0, 0.0)  # a quarter turn about x: y up
    assert bench.simulation.fixture.status(bench.simulation.table.now) == 2
    bench.pass_(10.0)
    assert bench.simulation.fixture.status(bench.simulation.table.now) == 1
    felt = bench.angle[-1] - before
    np.testing.assert_allclose(felt, [np.pi / 2, 0.0, 0.0], atol=12.0 * EARTH)
    force = bench.frames["values"][-1, 3:6]
    np.testing.assert_allclose(force, [0.0, G, 0.0], atol=2e-6)


def test_after_the_fixture_has_turned_the_unit_rests():
    """What is worked out at once begins when nothing moves any more, and not inside the last step.

    33° about x, level and east, take 1.4832 s; Earth turns nothing about it.
    """
    bench = Bench(perfect(), 100)
    bench.refix(np.cos(16.5 * DEG), np.sin(16.5 * DEG), 0.0, 0.0)
    bench.pass_(1.4)
    bench.slice_steps = 1  # over the end of the turn and the second after it
    bench.pass_(1.2)
    bench.slice_steps = 100
    bench.pass_(1.4)
    rate = np.diff(bench.angle[-12:, 0]) / 0.1
    assert np.abs(rate).max() < 1e-6


def test_the_fixture_carries_the_units_own_seat():
    seat = Mount(quaternion_wxyz=(HALF, 0.0, 0.0, HALF))  # a quarter turn about z
    bench = Bench(perfect().model_copy(update={"mount": seat}))
    bench.refix(HALF, HALF, 0.0, 0.0)  # the fixture's y up
    bench.pass_(10.0)
    force = bench.frames["values"][-1, 3:6]
    np.testing.assert_allclose(force, [G, 0.0, 0.0], atol=2e-6)


def test_switched_off_it_is_silent_and_cools_and_switched_on_it_begins_anew():
    bench = Bench(perfect())
    bench.pass_(300.0)
    bench.turn("rate", rate=50.0)
    bench.pass_(10.0)
    warm, count = bench.frames["values"][-1, -1], len(bench.frames)
    bench.simulation.supply(False)
    bench.pass_(60.0)
    assert len(bench.frames) == count
    bench.simulation.supply(True)
    bench.pass_(1.0)
    first = bench.frames[count]
    assert (first["counter"], first["stamp"]) == (0, 0)
    assert np.abs(first["values"][:3]).max() < 1e-3
    assert bench.simulation.supplied_steps == 370_000
    assert first["values"][-1] == pytest.approx(20.0 + (warm - 20.0) * np.exp(-0.5), abs=0.05)
    assert bench.angle[-1, 2] == pytest.approx(50.0 * DEG * 0.9, rel=0.01)


def test_rest_costs_the_table_nothing_it_would_have_captured():
    bench = Bench(perfect())
    bench.turn("angle", 90.0)
    bench.pass_(100.0)
    table = bench.simulation.table
    first, counts = table.capture(0, 2000)
    assert (first, len(counts)) == (0, 1001)
    assert (counts[-900:] == 900_000).all()
    assert table.axis_status(0) & 4
