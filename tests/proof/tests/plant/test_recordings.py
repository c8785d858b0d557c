"""The recordings: noise as stated, clean ones clean, and files that the storage takes."""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import welch

from schemas.recording import ACCEL as FORCES
from schemas.recording import GYRO as RATES
from storage.formats.folder import read_folder
from tests.proof.plant.case import ACCEL_NOISE, GYRO_NOISE, Case, Grade
from tests.proof.plant.simulate import Simulated, noise, seal, simulate, write
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


@pytest.fixture(scope="module", params=["three_axis", "single_axis"])
def clean(request: pytest.FixtureRequest) -> Simulated:
    return simulate(Case(seed=11, procedure=request.param, dwell_s=15.0))


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


@pytest.mark.parametrize(
    ("procedure", "rate"), [("three_axis", 50), ("single_axis", 100), ("ahrs", 50)]
)
def test_storage_takes_the_recording_and_the_truth_stays_apart(
    tmp_path: Path, procedure: str, rate: int
) -> None:
    made = simulate(case_of("lever_arm", fields={"procedure": procedure, "rate_hz": rate}))
    write(made.recording, tmp_path / "given")
    seal(made.recording, made.sealed, made.truth, tmp_path / "sealed")
    read = read_folder(tmp_path / "given")
    assert np.allclose(read.imu.stack(RATES + FORCES), made.recording.imu.stack(RATES + FORCES))
    assert read.manifest.segments == made.recording.manifest.segments
    assert read.environment is not None
    assert not list((tmp_path / "given").glob("truth*"))
    given = "".join(path.read_text() for path in (tmp_path / "given").glob("*.json"))
    assert "lever_arm" not in given


def test_an_untold_site_is_not_in_the_manifest(tmp_path: Path) -> None:
    made = simulate(case_of("earth_rotation", fields={"site_known": False}))
    write(made.recording, tmp_path)
    station = read_folder(tmp_path).manifest.station
    assert station.latitude_deg is None
    assert station.heading_deg is None
    assert station.gravity_m_s2 == 9.8015


def test_without_a_thermometer_there_is_no_temperature() -> None:
    made = simulate(case_of(fields={"temperature_recorded": False}))
    assert "temperature" not in made.recording.imu.columns
