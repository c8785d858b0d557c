"""The recordings: noise as stated, clean ones clean, and files that the storage takes."""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import welch

from schemas.recording import ACCEL as FORCES
from schemas.recording import GYRO as RATES
from storage.formats.folder import read_folder
from tests.proof.plant.case import ACCEL_NOISE, GYRO_NOISE, Case, EffectCall, Grade
from tests.proof.plant.effects.electronics import Bandwidth
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.simulate import (
    Simulated,
    at_times,
    at_visibility,
    filtered,
    mean_limited,
    mean_reading,
    noise,
    seal,
    simulate,
    visibility,
    visibility_of,
    write,
)
from tests.proof.plant.world import Setting
from tests.proof.tests.plant.short_case import case_of


@pytest.mark.parametrize("grade", ["consumer", "industrial", "tactical"])
def test_noise_has_the_stated_density_over_four_decades(grade: Grade) -> None:
    for model in (GYRO_NOISE[grade], ACCEL_NOISE[grade]):
        made = noise(np.random.default_rng(3), model, 200_000, 100.0)
        frequency, density = welch(made, 100.0, nperseg=1 << 15)
        for low, high in ((0.01, 0.04), (0.04, 0.2), (0.2, 1.0), (1.0, 10.0), (10.0, 49.0)):
            band = (frequency >= low) & (frequency < high)
            ratio = (density[band] / model.density(frequency[band])).mean()
            spread = 1.0 / np.sqrt(6 * band.sum())
            assert ratio == pytest.approx(1.0, abs=0.03 + 4 * spread), (low, high)


@pytest.fixture(scope="module")
def clean() -> Simulated:
    return simulate(Case(seed=11, dwell_s=15.0))


def test_a_clean_recording_fits_the_standard_s_model_to_its_noise(clean: Simulated) -> None:
    rates, force = clean.reported[:, :3], clean.reported[:, 3:]
    readings = clean.recording.imu.stack(RATES + FORCES)
    one = np.ones((len(rates), 1))
    for channel in range(6):
        others = [axis for axis in range(3) if axis != channel - 3]
        gyro = np.hstack([rates, one, force])
        columns = gyro if channel < 3 else np.hstack([force, one, rates[:, others] ** 2])
        found, *_ = np.linalg.lstsq(columns, readings[:, channel], rcond=None)
        model = (GYRO_NOISE if channel < 3 else ACCEL_NOISE)["industrial"]
        left = readings[:, channel] - columns @ found
        assert left.var() / (model.white**2 * 50.0) == pytest.approx(1.0, abs=0.02)
        moving = np.abs(np.gradient(rates, axis=0)).sum(axis=1) > 1e-3
        assert left[moving].var() / left.var() == pytest.approx(1.0, abs=0.05)


def test_a_clean_recording_has_no_excess(clean: Simulated) -> None:
    assert np.array_equal(clean.truth, clean.nominal)


def test_the_table_s_stream_is_nearly_exact(clean: Simulated) -> None:
    table = clean.recording.table
    assert table is not None
    name = clean.recording.manifest.station.table_axes[0].name  # type: ignore[index]
    angle, rate = table.columns[f"{name}_angle"], table.columns[f"{name}_rate"]
    slope = np.gradient(angle, table.t)
    steady = np.abs(np.gradient(rate)) < 1e-5
    assert np.std((slope - rate)[steady]) < 5e-5


def test_a_case_is_the_same_every_time_and_effects_do_not_touch_the_noise() -> None:
    plain, again = simulate(case_of()), simulate(case_of())
    stepped = simulate(case_of("bias_step"))
    name = "gyro_x"
    assert np.array_equal(plain.recording.imu.columns[name], again.recording.imu.columns[name])
    noises = [made.recording.imu.columns[name] - made.truth[:, 0] for made in (plain, stepped)]
    assert np.abs(noises[0] - noises[1]).max() < 2 * GYRO_NOISE["industrial"].step


def test_storage_takes_the_recording_and_the_truth_stays_apart(tmp_path: Path) -> None:
    made = simulate(case_of("lever_arm", fields={"rate_hz": 50, "site_known": False}))
    write(made.recording, tmp_path / "given")
    seal(made.recording, made.sealed, made.truth, tmp_path / "sealed")
    read = read_folder(tmp_path / "given")
    assert np.allclose(read.imu.stack(RATES + FORCES), made.recording.imu.stack(RATES + FORCES))
    assert read.manifest.segments == made.recording.manifest.segments
    assert read.environment is not None
    assert read.manifest.station.latitude_deg is None
    assert not list((tmp_path / "given").glob("truth*"))
    given = "".join(path.read_text() for path in (tmp_path / "given").glob("*.json"))
    assert "lever_arm" not in given


