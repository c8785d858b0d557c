"""The virtual unit's samples against arithmetic done here: gravity, Earth, turning, noise."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.laboratory import ChamberLimits
from schemas.recording import Mount
from tasks.station.drivers.modbus import encode
from tasks.station.drivers.unit import find_binary
from tasks.station.virtual import table
from tasks.station.virtual.config import (
    CHAMBER_REGISTERS,
    MODES,
    UnitTruth,
    VirtualStation,
    draw_unit,
    station_file,
    virtual_station,
)
from tasks.station.virtual.registers import ChamberRegisters, RefusedWrite
from tasks.station.virtual.sensors import SensorNoise, UnitUnderTest
from tasks.station.virtual.simulation import Body, Simulation
from tasks.station.virtual.table import VirtualChamber, VirtualTable

DEG = np.pi / 180.0
EARTH = 7.292115e-5
G = 9.8015
EYE = np.eye(3).tolist()
NOTHING = (0.0, 0.0, 0.0)


def ideal(**changes) -> UnitTruth:
    """A unit without errors or noise, at the axes' intersection."""
    unit = draw_unit(5)
    clean = {"scale": EYE, "bias": NOTHING, "bias_per_kelvin": NOTHING, "white": 0, "flicker": 0}
    fields = unit.model_dump() | {
        "gyro": unit.gyro.model_dump() | clean | {"lsb": 1e-8},
        "accel": unit.accel.model_dump() | clean | {"lsb": 1e-7},
        "g_sensitivity": [NOTHING] * 3,
        "places_m": [NOTHING] * 3,
        "self_heating_k": 0.0,
        "settled_degc": 20.0,
    }
    return UnitTruth.model_validate(fields | changes)


def samples(config: VirtualStation, orders, seconds: float) -> np.ndarray:
    """Counts of the last second as (n, 6) in SI, after orders (axis, mode, angle, rate)."""
    table, body = VirtualTable(config.table), Body(config)
    unit = UnitUnderTest(config.unit, config.air.temperature_degc)
    for axis, mode, angle, rate in orders:
        drive = table.drives[axis]
        drive.target_angle, drive.target_rate = angle * DEG, rate * DEG
        table.command(axis, MODES[mode])
    rows = []
    for _ in range(int(seconds)):
        counts = unit.sense(*body.move(table.advance(1000)), config.air.temperature_degc)[2]
        rows.append(counts)
    return rows[-1] * np.repeat([config.unit.gyro.lsb, config.unit.accel.lsb], 3)


@pytest.mark.parametrize("heading", [0.0, 30.0])
@pytest.mark.parametrize("angles", [(0, 0, 0), (0, 90, 0), (40, -90, 10), (-120, 33, 270)])
def test_at_rest_it_reads_gravity_and_earth_rotation(angles, heading):
    config = VirtualStation(unit=ideal(), heading_deg=heading, latitude_deg=35.0)
    orders = [(axis, "angle", angle, 300.0) for axis, angle in enumerate(angles)]
    read = samples(config, orders, 8)
    attitude = (
        Rotation.from_euler("z", -heading, degrees=True)
        * Rotation.from_euler("z", angles[0], degrees=True)
        * Rotation.from_euler("x", angles[1], degrees=True)
        * Rotation.from_euler("z", angles[2], degrees=True)
    )
    earth = EARTH * np.array([0, np.cos(35 * DEG), np.sin(35 * DEG)])
    np.testing.assert_allclose(read[-1, :3], attitude.inv().apply(earth), atol=2e-8)
    np.testing.assert_allclose(read[-1, 3:], attitude.inv().apply([0, 0, G]), atol=2e-7)


def test_the_mount_turns_the_unit_on_the_payload():
    half = np.sqrt(0.5)
    config = VirtualStation(unit=ideal(), mount=Mount(quaternion_wxyz=(half, half, 0, 0)))
    read = samples(config, [], 1)
    np.testing.assert_allclose(read[-1, 3:], [0, G, 0], atol=1e-6)


@pytest.mark.parametrize("rate", [300.0, -100.0])
def test_turning_it_reads_the_rate_and_minus_omega_squared_times_the_place(rate):
    places = [(0.010, 0.020, -0.030), (0.001, 0.002, 0.003), (-0.004, 0.005, 0.006)]
    config = VirtualStation(unit=ideal(places_m=places), latitude_deg=0.0)
    read = samples(config, [(2, "rate", 0.0, rate)], 6).mean(axis=0)
    omega = rate * DEG
    assert read[2] == pytest.approx(omega, rel=1e-6)
    assert read[3] == pytest.approx(-(omega**2) * 0.010, rel=1e-4)
    assert read[4] == pytest.approx(-(omega**2) * 0.002, rel=1e-4)
    assert read[5] == pytest.approx(G, abs=1e-6)


