"""The joint method on turntable recordings: ideal, simulated with a truth, and real ones."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from imucal import FerrarisCalibration, FerrarisSignalRegions

from schemas.base import Unusable
from schemas.calibration import Calibration, Item
from schemas.recording import ACCEL, AXES, GYRO, Recording
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.joint import JOINT
from tests.manifests import at_station
from tests.tasks.items_only import items_only
from tests.tasks.specifications.plant_truth import off_the_truth


def by_joint(recording: Recording) -> Calibration:
    return items_only(JOINT, recording)


def by_clauses(recording: Recording) -> Calibration:
    return items_only(JJF2003, recording)


def codes(calibration: Calibration) -> set[str]:
    return {remark.code for remark in calibration.remarks}


def without_latitude(recording: Recording) -> Recording:
    return at_station(recording, latitude_deg=None)


@pytest.fixture(scope="module")
def results(plant) -> Callable[[str], tuple[Calibration, Calibration]]:
    """Both methods on a simulated recording, computed once."""

    @cache
    def both(name: str) -> tuple[Calibration, Calibration]:
        recording = plant(name, 4)
        return by_joint(recording), by_clauses(recording)

    return both


def comparable(item: Item, name: str, removed: bool = True) -> tuple[dict, dict]:
    """Values and uncertainties of a clause's item that mean the same in the joint method."""
    if removed and name == "gyro_g_sensitivity" and item.value_without_earth_rotation is not None:
        without_earth = item.value_without_earth_rotation
        if any(value is not None for value in without_earth.values()):
            return without_earth, item.u_without_earth_rotation
    return item.value, item.u


def off_the_clauses(found: Calibration, clauses: Calibration) -> dict[str, float]:
    """Difference of both methods over its standard uncertainty, every element."""
    off = {}
    for name, item in found.items.items():
        value, u = comparable(clauses.items[name], name, "earth_removed" in codes(found))
        for element in item.value:
            difference = item.value[element] - value[element]
            off[f"{name}.{element}"] = difference / np.hypot(item.u[element], u[element])
    return off


def planted(base: float, scale: float, seed: int) -> np.ndarray:
    return base * np.eye(3) + scale * np.random.default_rng(seed).standard_normal((3, 3))


def test_both_methods_give_the_same_of_an_ideal_run(ideal_run):
    p = planted(0.0, 1e-3, 5)
    np.fill_diagonal(p, 0.0)
    recording = ideal_run(
        Kg=planted(1.0, 0.01, 1), Bg=np.array([1e-3, -2e-3, 3e-3]), G=planted(0.0, 1e-5, 2),
        Ka=planted(1.0, 0.01, 3), Ba=np.array([0.1, 0.2, -0.3]), P=p,
    )  # fmt: skip
    found, clauses = by_joint(recording), by_clauses(recording)
    for name, item in found.items.items():
        expected = comparable(clauses.items[name], name)[0]
        assert item.value == pytest.approx(expected, abs=3e-7), name
    model = clauses.items["accel_rate_sensitivity"].value_model
    assert found.items["accel_rate_sensitivity"].value_model == pytest.approx(model, abs=3e-7)


def test_both_methods_agree_on_clean_data_within_their_uncertainties(results):
    off = off_the_clauses(*results("plant_clean"))
    assert len(off) == 42
    assert max(map(abs, off.values())) < 1.0


def test_where_the_rests_refute_earth_rotation_it_is_not_taken_off(results, plant):
    """The clean plant stands on an Earth that does not turn, whatever its latitude."""
    found, clauses = results("plant_clean")
    gravity = plant("plant_clean", 4).manifest.station.gravity_m_s2
    off = off_the_truth("plant_clean", found, gravity)
    assert max(abs(off[f"gyro_g_sensitivity.{a}{a}"]) for a in AXES) < 3.0
    assert "earth_rotation_not_shown" in codes(found) & codes(clauses)
    assert not {"earth_removed", "earth_rotation"} & (codes(found) | codes(clauses))
    item = found.items["gyro_g_sensitivity"]
    assert item.value_without_earth_rotation == item.value


def without_heading(recording: Recording) -> Recording:
    return at_station(recording, heading_deg=None)