# Visibility: against a closed formula, and as a dial.

LINE = {"gyro": [3e-4, 0.0, 0.0], "accel": [0.0, 0.0, 0.0], "frequency": 9.0}


def test_a_line_in_the_white_band_is_as_visible_as_its_energy() -> None:
    made = simulate(case_of("x_beat_line", **LINE))
    found = visibility(made, "x_beat_line")
    energy = 3e-4**2 / 2.0 * len(made.truth)
    density = GYRO_NOISE["industrial"].density(np.array(9.0)) * 50.0
    assert found.z == pytest.approx(np.sqrt(energy / density), rel=0.01)
    assert found.concealment < 0.01


def test_what_the_standard_absorbs_is_concealed() -> None:
    found = visibility_of(case_of("gravity_value"), "gravity_value")
    assert found.z < 1e-3
    assert found.concealment > 0.999999
    with pytest.raises(ValueError, match="cannot be seen"):
        at_visibility(case_of("gravity_value"), "gravity_value", 10.0)


@pytest.mark.parametrize(("name", "z"), [("lever_arm", 60.0), ("gyro_saturation", 60.0)])
def test_the_strength_is_set_to_a_visibility(name: str, z: float) -> None:
    case = at_visibility(case_of(name, fields={"rate_hz": 25}), name, z)
    assert visibility_of(case, name).z == pytest.approx(z, rel=0.05)


# Converter and filter against brute force.

DEVIATION = 0.3


def noisy(signal: float) -> np.ndarray:
    return signal + DEVIATION * np.random.default_rng(8).standard_normal(400_000)


@pytest.mark.parametrize("signal", [0.0, 0.2, 0.45, 0.8])
def test_the_mean_reading_of_coarse_steps_is_that_of_many_readings(signal: float) -> None:
    declared = mean_reading(np.full((1, 1), signal), np.array([1.0]), np.array([DEVIATION]))
    assert declared[0, 0] == pytest.approx(np.round(noisy(signal)).mean(), abs=3e-3)


@pytest.mark.parametrize("signal", [-1.1, -0.7, 0.0, 0.9, 1.0, 1.4])
def test_the_mean_reading_at_a_limit_is_that_of_many_readings(signal: float) -> None:
    declared = mean_limited(np.full((1, 1), signal), np.array([1.0]), np.array([DEVIATION]))
    assert declared[0, 0] == pytest.approx(np.clip(noisy(signal), -1.0, 1.0).mean(), abs=3e-3)


def test_steps_below_the_noise_change_nothing() -> None:
    signal = np.linspace(-1.0, 1.0, 50)[None]
    assert np.allclose(mean_reading(signal, np.array([0.3]), np.array([0.3])), signal, atol=1e-6)


def test_the_low_pass_lets_half_the_power_through_at_its_corner() -> None:
    case = Case(seed=1)
    call = EffectCall(name="bandwidth", parameters={"corner": 20.0})
    effect = Bandwidth.of(call, Setting(case, plan_of(case)))
    t = np.arange(0.0, 20.0, 0.002)
    for frequency, passed in ((2.0, 1.0), (20.0, np.sqrt(0.5)), (80.0, 1.0 / 16.0)):
        wave = np.sin(2.0 * np.pi * frequency * t)[None]
        inner = filtered(wave, 0.002, [effect])[0, 2000:-2000]
        assert inner.std() / wave[0, 2000:-2000].std() == pytest.approx(passed, rel=5e-3)


def test_sampling_between_points_is_cubic_and_rests_at_the_ends() -> None:
    grid = np.arange(0.0, 10.0)
    cubic = np.stack([grid**3 - 4.0 * grid, 2.0 * grid])
    times = np.array([1.5, 4.25, 7.9])
    declared = at_times(cubic, 0.0, 1.0, times)
    assert np.allclose(declared, [times**3 - 4.0 * times, 2.0 * times])
    assert np.array_equal(at_times(cubic, 0.0, 1.0, np.array([-3.0, 30.0]))[1], [0.0, 18.0])
