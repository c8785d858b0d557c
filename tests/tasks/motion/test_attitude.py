"""Heading, pitch and roll there and back: JJF 1536-2015, Appendix B with (B.4) corrected."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tasks.motion.attitude import attitude_of, strapdown_matrix, to_navigation

TURN = st.floats(-np.pi, np.pi, allow_nan=False)
PITCH = st.floats(-np.pi / 2, np.pi / 2, allow_nan=False)


def turned(angle: float, axis: int) -> np.ndarray:
    """The elementary turn about one axis, written out."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = (
        [[1, 0, 0], [0, c, -s], [0, s, c]],
        [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    )
    return np.array([x, y, z][axis])


def apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distance of two angles, whole turns not counted."""
    return np.abs((np.asarray(a) - b + np.pi) % (2 * np.pi) - np.pi)


def test_b1_is_heading_about_up_then_pitch_about_x_then_roll_about_y() -> None:
    heading, pitch, roll = 0.7, -0.4, 2.1
    expected = turned(heading, 2) @ turned(pitch, 0) @ turned(roll, 1)
    assert strapdown_matrix(heading, pitch, roll) == pytest.approx(expected, abs=1e-15)


def test_a_million_random_attitudes_return_over_all_quadrants() -> None:
    random = np.random.default_rng(1536)
    heading, roll = random.uniform(-np.pi, np.pi, (2, 1_000_000))
    pitch = np.arcsin(random.uniform(-1, 1, 1_000_000))
    found = attitude_of(strapdown_matrix(heading, pitch, roll))
    assert found.separable.all()
    near = 1e-15 / np.cos(pitch)  # what rounding of the matrix costs
    assert np.all(apart(found.heading, heading) < 1e-14 + near)
    assert np.all(apart(found.roll, roll) < 1e-14 + near)
    assert np.abs(found.pitch - pitch).max() < 1e-14


@given(TURN, PITCH, TURN)
def test_the_angles_found_give_the_same_matrix(heading: float, pitch: float, roll: float) -> None:
    matrix = strapdown_matrix(heading, pitch, roll)
    found = attitude_of(matrix)
    again = strapdown_matrix(found.heading, found.pitch, found.roll)
    assert again == pytest.approx(matrix, abs=3e-8)


@given(TURN, PITCH, TURN)
def test_the_angles_return_wherever_they_are_separable(
    heading: float, pitch: float, roll: float
) -> None:
    found = attitude_of(strapdown_matrix(heading, pitch, roll))
    assert found.pitch == pytest.approx(pitch, abs=1e-14)
    if found.separable:
        tolerance = 1e-14 + 1e-15 / np.cos(pitch)
        assert apart(found.heading, heading) < tolerance
        assert apart(found.roll, roll) < tolerance


@given(TURN, TURN, st.sampled_from([1.0, -1.0]))
def test_at_90_degrees_the_combination_stays_and_the_flag_says_so(
    heading: float, roll: float, sign: float
) -> None:
    found = attitude_of(strapdown_matrix(heading, sign * np.pi / 2, roll))
    assert not found.separable
    assert found.roll == 0.0
    assert found.pitch == pytest.approx(sign * np.pi / 2, abs=1e-15)
    assert apart(found.heading, heading + sign * roll) < 1e-14


def test_a_ten_thousandth_of_a_degree_from_90_they_are_still_separable() -> None:
    found = attitude_of(strapdown_matrix(1.0, np.radians(89.9999), -2.0))
    assert found.separable
    assert (float(found.heading), float(found.roll)) == pytest.approx((1.0, -2.0), abs=1e-9)


@pytest.mark.parametrize("heading", [-2.5, -0.5, 0.5, 2.5])
@pytest.mark.parametrize("roll", [-2.5, -0.5, 0.5, 2.5])
def test_b4_as_printed_does_not_return_the_angles(heading: float, roll: float) -> None:
    matrix = strapdown_matrix(heading, 0.3, roll)
    found = attitude_of(matrix)
    assert (float(found.heading), float(found.roll)) == pytest.approx((heading, roll))
    as_printed = (np.arctan(matrix[0, 1] / matrix[1, 1]), np.arctan(matrix[2, 0] / matrix[2, 2]))
    assert apart(as_printed[0], heading) > 0.5
    assert apart(as_printed[1], roll) > 0.5


def test_a_body_heading_west_looks_west() -> None:
    forward = np.array([0.0, 1.0, 0.0])
    west = to_navigation(strapdown_matrix(np.pi / 2, 0.0, 0.0), forward)
    assert west == pytest.approx([-1.0, 0.0, 0.0], abs=1e-15)


def test_vectors_and_matrices_are_taken_in_any_number() -> None:
    angles = np.linspace(-3, 3, 7)
    matrices = strapdown_matrix(angles, 0.1, 0.2)
    vectors = to_navigation(matrices, np.array([0.0, 0.0, 9.8]))
    assert vectors.shape == (7, 3)
    assert np.linalg.norm(vectors, axis=1) == pytest.approx(np.full(7, 9.8))
