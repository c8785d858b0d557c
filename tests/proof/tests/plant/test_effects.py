"""Site and geometry: each effect changes what its physics says, and nothing else."""

import json
from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.effects import CATALOGUE, EFFECTS, OUTSIDE
from tests.proof.plant.simulate import NoiseFree, simulate, without_noise
from tests.proof.plant.world import weather
from tests.proof.tests.plant.short_case import case_of, in_segment, noise_free

G = 9.8015


def excess(run: NoiseFree) -> np.ndarray:
    return run.truth - run.nominal


def test_earth_rotation_is_felt_in_the_unit_s_frame_by_gyros_only() -> None:
    run = noise_free(case_of("earth_rotation", fields={"heading_deg": 20.0, "latitude_deg": 31.0}))
    outer, middle, inner = run.table_angles
    unit = Rotation.from_euler("z", -np.radians(20)) * Rotation.from_euler(
        "ZXZ", np.stack([outer, middle, inner], axis=1)
    )
    earth = 7.292115e-5 * np.array([0, np.cos(np.radians(31)), np.sin(np.radians(31))])
    expected = run.unit.Kg @ unit.apply(earth, inverse=True).T
    assert np.abs(excess(run)[:3] - expected).max() < 1e-9
    assert np.abs(excess(run)[3:]).max() < 1e-6  # through ω² alone


def test_gravity_changes_the_force_and_with_it_the_g_sensitive_gyros() -> None:
    run = noise_free(case_of("gravity_value", difference=0.01))
    up = run.reported[3:] / G
    assert np.allclose(excess(run)[3:], run.unit.Ka @ up * 0.01, atol=1e-9)
    assert np.allclose(excess(run)[:3], run.unit.G @ up * 0.01, atol=1e-12)


def test_a_lever_arm_gives_the_centripetal_acceleration_at_constant_rate() -> None:
    r = np.array([0.012, -0.018, 0.007])
    run = noise_free(case_of("lever_arm", r=r.tolist()))
    for axis, name in enumerate(("rate_x_+200", "rate_y_-200", "rate_z_+200")):
        rows = in_segment(run, name)
        turns = np.zeros(3)
        turns[axis] = np.radians(200.0)
        felt = np.cross(turns, np.cross(turns, r))
        assert excess(run)[3:, rows].mean(axis=1) == pytest.approx(run.unit.Ka @ felt, abs=2e-5)
    # the gyros follow through their g-sensitivity alone, one part in a hundred thousand
    assert np.abs(excess(run)[:3]).max() < 3e-5


def test_a_lever_arm_is_felt_in_ramps_across_the_arm() -> None:
    run = noise_free(case_of("lever_arm", r=[0.0, 0.02, 0.0]))
    rows = in_segment(run, "rest_z", 0.5)
    ramp = slice(rows.stop + 50, rows.stop + 50 + 160)  # up to −200 °/s about z in 1.67 s
    spin_up = np.gradient(run.reported[2], 0.01)[ramp]
    across = excess(run)[3, ramp] / run.unit.Ka[0, 0]
    along = run.unit.Ka[0, 1] * -0.02 * run.reported[2, ramp] ** 2
    assert np.abs(across - along - (-0.02 * spin_up)).max() < 2e-3 * np.abs(0.02 * spin_up).max()


def test_each_accelerometer_feels_its_own_place() -> None:
    run = noise_free(case_of("size_effect", r=[[0.0, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.0]]))
    rows = in_segment(run, "rate_z_+200")
    centripetal = -0.01 * np.radians(200.0) ** 2
    felt = np.linalg.solve(run.unit.Ka, excess(run)[3:, rows].mean(axis=1))
    assert felt == pytest.approx([0.0, centripetal, 0.0], abs=2e-6)


def test_a_tilted_base_leans_gravity_and_leaves_the_gyros() -> None:
    run = noise_free(case_of("axis_tilt", east=8e-4, north=-5e-4))
    rows = in_segment(run, "position_+z_000")
    felt = np.linalg.solve(run.unit.Ka, excess(run)[3:, rows].mean(axis=1))
    assert felt[:2] == pytest.approx([5e-4 * G, 8e-4 * G], rel=1e-3)
    assert np.abs(excess(run)[:3]).max() < 1e-6


