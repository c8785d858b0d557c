"""The virtual unit's samples against arithmetic done here: gravity, Earth, turning, noise."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.recording import Mount
from tasks.station.virtual import quaternions
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.protocol import MODES
from tasks.station.virtual.sensors import SensorNoise, UnitUnderTest
from tasks.station.virtual.simulation import Body
from tasks.station.virtual.table import VirtualTable
from tasks.station.virtual.unit import UnitTruth, draw_unit

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
    both = Rotation.from_quat(quaternions.product(p, q).T, scalar_first=True)
    assert (both.inv() * first * second).magnitude().max() < 1e-12
    up = quaternions.up_in_body(p).T
    np.testing.assert_allclose(up, first.inv().apply([0, 0, 1]), atol=1e-12)
    short = vectors[0] * 1e-9
    turn = Rotation.from_rotvec(short).as_quat(scalar_first=True).T
    np.testing.assert_allclose(quaternions.rotation_vector(turn).T, short, rtol=1e-12)
