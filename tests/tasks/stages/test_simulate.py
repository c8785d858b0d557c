"""A simulated run is what models (1) and (2) with a calibration's values read."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.orders import SimulateOrder
from schemas.recording import ACCEL, GYRO, Recording
from storage.catalogue import runs
from storage.formats.folder import read_folder
from storage.home import Home
from tasks.calibrate.calibrate import calibrate
from tasks.coefficients.correct import model_values
from tasks.specifications.jjf2003 import JJF2003
from tasks.stages.correct import simulate_run, simulated_recording
from tasks.stages.explain import simulated_readings

CHANNELS = GYRO + ACCEL
RNG = np.random.default_rng(3)
UNIT = {
    "Kg": np.eye(3) + 1e-3 * RNG.standard_normal((3, 3)), "Bg": 1e-3 * RNG.standard_normal(3),
    "G": 1e-6 * RNG.standard_normal((3, 3)), "Ka": np.eye(3) + 1e-3 * RNG.standard_normal((3, 3)),
    "Ba": 0.01 * RNG.standard_normal(3), "P": 1e-3 * (1 - np.eye(3)) * RNG.standard_normal((3, 3)),
}  # fmt: skip


def order_into(folder: Path) -> SimulateOrder:
    return SimulateOrder(run="", out=str(folder / "simulated"))


def calibrated(recording: Recording) -> Calibration:
    return calibrate(JJF2003, recording, run="", code_version="")


def test_the_units_own_readings_come_back(ideal_run: Callable[..., Recording]) -> None:
    """Every element, unit and sign: by plain algebra there, by the items and the terms here."""
    recording = ideal_run(dwell=10.0, **UNIT)
    values, assumed = model_values(calibrated(recording))
    made = simulated_recording(recording, values)
    assert assumed == ()
    np.testing.assert_array_equal(made.imu.t, recording.imu.t)
    read, simulated = recording.imu.stack(CHANNELS), made.imu.stack(CHANNELS)
    # Each rate about its axis is simulated from the items, which the clauses fit to 1e-6.
    np.testing.assert_allclose(simulated[:, :3], read[:, :3], atol=2e-6)
    np.testing.assert_allclose(simulated[:, 3:], read[:, 3:], atol=2e-5)


def test_rate_sensitivity_without_the_models_sign_is_turned(ideal_run) -> None:
    recording = ideal_run(dwell=10.0, **UNIT)
    calibration = calibrated(recording)
    item = calibration.items["accel_rate_sensitivity"].model_copy(update={"value_model": None})
    plain = calibration.model_copy(
        update={"items": calibration.items | {"accel_rate_sensitivity": item}}
    )
    np.testing.assert_array_equal(model_values(plain)[0], model_values(calibration)[0])


def test_a_run_whose_motion_nothing_tells_is_refused(ideal_run) -> None:
    recording = ideal_run(dwell=1.0)
    bare = replace(recording, manifest=recording.manifest.model_copy(update={"segments": None}))
    with pytest.raises(Unusable, match="neither encoders nor a pose nor labels"):
        simulated_recording(bare, model_values(calibrated(recording))[0])


def test_folder_is_a_recording_marked_as_simulated_with_the_same_rows(
    ideal_run, home: Home, tmp_path: Path
) -> None:
    recording = ideal_run(dwell=2.0, **UNIT)
    run, _ = runs.add(recording, home)
    made = simulate_run(run, home, order_into(tmp_path))
    written = read_folder(made.folder)
    assert (written.manifest.model_extra or {})["simulated"] is True
    assert written.manifest.recording_id == "ideal_simulated"
    assert (made.rows, made.rows_left_out) == (len(recording.imu), 0)
    np.testing.assert_array_equal(written.imu.t, recording.imu.t)
    with pytest.raises(Unusable, match="name a new folder"):
        simulate_run(run, home, order_into(tmp_path))


def test_rows_between_those_of_a_simulation_are_interpolated(ideal_run, home, tmp_path) -> None:
    recording = ideal_run(dwell=2.0)
    run, _ = runs.add(recording, home)
    made = simulate_run(run, home, order_into(tmp_path))
    between = replace(recording, imu=replace(recording.imu, t=recording.imu.t + 0.05))
    readings = simulated_readings(between, made.folder, read_folder(made.folder))
    given = read_folder(made.folder).imu.stack(CHANNELS)
    np.testing.assert_allclose(readings[:-1], (given[:-1] + given[1:]) / 2, atol=1e-12)
    assert np.isnan(readings[-1]).all()


def test_simulation_of_another_time_is_refused(ideal_run, home, tmp_path) -> None:
    recording = ideal_run(dwell=2.0)
    run, _ = runs.add(recording, home)
    made = simulate_run(run, home, order_into(tmp_path))
    later = replace(recording, imu=replace(recording.imu, t=recording.imu.t + 1e4))
    with pytest.raises(Unusable, match="0 % of the rows"):
        simulated_readings(later, made.folder, read_folder(made.folder))


PATH = Path("other")


def test_a_simulation_of_another_motion_is_refused_by_its_table(plant) -> None:
    recording = plant("plant_clean")
    table = recording.table
    turned = {name: column + (name == "inner_angle") for name, column in table.columns.items()}
    other = replace(recording, table=replace(table, columns=turned))
    with pytest.raises(Unusable, match=r"other: its table holds inner_angle at .* 100 % of the"):
        simulated_readings(recording, PATH, other)


def test_a_simulation_without_a_table_is_refused_by_its_rates(plant) -> None:
    recording = plant("plant_clean")
    later = {name: np.roll(column, 6000) for name, column in recording.imu.columns.items()}
    other = replace(recording, table=None, imu=replace(recording.imu, columns=later))
    with pytest.raises(Unusable, match="other: its gyro_\\* reads a rate of"):
        simulated_readings(recording, PATH, other)


def test_whole_turns_exchanged_axes_and_a_small_delay_are_the_same_motion(plant) -> None:
    recording = plant("plant_clean")
    imu, table = recording.imu, recording.table
    more = {name: c + 2 * np.pi * name.endswith("_angle") for name, c in table.columns.items()}
    exchanged = {**imu.columns, "gyro_x": imu.columns["gyro_y"], "gyro_y": imu.columns["gyro_x"]}
    other = replace(
        recording, imu=replace(imu, columns=exchanged),
        table=replace(table, columns=more, t=table.t + 0.01),
    )  # fmt: skip
    simulated_readings(recording, PATH, other)