def test_speeding_up_it_reads_the_tangential_part():
    places = [(0.0, 0.02, 0.0), (0.03, 0.0, 0.0), (0.0, 0.0, 0.0)]
    config = VirtualStation(unit=ideal(places_m=places))
    read = samples(config, [(2, "rate", 0.0, 500.0)], 2).mean(axis=0)
    angular = 100.0 / 1.1 * DEG  # the drive keeps the servo's overshoot inside its limit
    assert read[3] == pytest.approx(-angular * 0.02, rel=1e-3)
    assert read[4] == pytest.approx(angular * 0.03, rel=1e-3)


def test_matrices_biases_and_g_sensitivity_enter_as_model_one_and_two_have_them():
    gyro_scale = [[1.01, 0.002, -0.003], [0.004, 0.99, 0.005], [-0.006, 0.007, 1.02]]
    accel_scale = [[0.98, 0.001, 0.002], [-0.003, 1.03, 0.004], [0.005, -0.006, 1.0]]
    unit = ideal(g_sensitivity=[(1e-4, 2e-4, 3e-4), (4e-4, 5e-4, 6e-4), (7e-4, 8e-4, 9e-4)])
    changes = {
        "gyro": unit.gyro.model_copy(update={"scale": gyro_scale, "bias": (0.01, 0.02, 0.03)}),
        "accel": unit.accel.model_copy(update={"scale": accel_scale, "bias": (0.1, 0.2, 0.3)}),
    }
    config = VirtualStation(unit=unit.model_copy(update=changes))
    read = samples(config, [(1, "angle", 90.0, 100.0)], 5)[-1]
    force = np.array([0.0, G, 0.0])  # the body's y points up
    latitude = 39.9 * DEG
    rate = EARTH * np.array([0.0, np.sin(latitude), -np.cos(latitude)])
    sensitivity = 1e-4 * np.arange(1, 10).reshape(3, 3)
    gyro = np.array(gyro_scale) @ rate + [0.01, 0.02, 0.03] + sensitivity @ force
    accel = np.array(accel_scale) @ force + [0.1, 0.2, 0.3]
    np.testing.assert_allclose(read, np.concatenate([gyro, accel]), atol=2e-7)


def test_samples_do_not_depend_on_how_time_is_cut():
    config = VirtualStation()

    def run(cuts):
        table, body, unit = (
            VirtualTable(config.table),
            Body(config),
            UnitUnderTest(config.unit, 20.0),
        )
        table.command(2, MODES["rate"])
        return np.concatenate([unit.sense(*body.move(table.advance(cut)), 20.0)[2] for cut in cuts])

    whole, pieces = run([1000]), run([1, 4, 5, 37, 453, 500])
    assert np.abs(whole - pieces).max() <= 1  # a count may fall the other way


def test_noise_has_the_random_walk_it_is_told_to_have():
    unit = draw_unit(2)
    quiet = {name: getattr(unit, name).model_copy(update={"flicker": 0.0})
             for name in ("gyro", "accel")}  # fmt: skip
    drawn = SensorNoise(unit.model_copy(update=quiet)).draw(40_000)
    spread = drawn.std(axis=0) / np.sqrt(unit.rate_hz)
    np.testing.assert_allclose(spread[:3], unit.gyro.white, rtol=0.03)
    np.testing.assert_allclose(spread[3:], unit.accel.white, rtol=0.03)


def test_flicker_keeps_its_level_over_many_averaging_times():
    unit = draw_unit(2)
    silent = {name: getattr(unit, name).model_copy(update={"white": 0.0})
              for name in ("gyro", "accel")}  # fmt: skip
    drawn = SensorNoise(unit.model_copy(update=silent)).draw(400_000)[:, :3] / unit.gyro.flicker
    for samples_each in (100, 1000, 10_000):
        means = drawn.reshape(-1, samples_each, 3).mean(axis=1)
        deviation = np.sqrt(0.5 * np.mean(np.diff(means, axis=0) ** 2))
        assert 0.3 < deviation < 1.5


def test_the_units_own_clock_runs_off_by_offset_and_skew():
    config = VirtualStation(unit=ideal(clock_offset_s=0.25, clock_skew=1e-3))
    table, body, unit = VirtualTable(config.table), Body(config), UnitUnderTest(config.unit, 20.0)
    numbers, stamps, _, _ = unit.sense(*body.move(table.advance(10_001)), 20.0)
    assert numbers[0] == 0
    assert stamps[1] == 10_000
    # The plant tells of station time up to 10 s: 9.75 s on, the unit counts 1.001 as many.
    assert numbers[-1] == int(9.75 * 100 * 1.001)


