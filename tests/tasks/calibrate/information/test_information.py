"""What stands beside the items: noise, rates on a line, the truth, nulls with reasons."""

import json

import numpy as np
import pytest

from schemas.calibration import Calibration
from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.information.entry import (
    asymmetry,
    nonlinearity,
    or_why_not,
    pooled_deviation,
    type_b,
    without_type_b,
)
from tasks.calibrate.information.noise import FLOOR
from tasks.specifications.jjf2003 import JJF2003
from tasks.words import say
from tests.manifests import at_station, manifest_of

# What stands beside the items: known noise recovered, the truth found, nulls with a reason.

DEG = float(np.degrees(1.0))
RATE_HZ = 25.0
GYRO_WHITE, ACCEL_WHITE = 5e-5, 4e-4  # rad/s/√Hz, m/s²/√Hz
GYRO_FLOOR = 4e-5  # rad/s, bias instability


def result(recording: Recording) -> Calibration:
    return calibrate(JJF2003, recording, run="r", code_version="v")


def flicker(rng: np.random.Generator, instability: float, count: int) -> np.ndarray:
    """Noise whose Allan deviation is 0.664·instability at all times: S(f) = B²/(π·f)."""
    f = np.fft.rfftfreq(2 * count, 1.0 / RATE_HZ)
    shape = np.zeros(len(f))
    shape[1:] = np.sqrt(instability**2 / np.pi / f[1:] * RATE_HZ / 2.0)
    return np.fft.irfft(np.fft.rfft(rng.normal(size=2 * count)) * shape)[:count]


def resting(seconds: float, seed: int, step: float = 0.0, rests: int = 4) -> Recording:
    """Rests with z up, of a unit with known white noise and flicker; step: rad/s, of gyro_x."""
    rng, count = np.random.default_rng(seed), round(seconds * RATE_HZ)
    rows = np.empty((6, rests * count))
    for channel in range(6):
        white = GYRO_WHITE if channel < 3 else ACCEL_WHITE
        noise = white * np.sqrt(RATE_HZ) * rng.normal(size=rests * count)
        if channel < 3:
            for rest in range(rests):
                within = slice(rest * count, (rest + 1) * count)
                noise[within] += flicker(rng, GYRO_FLOOR, count)
        rows[channel] = noise + (9.8 if channel == 5 else 0.0)
    if step:
        rows[0] = step * np.round(rows[0] / step)
    segments = [
        {"name": f"rest_{n}", "kind": "static", "up": "+z", "t_start": n * seconds,
         "t_end": (n + 1) * seconds} for n in range(rests)
    ]  # fmt: skip
    manifest = manifest_of(
        "resting", {"latitude_deg": 40.0, "gravity_m_s2": 9.8}, segments=segments
    )
    t = np.round(np.arange(rests * count) / RATE_HZ, 9)
    return Recording(manifest, Stream(t, dict(zip(GYRO + ACCEL, rows, strict=True))))


def test_white_noise_and_flicker_are_recovered_within_their_uncertainty():
    walks, floors = [], []
    for seed in range(5):
        found = result(resting(600.0, seed)).information
        for axis in "xyz":
            for name, truth, z in (
                ("gyro_angle_random_walk", 60.0 * DEG * GYRO_WHITE, walks),
                ("accel_velocity_random_walk", ACCEL_WHITE, walks),
                ("gyro_bias_instability", 3600.0 * DEG * GYRO_FLOOR, floors),
            ):
                each = found[name]
                z.append((each.value[axis] - truth) / each.u[axis])
    assert np.mean(np.abs(walks) < 2.0) > 0.85
    assert np.mean(np.abs(floors) < 2.0) > 0.85


def test_the_floor_of_ieee_std_952_is_0_664():
    assert pytest.approx(0.664, abs=5e-4) == FLOOR


def test_short_rests_give_no_bias_instability_and_say_so():
    found = result(resting(4.0, 1)).information
    assert found["gyro_bias_instability"].value == {"x": None, "y": None, "z": None}
    assert "longer rests" in found["gyro_bias_instability"].en
    assert found["gyro_angle_random_walk"].value["x"] is not None


def test_a_step_that_hides_the_noise_leaves_it_null_and_says_so():
    found = result(resting(60.0, 1, step=1e-3)).information["gyro_angle_random_walk"]
    assert found.value["x"] is None
    assert "x: the noise is masked by the output's resolution" in found.en
    assert found.value["y"] is not None


def test_a_channel_that_stands_still_has_no_noise():
    found = result(resting(60.0, 1, step=1.0)).information["gyro_angle_random_walk"]
    assert found.value["x"] is None
    assert found.value["y"] is not None


