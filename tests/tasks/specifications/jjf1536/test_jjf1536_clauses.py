"""Each error planted alone moves its own value and no other; each erratum would be seen."""

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.recording import ANGLE, Recording, Stream
from tasks.specifications.jjf1536 import JJF1536
from tasks.specifications.readings import READINGS
from tests.tasks.items_only import items_only

AXES = "xyz"
OFF = [(i, j) for i in range(3) for j in range(3) if i != j]
DEG = float(np.degrees(1.0))


def result(recording: Recording) -> Calibration:
    return items_only(JJF1536, recording)


def everything(calibration: Calibration) -> dict[str, float | None]:
    return {
        f"{name}.{element}": value
        for name, item in calibration.items.items()
        for element, value in item.value.items()
    }


def expected(**moved: float) -> dict[str, float]:
    base = {f"ahrs_scale_factor.{a}": 1.0 for a in AXES}
    base |= {f"ahrs_zero_offset.{a}": 0.0 for a in AXES}
    base |= {f"ahrs_misalignment.{AXES[i]}{AXES[j]}": 0.0 for i, j in OFF}
    return base | {name.replace("__", "."): value for name, value in moved.items()}


def check(recording: Recording, **moved: float) -> None:
    assert everything(result(recording)) == pytest.approx(expected(**moved), abs=1e-8)


def planted(i: int, j: int, ratio: float) -> np.ndarray:
    matrix = np.zeros((3, 3))
    matrix[i, j] = ratio
    return matrix


def test_an_ideal_unit_on_the_turning_earth_has_scale_factor_one_and_nothing_else(ahrs_run):
    check(ahrs_run())


@pytest.mark.parametrize("i", range(3))
def test_scale_factor_moves_alone(ahrs_run, i):
    check(ahrs_run(K=1 + 0.01 * np.eye(3)[i]), **{f"ahrs_scale_factor__{AXES[i]}": 1.01})


@pytest.mark.parametrize("i", range(3))
def test_zero_offset_moves_alone(ahrs_run, i):
    check(ahrs_run(B=0.02 * np.eye(3)[i]), **{f"ahrs_zero_offset__{AXES[i]}": 0.02})


@pytest.mark.parametrize(("i", "j"), OFF)
def test_misalignment_moves_alone_and_is_named_by_the_axis_that_reads(ahrs_run, i, j):
    element = f"ahrs_misalignment__{AXES[i]}{AXES[j]}"
    check(ahrs_run(L=planted(i, j, 0.001)), **{element: 0.001 * DEG})


def test_a_tilted_axis_is_read_with_the_scale_factor_of_the_axis_that_reads(ahrs_run):
    budgets = result(ahrs_run(K=(1.0, 1.5, 1.0))).items["ahrs_misalignment"].budgets
    for element, scale in (("yx", 1.5), ("zx", 1.0)):
        (tilt,) = (line for line in budgets[element].inputs if line.symbol == "α4")
        assert tilt.sensitivity == pytest.approx(scale * DEG, rel=1e-6)


def test_rates_as_input_give_the_same_values(ahrs_run, as_gyro):
    errors = {"K": (1.01, 0.99, 1.002), "L": planted(2, 0, 0.002), "B": (0.01, -0.02, 0.03)}
    recording = ahrs_run(**errors)
    by_rate = result(as_gyro(recording))
    assert everything(by_rate) == pytest.approx(everything(result(recording)), abs=1e-8)
    assert "jjf1536.output_rate" not in by_rate.items["ahrs_scale_factor"].readings
    assert "jjf1536.output_rate" in result(recording).items["ahrs_scale_factor"].readings


def test_units_clauses_and_uncertainties_are_told(ahrs_run):
    calibration = result(ahrs_run())
    assert calibration.method == "jjf1536"
    assert [item.unit for item in calibration.items.values()] == ["1", "deg/s", "deg"]
    for item in calibration.items.values():
        assert item.clause.startswith("JJF 1536-2015, 7.")
        assert all(u is not None and u > 0 for u in item.u.values())
        doubled = {name: 2 * u for name, u in item.u.items()}
        assert dict(item.U) == pytest.approx(doubled)
    assert calibration.unavailable == {}


def test_every_reading_that_an_item_names_is_in_the_register(ahrs_run):
    named = {name for item in result(ahrs_run()).items.values() for name in item.readings}
    assert named
    assert named | {"jjf1536.product", "jjf1536.attitude"} <= set(READINGS)


def test_the_sensitivity_of_eq_a4_is_one_over_4_t(bench):
    noise, seconds = 1e-4, 100.0  # rad of each reading, two readings a position
    made = bench()
    for points in ("ENU", "ESD", "WSU", "WND"):
        made.position("x", points, seconds)
    u = result(made.recording(angle_noise=noise)).items["ahrs_zero_offset"].u["x"]
    output = DEG * noise * np.sqrt(2)
    assert u == pytest.approx(np.sqrt(4) * output / (4 * seconds), rel=0.2)


def test_a_recording_without_angles_and_rates_is_refused_in_one_sentence(ahrs_run):
    recording = ahrs_run()
    columns = {name: recording.imu.columns[name] for name in ANGLE[:2]}
    lacking = Recording(recording.manifest, Stream(recording.imu.t, columns))
    with pytest.raises(Unusable, match="neither angle_x, angle_y, angle_z nor gyro"):
        result(lacking)


def test_angles_in_degrees_make_a_run_invalid_without_a_scale_factor(ahrs_run):
    recording = ahrs_run()
    columns = {name: np.degrees(recording.imu.columns[name]) for name in ANGLE}
    answer = result(Recording(recording.manifest, Stream(recording.imu.t, columns)))
    assert (answer.remarks[0].code, answer.remarks[0].run) == ("rate_unit", "invalid")
    assert set(answer.items["ahrs_scale_factor"].value.values()) == {None}
