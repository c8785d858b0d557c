"""Sensors, room and electronics: each effect in its own channels, of the stated size."""

from collections.abc import Callable

import numpy as np
import pytest

from tests.proof.plant.simulate import NoiseFree, simulate
from tests.proof.plant.world import weather
from tests.proof.tests.plant.short_case import case_of, in_segment, noise_free


def excess(run: NoiseFree) -> np.ndarray:
    return run.truth - run.nominal


def test_nonlinear_and_lopsided_scale_factors() -> None:
    top = np.radians(200.0)
    run = noise_free(case_of("gyro_scale_nonlinearity", coefficient=[0, 0, 1e-3], order=3))
    for sign, name in ((1, "rate_z_+200"), (-1, "rate_z_-200")):
        sensed = run.unit.Kg[2, 2] * sign * top
        observation = excess(run)[:, in_segment(run, name)].mean(axis=1)
        assert observation == pytest.approx([0, 0, 1e-3 * sensed**3 / top**2, 0, 0, 0], abs=1e-8)
    run = noise_free(case_of("gyro_scale_asymmetry", half_difference=[0, 0, 1e-3]))
    for name in ("rate_z_+200", "rate_z_-200"):
        observation = excess(run)[2, in_segment(run, name)].mean()
        assert observation == pytest.approx(1e-3 * run.unit.Kg[2, 2] * top, rel=1e-5)


def test_gyros_follow_acceleration_squared_and_angular_acceleration() -> None:
    M = np.zeros((3, 3))
    M[1, 2] = 1e-6
    run = noise_free(case_of("gyro_g2_sensitivity", M=M.tolist()))
    for name in ("position_+z_000", "position_-z_000"):
        assert excess(run)[1, in_segment(run, name)].mean() == pytest.approx(1e-6 * 9.8015**2)
    assert np.abs(excess(run)[[0, 2, 3, 4, 5]]).max() < 1e-12
    run = noise_free(case_of("gyro_angular_acceleration", A=(1e3 * M).tolist()))
    change = np.gradient(run.reported[2], 0.01)
    assert np.corrcoef(excess(run)[1], change)[0, 1] > 0.999
    assert np.abs(excess(run)[:, in_segment(run, "rate_z_+200")]).max() < 1e-6


def test_scale_that_depends_on_acceleration_differs_upside_down() -> None:
    S = np.diag([0.0, 0.0, 1e-5])
    fields = {"procedure": "six_orientations"}
    run = noise_free(case_of("gyro_scale_g_dependence", fields=fields, S=S.tolist()))
    for sign, name in ((1, "rate_z_+200"), (-1, "rate_z_down_+200")):
        expected = sign * 1e-5 * 9.8015 * run.unit.Kg[2, 2] * np.radians(200.0)
        assert excess(run)[2, in_segment(run, name)].mean() == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(("name", "rows", "limit"), [
    ("gyro_saturation", slice(0, 3), 3.0), ("accel_saturation", slice(3, 6), 9.5),
])  # fmt: skip
def test_outputs_stop_at_their_limit(name: str, rows: slice, limit: float) -> None:
    case = case_of(name, limit=limit, fields={"grade": "tactical"})
    made = simulate(case.with_strength(name, 0.0))
    readings = made.recording.imu.stack(tuple(made.recording.imu.columns)[:6])
    assert np.abs(readings[:, rows]).max() == pytest.approx(limit, abs=2e-4)
    assert np.abs(made.truth[:, rows]).max() == pytest.approx(limit, abs=1e-9)
    inside = np.abs(made.nominal[:, rows]) < 0.99 * limit
    assert np.abs(made.truth - made.nominal)[:, rows][inside].max() < 1e-9


def test_vibration_adds_noise_and_bias_that_grow_with_rate() -> None:
    case = case_of("vibration_rectification", coefficient=[0.01, 0, 0], exponent=1.0, share=0.05)
    made = simulate(case)
    noise = made.recording.imu.stack(("accel_x",))[:, 0] - made.truth[:, 3]
    still, quick = made.reported[:, 2] == 0.0, made.reported[:, 2] > 3.4
    assert noise[quick].std() == pytest.approx(np.hypot(0.05, noise[still].std()), rel=0.05)
    assert (made.truth - made.nominal)[quick, 3].mean() == pytest.approx(0.01, rel=3e-3)
    assert np.abs((made.truth - made.nominal)[quick][:, [0, 1, 2, 4, 5]]).max() < 1e-9


