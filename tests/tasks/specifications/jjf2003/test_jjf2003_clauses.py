"""Each error term planted alone: its own value moves, and no other."""

import numpy as np
import pytest

from schemas.calibration import Calibration
from schemas.recording import Recording
from tasks.specifications.jjf2003 import JJF2003
from tests.manifests import at_station, relabelled
from tests.tasks.items_only import items_only

AXES = "xyz"
OFF = [(i, j) for i in range(3) for j in range(3) if i != j]
GRAVITY = 9.78


def result(recording: Recording) -> Calibration:
    return items_only(JJF2003, recording)


def everything(calibration: Calibration) -> dict[str, float]:
    return {
        f"{name}.{element}": value
        for name, item in calibration.items.items()
        for element, value in item.value.items()
    }


def expected(**moved: float) -> dict[str, float]:
    base = {f"gyro_scale_factor.{a}": 1.0 for a in AXES}
    base |= {f"accel_scale_factor.{a}": 1.0 for a in AXES}
    base |= {f"{n}.{a}": 0.0 for n in ("gyro_fit_offset", "gyro_bias", "accel_bias") for a in AXES}
    for name in ("gyro_cross_coupling", "accel_cross_coupling", "accel_rate_sensitivity"):
        base |= {f"{name}.{AXES[i]}{AXES[j]}": 0.0 for i, j in OFF}
    base |= {f"gyro_g_sensitivity.{a}{b}": 0.0 for a in AXES for b in AXES}
    return base | {name.replace("__", "."): value for name, value in moved.items()}


def planted(i: int, j: int, value: float, base: float = 0.0) -> np.ndarray:
    matrix = base * np.eye(3)
    matrix[i, j] += value
    return matrix


def check(recording: Recording, **moved: float) -> None:
    assert everything(result(recording)) == pytest.approx(expected(**moved), abs=2e-7)


def test_an_ideal_unit_has_scale_factor_one_and_nothing_else(ideal_run):
    check(ideal_run())


@pytest.mark.parametrize("i", range(3))
@pytest.mark.parametrize("j", range(3))
def test_gyro_scale_and_cross_coupling_move_alone(ideal_run, i, j):
    name = f"gyro_scale_factor__{AXES[i]}" if i == j else f"gyro_cross_coupling__{AXES[i]}{AXES[j]}"
    check(ideal_run(Kg=planted(i, j, 0.01, 1.0)), **{name: 0.01 + (i == j)})


@pytest.mark.parametrize("i", range(3))
@pytest.mark.parametrize("j", range(3))
def test_accel_scale_and_cross_coupling_move_alone(ideal_run, i, j):
    kind = "scale_factor" if i == j else "cross_coupling"
    element = AXES[i] if i == j else AXES[i] + AXES[j]
    check(ideal_run(Ka=planted(i, j, 0.01, 1.0)), **{f"accel_{kind}__{element}": 0.01 + (i == j)})


@pytest.mark.parametrize("i", range(3))
def test_gyro_bias_shows_in_the_bias_and_in_the_fit_offset(ideal_run, i):
    bias = np.eye(3)[i] * np.radians(0.2)
    moved = {f"gyro_bias__{AXES[i]}": 0.2, f"gyro_fit_offset__{AXES[i]}": 0.2}
    check(ideal_run(Bg=bias), **moved)


@pytest.mark.parametrize("i", range(3))
def test_accel_bias_moves_alone(ideal_run, i):
    check(ideal_run(Ba=np.eye(3)[i] * 0.05), **{f"accel_bias__{AXES[i]}": 0.05})


@pytest.mark.parametrize("i", range(3))
@pytest.mark.parametrize("j", range(3))
def test_g_sensitivity_is_per_local_g(ideal_run, i, j):
    per_g = 0.01
    moved = {f"gyro_g_sensitivity__{AXES[i]}{AXES[j]}": per_g}
    if i == j:  # turning about the vertical, the axis feels one g throughout: eq. (4) keeps it
        moved[f"gyro_fit_offset__{AXES[i]}"] = per_g
    check(ideal_run(G=planted(i, j, np.radians(per_g) / GRAVITY)), **moved)


@pytest.mark.parametrize(("i", "j"), OFF)
def test_rate_sensitivity_by_eq_12_has_the_opposite_sign_of_model_2(ideal_run, i, j):
    p = 0.0005
    calibration = result(ideal_run(P=planted(i, j, p)))
    element = AXES[i] + AXES[j]
    moved = expected(**{f"accel_rate_sensitivity__{element}": -p})
    assert everything(calibration) == pytest.approx(moved, abs=2e-7)
    item = calibration.items["accel_rate_sensitivity"]
    assert item.value_model[element] == pytest.approx(p, abs=1e-9)
    assert item.unit == "m"
    assert {"jjf2003.p_sign", "jjf2003.p_lever_arm"} <= set(item.readings)


def test_the_largest_rate_is_the_one_of_the_rate_sensitivity(ideal_run):
    recording = ideal_run(P=planted(1, 0, 0.0005))
    trimmed = relabelled(recording, lambda s: {} if abs(s.rate_deg_s or 0.0) < 60 else None)
    value = result(trimmed).items["accel_rate_sensitivity"]
    full = result(recording).items["accel_rate_sensitivity"]
    assert value.value["yx"] == pytest.approx(full.value["yx"], rel=1e-3)


def test_a_missing_position_leaves_null_and_says_which(ideal_run):
    recording = ideal_run()
    calibration = result(relabelled(recording, lambda s: None if s.up in ("+y", "-y") else {}))
    item = calibration.items["gyro_g_sensitivity"]
    assert item.value["xy"] is None
    assert item.u["xy"] is None
    assert item.value["xx"] == pytest.approx(0.0, abs=1e-7)
    assert "+y, -y" in calibration.unavailable["gyro_g_sensitivity"]
    assert any(r.code == "positions_missing" and r.blocks_pass for r in calibration.remarks)


def test_too_few_rates_are_warned_of(ideal_run):
    recording = ideal_run()
    quick = relabelled(recording, lambda s: {} if abs(s.rate_deg_s or 99.0) > 60 else None)
    calibration = result(quick)
    warned = [r for r in calibration.remarks if r.code == "number_of_rates"]
    assert len(warned) == 3
    assert all(r.blocks_pass and "6 rates" in r.en for r in warned)


def test_unknown_gravity_leaves_the_ratio_to_gravity_null_but_not_the_bias(ideal_run):
    recording = ideal_run(Ba=np.array([0.05, 0.0, 0.0]))
    calibration = result(at_station(recording, gravity_m_s2=None))
    assert calibration.items["accel_scale_factor"].value == {"x": None, "y": None, "z": None}
    assert "gravity" in calibration.unavailable["accel_scale_factor"]
    assert calibration.items["accel_bias"].value["x"] == pytest.approx(0.05, abs=1e-7)


def test_unknown_latitude_leaves_the_value_without_earth_rotation_null(ideal_run):
    recording = ideal_run()
    calibration = result(at_station(recording, latitude_deg=None))
    item = calibration.items["gyro_g_sensitivity"]
    assert set(item.value_without_earth_rotation.values()) == {None}
    assert "latitude" in calibration.unavailable["gyro_g_sensitivity"]