def test_the_horizontal_part_of_earth_rotation_is_no_scatter_where_north_is_not_told(
    results, plant
):
    """The pairs at 180° cancel it: the uncertainties stay those of the noise, within twice."""
    result = results("plant_earth_rotation")[0]
    blind = by_joint(without_heading(plant("plant_earth_rotation", 4)))
    remarks = [remark.en for remark in blind.remarks if remark.code == "excess_scatter"]
    assert not any("gyro" in text for text in remarks)
    for name in ("gyro_bias", "gyro_g_sensitivity"):
        for element, u in blind.items[name].u.items():
            assert u < 2.0 * result.items[name].u[element], (name, element)


def test_without_a_latitude_clean_data_follow_the_model_within_their_noise(plant):
    """The clean plant stands on an Earth that does not turn: nothing may be removed."""
    recording = without_latitude(plant("plant_clean", 4))
    found = by_joint(recording)
    gravity = recording.manifest.station.gravity_m_s2
    off = off_the_truth("plant_clean", found, gravity)
    assert max(map(abs, off.values())) < 3.0
    assert "earth_not_removed" in codes(found)
    assert set(found.items["gyro_g_sensitivity"].value_without_earth_rotation.values()) == {None}


def test_earth_rotation_is_not_in_the_g_sensitivity(results, plant):
    found, clauses = results("plant_earth_rotation")
    gravity = plant("plant_earth_rotation", 4).manifest.station.gravity_m_s2
    off = off_the_truth("plant_earth_rotation", found, gravity)
    # One of 42 values, a p, lies 3.3 u off: of as many normal ones one in 25 runs does.
    assert max(map(abs, off.values())) < 3.5
    separated = [z for name, z in off.items() if name.startswith("gyro_g_sensitivity")]
    assert len(separated) == 9
    assert max(map(abs, separated)) < 2.5
    assert np.sqrt(np.mean(np.square(separated))) < 1.3
    by_clause = off_the_truth("plant_earth_rotation", clauses, gravity)
    assert all(by_clause[f"gyro_g_sensitivity.{a}{a}"] > 5 for a in AXES)
    item = found.items["gyro_g_sensitivity"]
    assert item.value_without_earth_rotation == item.value
    assert "joint.g_earth" in item.readings
    shown = calibrate(JOINT, plant("plant_earth_rotation", 4), run="", code_version="").information
    assert "gyro_g_sensitivity_without_earth_rotation" not in shown


@pytest.mark.parametrize(
    "name", ["plant_tilt_and_temperature", "plant_time_offset", "plant_unlisted"]
)
def test_omitted_physics_leaves_every_item_with_a_value(plant, name):
    found = by_joint(plant(name, 4))
    values = [value for item in found.items.values() for value in item.value.values()]
    assert len(values) == 42
    assert None not in values
    assert not found.unavailable


def test_every_uncertainty_is_a_budget_with_the_equipment_in_it(results):
    items = results("plant_earth_rotation")[0].items
    for name, item in items.items():
        assert item.uncertainty_kind == "GUM"
        for element, u in item.u.items():
            assert item.budgets[element].u_c == pytest.approx(u), name
    symbols = {
        name: {line.symbol for line in item.budgets[next(iter(item.budgets))].inputs}
        for name, item in items.items()
    }
    assert {"u_A", "ε1", "ε2"} <= symbols["gyro_scale_factor"]
    assert {"u_A", "α1", "α2", "α3", "α4"} <= symbols["gyro_cross_coupling"]
    assert {"u_A", "φ"} <= symbols["gyro_g_sensitivity"]
    assert {"u_A", "g"} <= symbols["accel_scale_factor"]


def test_type_b_agrees_with_that_of_the_clauses_where_the_clauses_are_the_same(results):
    found, clauses = results("plant_clean")

    def contribution(calibration: Calibration, name: str, element: str, symbol: str) -> float:
        lines = calibration.items[name].budgets[element].inputs
        return sum(line.contribution for line in lines if line.symbol == symbol)

    for name, element, symbol in (
        ("gyro_scale_factor", "x", "ε1"), ("gyro_scale_factor", "x", "ε2"),
        ("gyro_cross_coupling", "xy", "α4"), ("accel_scale_factor", "y", "g"),
        ("accel_rate_sensitivity", "xy", "ε1"), ("accel_cross_coupling", "xz", "α4"),
    ):  # fmt: skip
        ours, theirs = (contribution(each, name, element, symbol) for each in (found, clauses))
        assert ours == pytest.approx(theirs, rel=0.5), (name, symbol)
        assert ours > 0