def test_rests_with_corrupted_rows_are_not_used_for_the_noise():
    recording = resting(60.0, 1)
    recording.imu.columns["gyro_x"][100] = 1e5
    found = result(recording).information["gyro_angle_random_walk"]
    assert "3 rests of 60 s" in found.en
    truth = 60.0 * DEG * GYRO_WHITE
    assert found.value["x"] == pytest.approx(truth, abs=3 * found.u["x"])


def test_rests_with_lost_rows_are_not_used_for_the_noise():
    recording = resting(60.0, 1)
    kept = np.delete(np.arange(len(recording.imu)), [500, 501])
    columns = {name: values[kept] for name, values in recording.imu.columns.items()}
    lossy = Recording(recording.manifest, Stream(recording.imu.t[kept], columns))
    assert "3 rests of 60 s" in result(lossy).information["gyro_angle_random_walk"].en


def test_on_plant_earth_rotation_the_separated_value_finds_the_truth_and_the_clause_does_not(
    plant, shared
):
    truth = json.loads((shared / "plant/plant_earth_rotation/truth.json").read_text())
    recording = plant("plant_earth_rotation", 4)
    g = recording.manifest.station.gravity_m_s2
    calibration = result(recording)
    item = calibration.items["gyro_g_sensitivity"]
    found = calibration.information["gyro_g_sensitivity_without_earth_rotation"]
    for i, axis in enumerate("xyz"):
        true = DEG * truth["parameters"]["G"][i][i] * g
        # The white noise of these rests alone puts xx 2.2 u and yy 2.4 u off the truth.
        assert abs(found.value[axis * 2] - true) < 2.5 * found.u[axis * 2]
        assert abs(item.value[axis * 2] - true) > 2 * item.U[axis * 2]
    assert found.about == "gyro_g_sensitivity"


def test_without_a_latitude_nothing_is_separated(ideal_run):
    found = result(at_station(ideal_run(), latitude_deg=None)).information
    assert "gyro_g_sensitivity_without_earth_rotation" not in found


def test_a_curved_scale_factor_is_found_in_the_rate_points(ideal_run):
    recording = ideal_run()
    columns = dict(recording.imu.columns)
    columns["gyro_x"] = columns["gyro_x"] + 1e-5 * columns["gyro_x"] ** 3
    curved = Recording(recording.manifest, Stream(recording.imu.t, columns), digest="0" * 64)
    found = result(curved).information["gyro_scale_nonlinearity"]
    assert found.value["x"] > 100 * found.value["y"] > 0.0
    assert "Exceeds the noise: x" in found.en


def test_bias_repeatability_is_the_scatter_of_rests_with_the_same_axis_up(ideal_run):
    recording = ideal_run()
    moved = next(s for s in recording.manifest.segments if s.name == "rest2_x")
    columns = {name: values.copy() for name, values in recording.imu.columns.items()}
    rows = recording.imu.rows(moved.t_start, moved.t_end)
    columns["accel_x"][rows] += 0.004
    stepped = Recording(recording.manifest, Stream(recording.imu.t, columns), digest="0" * 64)
    found = result(stepped).information["accel_bias_repeatability"]
    # +x up: two positions, rest_x and rest2_x; one of four off by 0.004; −x up: two alike.
    deviation = np.sqrt(3 * (0.004 / 4) ** 2 + (0.003) ** 2) / np.sqrt(4)
    assert found.value["x"] == pytest.approx(deviation, rel=1e-6)
    assert found.u["x"] == pytest.approx(deviation / np.sqrt(8), rel=1e-6)
    assert found.value["y"] == pytest.approx(0.0, abs=1e-9)
    # Four degrees of freedom: k = 2.87 by Student's t, and k·u reaches below zero.
    assert found.k == pytest.approx(2.869, abs=1e-3)
    assert found.U["x"] is None
    assert "x, y, z: no U stated, because Student's t" in found.en


def test_what_the_rate_points_show_holds_the_type_b_of_the_scale_factor(ideal_run):
    """An ideal run has hardly any noise: what U holds is the table."""
    made = result(ideal_run())
    item, found = made.items["gyro_scale_factor"], made.information["gyro_scale_asymmetry"]
    for axis in "xyz":
        lines = [line for line in item.budgets[axis].inputs if line.kind == "B"]
        table = np.sqrt(sum(line.contribution**2 for line in lines)) / item.value[axis]
        assert found.u[axis] >= 1e6 * np.sqrt(2.0) * table > 0.0
        assert found.U[axis] == pytest.approx(2.0 * found.u[axis])
    assert "type B contributions of the equipment" in found.en