def test_axes_that_are_not_square_spread_a_rate_over_two_gyros() -> None:
    run = noise_free(case_of("axis_nonorthogonality", angles=[1e-3, 0.0]))
    rows = in_segment(run, "rate_z_+200")
    observation = np.linalg.solve(run.unit.Kg, excess(run)[:3, rows].mean(axis=1))
    assert np.hypot(*observation[:2]) == pytest.approx(1e-3 * np.radians(200.0), rel=1e-3)
    assert abs(observation[2]) < 1e-5


@pytest.mark.parametrize("order", [1, 2])
def test_wobble_tips_gravity_as_often_a_turn_as_it_says(order: int) -> None:
    run = noise_free(case_of("axis_wobble", amplitude=1e-3, order=order, phases=[0.3, 1.2]))
    rows = in_segment(run, "rate_z_+200")
    x, y, _ = np.linalg.solve(run.unit.Ka, excess(run)[3:, rows])
    ground = (x + 1j * y) * np.exp(1j * run.table_angles[0][rows])  # back into the base
    wave = np.exp(1j * order * run.table_angles[0][rows])
    declared = 1e-3 * G * np.imag(wave * np.exp(0.3j))  # tipped about East leans to North
    assert np.std(ground.imag - declared) < 0.01 * 1e-3 * G


def test_compliance_turns_all_sensors_with_rate_squared() -> None:
    C = np.array([[0, 0, 2e-5], [0, 0, 0], [0, 0, 0.0]])
    run = noise_free(case_of("structural_compliance", C=C.tolist()))
    rate, rows = np.radians(200.0), in_segment(run, "rate_z_+200")
    lean = 2e-5 * rate**2
    gyro = np.linalg.solve(run.unit.Kg, excess(run)[:3, rows].mean(axis=1))
    accel = np.linalg.solve(run.unit.Ka, excess(run)[3:, rows].mean(axis=1))
    assert gyro[1] == pytest.approx(lean * rate, rel=1e-2)
    assert accel[1] == pytest.approx(lean * G, rel=1e-2)
    at_rest = in_segment(run, "position_+x_000")
    assert np.abs(excess(run)[:, at_rest]).max() < 1e-9


@pytest.mark.parametrize("procedure", ["three_axis", "single_axis"])
def test_each_fixing_has_its_own_misalignment(procedure: str) -> None:
    case = case_of("remount_misalignment", fields={"procedure": procedure})
    run = noise_free(case)
    vectors = np.array(run.effects[0].parameters["vectors"])
    edges = [0, *(run.plan.fixing_times()[1:] * 100).astype(int), len(run.stamp)]
    for vector, low, high in zip(vectors, edges, edges[1:], strict=False):
        wrong = Rotation.from_rotvec(vector)
        felt = wrong.apply(run.reported[3:, low + 2 : high - 2].T, inverse=True).T
        truth = run.truth[3:, low + 2 : high - 2] - run.unit.Ba[:, None]
        spun = wrong.apply(run.reported[:3, low + 2 : high - 2].T, inverse=True).T
        assert np.abs(truth - run.unit.Ka @ felt - run.unit.P @ spun**2).max() < 1e-6


# Sensors, room and electronics: each effect in its own channels, of the stated size.


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


# Memory, and the physics outside the catalogue.


def test_a_gyro_s_bias_remembers_the_way_it_turned() -> None:
    run = noise_free(case_of("hysteresis", amplitude=[0, 0, 1e-3]))
    for name, sign in (("rate_z_-50", -1), ("rate_z_+50", 1), ("rest2_z", 1)):
        assert excess(run)[2, in_segment(run, name)].mean() == pytest.approx(sign * 1e-3, rel=1e-3)
    assert np.abs(excess(run)[[0, 1, 3, 4, 5]]).max() < 1e-12


def test_a_bias_steps_once() -> None:
    run = noise_free(case_of("bias_step", time=50.0, gyro=[1e-3, 0, 0], accel=[0, 0, 0]))
    assert np.allclose(excess(run)[0], 1e-3 * (run.stamp >= 50.0), atol=1e-9)