def test_a_sample_shows_a_step_after_the_delay_of_the_filter():
    config = VirtualStation(unit=ideal())
    unit = UnitUnderTest(config.unit, 20.0)
    ramp = np.zeros((3, 1001))
    ramp[2] = np.arange(1001) * 1e-3  # 1 rad/s² from 0
    counts = unit.sense(ramp, np.zeros_like(ramp), np.zeros_like(ramp), 20.0)[2]
    behind = 1.0 - counts[-1, 2] * config.unit.gyro.lsb
    assert behind == pytest.approx(np.sqrt(2.0) / (2 * np.pi * 40.0), rel=0.02)


def test_it_warms_up_toward_the_air_and_its_own_heat():
    config = VirtualStation(unit=draw_unit(3))
    unit = UnitUnderTest(config.unit, 20.0)
    still = np.zeros((3, 60_000))
    degc = np.concatenate([unit.sense(still, still, still, 20.0)[3] for _ in range(2)])
    assert degc[0] == pytest.approx(20.0)
    assert degc[-1] == pytest.approx(20.0 + 8.0 * (1 - np.exp(-119.99 / 120.0)), abs=1e-3)


def test_counts_clip_at_full_scale():
    config = VirtualStation(unit=draw_unit(3))
    unit = UnitUnderTest(config.unit, 20.0)
    fast = np.full((3, 200), 20.0)
    counts = unit.sense(fast, 0 * fast, 0 * fast, 20.0)[2]
    assert (counts[:, :3] == 2**19).all()


def test_the_same_seed_draws_the_same_unit_and_another_another():
    assert draw_unit(4) == draw_unit(4)
    assert draw_unit(4) != draw_unit(5)
    again = UnitTruth.model_validate_json(draw_unit(4).model_dump_json())
    assert again == draw_unit(4)


def test_quaternions_agree_with_scipy():
    rng = np.random.default_rng(0)
    vectors = rng.normal(size=(2, 50, 3))
    first, second = (Rotation.from_rotvec(each) for each in vectors)
    p, q = (each.as_quat(scalar_first=True).T for each in (first, second))
    both = Rotation.from_quat(table.product(p, q).T, scalar_first=True)
    assert (both.inv() * first * second).magnitude().max() < 1e-12
    up = table.up_in_body(p).T
    np.testing.assert_allclose(up, first.inv().apply([0, 0, 1]), atol=1e-12)
    short = vectors[0] * 1e-9
    turn = Rotation.from_rotvec(short).as_quat(scalar_first=True).T
    np.testing.assert_allclose(table.rotation_vector(turn).T, short, rtol=1e-12)


# The virtual AHRS and its fixture against arithmetic done here: angles, rests, restarts.

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


# The chamber's air goes where it is set, no faster than it can.

ROOM = 20.0


@pytest.fixture
def chamber() -> VirtualChamber:
    return VirtualChamber(ChamberLimits(temperature_degc=(0.0, 50.0), rate_k_min=6.0), ROOM)


@pytest.mark.parametrize(("target", "sign"), [(30.0, 1.0), (10.0, -1.0)])
def test_it_goes_at_its_rate_and_stays(chamber, target, sign):
    chamber.go_to(100.0, target)
    assert chamber.degc(100.0) == ROOM
    assert chamber.degc(150.0) == pytest.approx(ROOM + sign * 5.0)
    assert chamber.degc(500.0) == target


def test_it_turns_back_from_where_it_got(chamber):
    chamber.go_to(0.0, 40.0)
    chamber.go_to(60.0, ROOM)
    assert chamber.degc(60.0) == pytest.approx(26.0)
    assert chamber.degc(90.0) == pytest.approx(23.0)


def test_its_set_point_is_a_register_that_takes_what_it_can_keep():
    simulation = Simulation(VirtualStation())
    registers = ChamberRegisters(simulation)
    place = next(each for each in CHAMBER_REGISTERS if each.name == "target")
    registers.write(place.address, encode(30.0, place.type))
    assert registers.values(None)["target"] == 30.0
    with pytest.raises(RefusedWrite):
        registers.write(place.address, encode(80.0, place.type))
    for _ in range(300):
        simulation.advance(100)
    assert registers.values(None)["temperature"] == pytest.approx(22.0, abs=0.01)