def test_without_a_budget_there_is_no_uncertainty_to_state(ideal_run):
    bare = result(ideal_run()).items["gyro_scale_factor"].model_copy(update={"budgets": {}})
    assert np.isnan(type_b(bare, "xyz")).all()
    assert np.isnan(type_b(None, "xyz")).all()
    (why,) = or_why_not(type_b(bare, "xyz"))
    assert why.id == "information-type-b.not-evaluated"


def test_elements_without_the_equipments_share_are_named_where_others_have_it():
    (why,) = without_type_b(np.array([1e-5, np.nan]), ("xy", "xz"))
    assert say(why, "en").startswith("xz: no U stated")
    assert without_type_b(np.array([np.nan, np.nan]), ("xy", "xz")) == []


def test_deviations_are_pooled_over_groups_by_their_degrees_of_freedom():
    groups = [np.array([1.0, 3.0]), np.array([10.0, 10.0, 13.0]), np.array([5.0])]
    deviation, dof = pooled_deviation(groups)
    assert dof == 3
    assert deviation == pytest.approx(np.sqrt((2.0 + 6.0) / 3.0))
    assert np.isnan(pooled_deviation([np.array([5.0])])[0])


# Non-linearity and asymmetry: planted ones are found in ppm, noise is not taken for one.

RATE = np.radians([-300.0, -200.0, -100.0, -50.0, -10.0, 10.0, 50.0, 100.0, 200.0, 300.0])
FAINT = 1e-16 * np.eye(len(RATE))


def test_a_straight_line_has_neither():
    output = 1.01 * RATE + 0.003
    crooked, lopsided = nonlinearity(RATE, output, FAINT), asymmetry(RATE, output, FAINT)
    assert crooked.value == pytest.approx(0.0, abs=1e-12)
    assert lopsided.value == pytest.approx(0.0, abs=1e-12)
    assert not crooked.significant
    assert not lopsided.significant


def test_a_cubic_term_is_found_as_its_largest_residual_over_full_scale():
    output = RATE + 1e-5 * RATE**3
    found = nonlinearity(RATE, output, FAINT)
    slope, offset = np.polyfit(RATE, output, 1)
    largest = np.abs(output - slope * RATE - offset).max()
    assert found.value == pytest.approx(largest / np.abs(output).max(), rel=1e-9)
    assert found.value > 2e-5
    assert found.significant


def test_asymmetry_is_the_difference_of_the_slopes_over_their_mean():
    output = np.where(RATE > 0, 1.002, 0.999) * RATE + 0.01
    found = asymmetry(RATE, output, FAINT)
    assert found.value == pytest.approx(0.003 / 1.0005, rel=1e-9)
    assert found.significant


def test_a_cubic_term_is_no_asymmetry():
    found = asymmetry(RATE, RATE + 1e-5 * RATE**3, FAINT)
    assert found.value == pytest.approx(0.0, abs=1e-12)


def test_the_uncertainty_of_the_asymmetry_is_its_scatter_and_noise_is_seldom_significant():
    rng = np.random.default_rng(7)
    noise = 1e-5
    found = [
        asymmetry(RATE, RATE + noise * rng.normal(size=len(RATE)), noise**2 * np.eye(len(RATE)))
        for _ in range(2000)
    ]
    z = np.array([each.value / each.u for each in found])
    assert np.std(z) == pytest.approx(1.0, abs=0.05)
    assert 0.003 < np.mean([each.significant for each in found]) < 0.02


def test_noise_is_seldom_a_significant_nonlinearity():
    rng = np.random.default_rng(8)
    noise = 1e-5
    found = [
        nonlinearity(RATE, RATE + noise * rng.normal(size=len(RATE)), noise**2 * np.eye(len(RATE)))
        for _ in range(2000)
    ]
    assert 0.003 < np.mean([each.significant for each in found]) < 0.02


@pytest.mark.parametrize("kept", [RATE > 0, abs(RATE) > 4.0])
def test_without_two_rates_each_way_there_is_no_asymmetry(kept):
    few = RATE[kept]
    assert np.isnan(asymmetry(few, few, 1e-16 * np.eye(len(few))).value)


def test_two_rates_are_always_a_straight_line_and_give_no_nonlinearity():
    few = RATE[[0, -1]]
    assert np.isnan(nonlinearity(few, few, 1e-16 * np.eye(2)).value)


def test_a_gyro_that_reads_nothing_has_neither():
    assert np.isnan(nonlinearity(RATE, 0.0 * RATE, FAINT).value)
    assert np.isnan(asymmetry(RATE, 0.0 * RATE, FAINT).value)
