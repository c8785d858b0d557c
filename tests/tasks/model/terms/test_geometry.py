"""Lever arms, bending and re-fixing, against positions and attitudes written out."""

import numpy as np
import pytest

from tasks.model.terms.geometry import (
    LEVER_ARM,
    SAG,
    SIZE_EFFECT,
    STRUCTURAL_COMPLIANCE,
    remount_misalignment,
)
from tests.tasks.model.table_run import (
    RATE_HZ,
    T,
    attitude,
    felt,
    motion,
    read,
    undisturbed,
)

INSIDE = slice(2, -2)  # rows with neighbours to differentiate by


def force_at(place: np.ndarray) -> np.ndarray:
    """Second derivative (n, 3) of where a point of the body is, in the body."""
    whole = attitude()
    where = whole @ place
    push = np.full_like(where, np.nan)
    push[1:-1] = (where[2:] - 2.0 * where[1:-1] + where[:-2]) * RATE_HZ**2
    return np.einsum("nji,nj->ni", whole, push)


def test_a_lever_arm_is_the_acceleration_of_its_end():
    r = np.array([0.05, -0.02, 0.11])
    added = read((LEVER_ARM,), r) - read((), [])
    assert added[INSIDE, 3:] == pytest.approx(force_at(r)[INSIDE], abs=1e-4)
    assert not added[:, :3].any()


def test_each_accelerometer_at_its_own_place():
    places = np.array([[0.05, -0.02, 0.11], [0.01, 0.04, -0.03], [-0.06, 0.02, 0.07]])
    added = read((SIZE_EFFECT,), places.ravel()) - read((), [])
    expected = np.column_stack([force_at(place)[:, i] for i, place in enumerate(places)])
    assert added[INSIDE, 3:] == pytest.approx(expected[INSIDE], abs=1e-4)


def test_a_fixture_that_bends_turns_gyros_and_accelerometers_together():
    xy, xz, yx, yz, zx, zy = values = 1e-5 * np.array([2.0, -1.0, 3.0, 1.5, -2.5, 1.0])
    x, y, z = motion().rate.T ** 2
    bend = np.column_stack([xy * y + xz * z, yx * x + yz * z, zx * x + zy * y])
    added = read((STRUCTURAL_COMPLIANCE,), values) - read((), [])
    expected = felt(attitude(between={3: bend})) - undisturbed()
    assert added[INSIDE] == pytest.approx(expected[INSIDE], abs=3e-7)
    assert np.abs(added[INSIDE, :3]).max() > 1e-5


def test_a_fixture_that_sags_turns_with_the_attitude():
    matrix = 1e-6 * np.array([[1.0, -2.0, 3.0], [0.5, 4.0, -1.0], [2.0, 1.0, -3.0]])
    added = read((SAG,), matrix.ravel()) - read((), [])
    force = 9.80665 * motion().up
    expected = felt(attitude(between={3: force @ matrix.T})) - undisturbed()
    assert added[INSIDE] == pytest.approx(expected[INSIDE], abs=3e-7)
    assert np.abs(added[INSIDE, :3]).max() > 1e-5


def test_each_fixing_but_the_first_has_a_turn_of_its_own():
    fixing = motion().recorded["fixing"]
    assert sorted(set(fixing)) == [0.0, 1.0, 2.0]
    second, third = 1e-4 * np.array([1.0, -2.0, 3.0]), 1e-4 * np.array([-2.0, 1.0, 0.5])
    turn = np.where((fixing == 1)[:, None], second, np.where((fixing == 2)[:, None], third, 0.0))
    added = read((remount_misalignment(fixing),), np.concatenate([second, third])) - read((), [])
    expected = felt(attitude(between={3: turn})) - undisturbed()
    whole = np.isfinite(expected).all(axis=1) & (np.abs(T - 7) > 0.01) & (np.abs(T - 14) > 0.01)
    assert added[whole] == pytest.approx(expected[whole], abs=2e-6)
    assert not added[fixing == 0].any()