def test_conditions_of_the_claims_are_remarks(results, real):
    text = codes(results("plant_clean")[0])
    assert {"orientations_not_turned", "rates_not_rising", "earth_rotation_not_shown"} <= text
    few = by_joint(real("vn200_imu0_rate_table"))
    assert {"number_of_rates", "disturbed", "one_heading"} <= codes(few)
    remark = next(r for r in few.remarks if r.code == "number_of_rates")
    assert "+x 2, -x 2" in remark.en
    assert remark.blocks_pass


def test_vn200_gives_the_gyro_from_the_turns_and_the_accelerometers_from_the_rests(real):
    found, clauses = (method(real("vn200_imu0_rate_table")) for method in (by_joint, by_clauses))
    for name in ("gyro_scale_factor", "gyro_cross_coupling", "gyro_fit_offset"):
        assert found.items[name].value == pytest.approx(clauses.items[name].value, abs=3e-5)
    for name in ("accel_scale_factor", "accel_cross_coupling"):
        item = found.items[name]
        off = {e: abs(v - clauses.items[name].value[e]) / item.u[e] for e, v in item.value.items()}
        assert max(off.values()) < 1.0
    for name in ("gyro_bias", "gyro_g_sensitivity", "accel_rate_sensitivity"):
        assert set(found.items[name].value.values()) == {None}
        assert name in found.unavailable


def test_ln100_has_its_g_sensitivity_without_earth_rotation_and_null_where_north_is_needed(real):
    found = by_joint(real("ln100_two_position"))
    item = found.items["gyro_g_sensitivity"]
    assert item.value["xx"] * 3600 == pytest.approx(0.03, abs=0.005)
    assert {e for e, v in item.value.items() if v is not None} == {"xx"}
    assert "north is not stated" in found.unavailable["gyro_g_sensitivity"]
    assert {"north_unknown", "scale_factor_assumed", "positions_missing"} <= codes(found)


def test_labels_that_gravity_contradicts_are_not_believed(real):
    found = by_joint(real("vn200_57630_six_position"))
    assert "axes" in {r.code for r in found.remarks if r.run == "invalid"}
    ideal = {"x": 1.0, "y": 1.0, "z": 1.0}
    assert found.items["accel_scale_factor"].value == pytest.approx(ideal, abs=0.002)


def by_imucal(recording: Recording, cut: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gyro matrix, gyro bias (deg/s) and accelerometer matrix, every region `cut` rows shorter."""
    regions = {}
    for segment in recording.manifest.segments:
        rows = recording.imu.rows(segment.t_start, segment.t_end)
        rows = slice(rows.start, rows.stop - cut)
        regions[f"acc_{segment.name}"] = recording.imu.stack(ACCEL, rows)
        regions[f"gyr_{segment.name}"] = np.degrees(recording.imu.stack(GYRO, rows))
    theirs = FerrarisCalibration(expected_angle=-360).compute(
        FerrarisSignalRegions(**regions), 102.4, from_acc_unit="m/s^2", from_gyr_unit="deg/s"
    )
    return theirs.K_g @ theirs.R_g, theirs.b_g, theirs.K_a @ theirs.R_a


def test_ferraris_session_lies_within_the_spread_of_imucal(real):
    """The spread: what imucal's answer moves by when the turns by hand end 50 ms earlier."""
    recording = real("ferraris_session")
    found = by_joint(recording).items
    (k_gyro, bias, k_accel), (shorter, _, _) = by_imucal(recording, 0), by_imucal(recording, 5)
    spread = np.abs(np.diag(shorter - k_gyro)).max()
    ours = np.array([found["gyro_scale_factor"].value[axis] for axis in AXES])
    assert spread < 0.002
    assert np.abs(ours - np.diag(k_gyro)).max() < spread
    assert found["gyro_bias"].value == pytest.approx(dict(zip(AXES, bias, strict=True)), abs=2e-3)
    # One fit over all six rests; imucal takes each axis from its own two.
    assert found["accel_scale_factor"].value == pytest.approx(
        dict(zip(AXES, np.diag(k_accel), strict=True)), abs=3e-4
    )


def test_a_recording_that_never_rests_nor_turns_steadily_has_reasons_only(real):
    found = by_joint(real("encoder_mpu6050_pitch_slow"))
    assert set(found.unavailable) == set(found.items)


def test_accumulated_angles_belong_to_another_method(plant):
    with pytest.raises(Unusable, match="--method jjf1536"):
        by_joint(plant("ahrs_clean"))