def test_a_walk_spreads_with_the_root_of_time() -> None:
    ends = []
    for seed in range(12):
        call = EffectCall(name="bias_random_walk", parameters={"gyro": 1e-5, "accel": 1e-4})
        run = without_noise(Case(seed=seed, procedure="rests", dwell_s=5.0, effects=(call,)))
        ends += list((excess(run)[:, 10000] - excess(run)[:, 0]) / np.repeat([1e-5, 1e-4], 3))
    assert np.std(ends) == pytest.approx(10.0, rel=0.3)


def test_stress_relaxes_after_moves_and_not_after_ramps() -> None:
    run = noise_free(case_of("x_stress_relaxation", accel=[1e-2, 0, 0], tau=2.0))
    at = {
        segment.name: begin
        for segment, begin in zip(run.plan.segments, run.plan.bounds, strict=False)
    }
    start = round(at["position_-y_180"] * 100)
    assert excess(run)[3, start] == pytest.approx(1e-2, rel=1e-6)
    assert excess(run)[3, start + 200] == pytest.approx(1e-2 / np.e, rel=1e-3)
    after_ramp = round(at["rate_x_-50"] * 100)
    assert abs(excess(run)[3, after_ramp]) < 1e-4


def test_the_memory_of_two_moves_ago() -> None:
    run = noise_free(case_of("x_two_moves_ago", share=[1e-3, 0, 0]))
    now = in_segment(run, "position_-x_180")  # before the last rest the unit stood x up
    assert excess(run)[3, now].mean() == pytest.approx(1e-3 * 9.8015, rel=1e-4)
    later = in_segment(run, "position_+y_180")  # before the last rest it stood x down
    assert excess(run)[3, later].mean() == pytest.approx(-1e-3 * 9.8015, rel=1e-4)


def test_cable_drag_shows_at_its_angle_only() -> None:
    run = noise_free(case_of("x_cable_drag", vector=[1e-3, 0, 0], angle=2.0, width=0.25))
    rows = in_segment(run, "rate_z_+50")
    away = np.angle(np.exp(1j * (run.table_angles[0][rows] - 2.0)))
    pulled = np.abs(excess(run)[4, rows])
    assert pulled[np.abs(away) < 0.05].min() > 0.9 * 1e-3 * 9.8
    assert pulled[np.abs(away) > 1.2].max() < 1e-4 * 1e-3 * 9.8 + 2e-6


@pytest.mark.parametrize("name", sorted({*CATALOGUE, *OUTSIDE} - {"gravity_value"}))
def test_every_effect_says_what_it_is_and_changes_what_is_recorded(name: str) -> None:
    run = noise_free(case_of(name, fields={"rate_hz": 25}))
    assert set(run.effects[0].parameters) == set(EFFECTS[name].units)
    assert json.dumps(dict(run.effects[0].parameters))
    assert np.isfinite(run.truth).all()
    assert np.abs(excess(run)).max() > 1e-6


def test_the_catalogue_is_whole_and_what_is_outside_is_marked() -> None:
    assert len(CATALOGUE) == 37
    assert len(OUTSIDE) >= 12


def test_a_case_that_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match="no effect ghost"):
        without_noise(case_of("ghost"))
    with pytest.raises(ValueError, match="several axes"):
        without_noise(case_of("axis_nonorthogonality", fields={"procedure": "single_axis"}))
    with pytest.raises(ValueError, match="stands twice"):
        without_noise(case_of("bias_step", "bias_step"))
    with pytest.raises(ValueError, match="no parameter wrong"):
        without_noise(case_of("bias_step", wrong=1.0))


# Table and clocks: who sees what, and when.


def test_ripple_is_in_the_gyro_and_not_in_the_encoder() -> None:
    run = noise_free(case_of("rate_ripple", depth=1e-3, per_turn=8, phase=0.4))
    clean = noise_free(case_of())
    assert np.array_equal(run.table_rates, clean.table_rates)
    rows = in_segment(run, "rate_z_+200")
    rate = np.radians(200.0)
    ripple = 1e-3 * rate * np.cos(8 * run.table_angles[0][rows] + 0.4)
    observation = np.linalg.solve(run.unit.Kg, (run.truth - run.nominal)[:3, rows])[2]
    assert np.abs(observation - ripple).max() < 0.01 * 1e-3 * rate