@pytest.mark.parametrize(("name", "regressor"), [
    ("temperature_bias", lambda room: room.temperature - 25.0),
    ("thermal_gradient", lambda room: room.temperature_rate),
    ("supply_sensitivity", lambda room: room.supply - 5.0),
    ("x_humidity_drift", lambda room: room.humidity - 45.0),
    ("x_pressure_sensitivity", lambda room: room.pressure - 1013.0),
])  # fmt: skip
def test_biases_follow_the_room(name: str, regressor: Callable[..., np.ndarray]) -> None:
    case = case_of(name, gyro=[1e-3, 0, 0], accel=[0, 0, 2e-2])
    run = noise_free(case)
    follows = regressor(weather(case, run.stamp))
    assert np.allclose(excess(run)[0], 1e-3 * follows, atol=1e-9)
    assert np.allclose(excess(run)[5], 2e-2 * follows, atol=1e-8)
    assert np.abs(excess(run)[[1, 2, 3, 4]]).max() < 1e-12


def test_temperature_rate_is_the_slope_of_temperature() -> None:
    t = np.arange(0.0, 1500.0)
    for climate in ("room", "cycling"):
        room = weather(case_of(fields={"climate": climate}), t)
        slope = np.gradient(room.temperature, t)[1:-1]
        assert np.abs(slope - room.temperature_rate[1:-1]).max() < 1e-5


def test_the_magnetic_field_is_constant_in_the_room() -> None:
    run = noise_free(case_of("magnetic_sensitivity", M=np.eye(3).tolist(), field=[0, 3e-5, -4e-5]))
    size = np.linalg.norm(excess(run)[:3], axis=0)
    assert np.allclose(size, 5e-5, rtol=1e-6)
    level = excess(run)[:3, in_segment(run, "position_+z_000")].mean(axis=1)
    assert level == pytest.approx([0, 3e-5, -4e-5], abs=1e-9)
    assert np.abs(excess(run)[3:]).max() < 1e-12


def test_the_low_pass_delays_and_rounds() -> None:
    run = noise_free(case_of("bandwidth", corner=10.0))
    delay = np.sqrt(2.0) / (2.0 * np.pi * 10.0)
    moves = slice(1000, 1400)
    slope = np.gradient(run.nominal, 0.01, axis=1)[:, moves]
    observation = (slope * excess(run)[:, moves]).sum() / (slope**2).sum()
    assert observation == pytest.approx(-delay, rel=0.02)
    assert np.abs(excess(run)[:, in_segment(run, "position_+x_000", 2.0)]).max() < 1e-6


def test_a_coarse_converter_leaves_whole_steps() -> None:
    made = simulate(case_of("coarse_quantisation", gyro=5e-3, accel=2e-2))
    for channels, step in ((("gyro_x", "gyro_y"), 5e-3), (("accel_x", "accel_z"), 2e-2)):
        counts = made.recording.imu.stack(channels) / step
        assert np.abs(counts - np.round(counts)).max() < 1e-6
    off = made.recording.imu.stack(("gyro_z",))[:, 0] - made.truth[:, 2]
    blocks = off[:27000].reshape(-1, 600).mean(axis=1)
    assert np.sqrt((blocks**2).mean()) < 1.2e-4  # the truth is the mean reading, not the signal
    assert np.abs((made.truth - made.nominal)[:, 2]).max() > 2e-4


def test_the_mains_line_stands_at_its_alias() -> None:
    run = noise_free(case_of("mains_pickup", frequency=50.06, gyro=[1e-3, 0, 0], third=0.0))
    line = np.abs(np.fft.rfft(excess(run)[0, :20000]))
    assert np.fft.rfftfreq(20000, 0.01)[line.argmax()] == pytest.approx(49.94, abs=0.006)
    assert np.abs(excess(run)[1]).max() < 1e-12
