"""Site and geometry: each effect changes what its physics says, and nothing else."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.proof.plant.simulate import NoiseFree
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