def test_eccentricity_is_in_the_encoder_and_not_in_the_unit() -> None:
    run = noise_free(case_of("encoder_eccentricity", amplitude=1e-3, phase=0.4))
    clean = noise_free(case_of())
    assert np.array_equal(run.truth, clean.truth)
    wave = 1e-3 * (np.sin(clean.table_angles[0] + 0.4) - np.sin(0.4))
    assert np.allclose(run.table_angles[0] - clean.table_angles[0], wave, atol=1e-9)
    rows = in_segment(run, "rate_z_+200")
    assert np.ptp(run.table_rates[0, rows]) == pytest.approx(2e-3 * np.radians(200), rel=0.01)


def test_a_long_table_scale_turns_the_unit_less_than_reported() -> None:
    run = noise_free(case_of("table_scale", scale=1e-3))
    assert np.array_equal(run.table_angles, noise_free(case_of()).table_angles)
    rows = in_segment(run, "rate_z_+200")
    gyro = np.linalg.solve(run.unit.Kg, (run.truth - run.nominal)[:3, rows].mean(axis=1))
    assert gyro[2] == pytest.approx(-np.radians(200.0) * 1e-3, rel=2e-3)
    level = in_segment(run, "position_+y_000")
    felt = np.linalg.solve(run.unit.Ka, (run.truth - run.nominal)[3:, level].mean(axis=1))
    assert felt[2] == pytest.approx(9.8015 * 1e-3 * np.pi / 2, rel=2e-3)


def test_late_stamps_show_what_was_before() -> None:
    run, clean = noise_free(case_of("time_offset", seconds=0.02)), noise_free(case_of())
    assert np.allclose(run.truth[:, 2:], clean.truth[:, :-2], atol=1e-9)
    assert np.array_equal(run.table_angles, clean.table_angles)


def test_a_part_of_a_sample_is_interpolated_well() -> None:
    there, clean = noise_free(case_of("time_offset", seconds=0.0037)), noise_free(case_of())
    expected = clean.truth - 0.0037 * np.gradient(clean.truth, 0.01, axis=1)
    moves = slice(1050, 1350)
    change = np.abs(there.truth - clean.truth)[:, moves].max()
    assert np.abs(there.truth - expected)[:, moves].max() < 0.03 * change


def test_a_fast_clock_slips_in_proportion_to_time() -> None:
    run, clean = noise_free(case_of("clock_skew", share=1e-4)), noise_free(case_of())
    slope = np.gradient(clean.truth, 0.01, axis=1)
    late = slice(-3000, -1500)  # the last ramps
    shift = (slope * (run.truth - clean.truth))[:, late].sum() / (slope**2)[:, late].sum()
    assert shift == pytest.approx(-1e-4 * run.stamp[late].mean(), rel=0.1)


def test_accelerometers_are_sampled_one_after_another() -> None:
    run, clean = noise_free(case_of("accel_axis_skew", step=0.01)), noise_free(case_of())
    assert np.allclose(run.truth[:4], clean.truth[:4], atol=1e-9)
    assert np.allclose(run.truth[4, :-1], clean.truth[4, 1:], atol=1e-9)
    assert np.allclose(run.truth[5, :-2], clean.truth[5, 2:], atol=1e-9)


def test_lost_samples_leave_fewer_rows_and_even_stamps() -> None:
    run, clean = (
        noise_free(case_of("dropped_samples", times=[20.0, 60.0], lost=[3, 5])),
        noise_free(case_of()),
    )
    assert run.truth.shape[1] == clean.truth.shape[1] - 8
    assert np.allclose(np.diff(run.stamp), 0.01)
    assert np.array_equal(run.truth[:, :2000], clean.truth[:, :2000])
    assert np.array_equal(run.truth[:, 5997:], clean.truth[:, 6005:])
    assert len(run.table_t) == clean.truth.shape[1]
