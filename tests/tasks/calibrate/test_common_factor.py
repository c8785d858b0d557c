"""One coverage factor for the elements of an item."""

import pytest

from tasks.calibrate.calibrate import common_factor, expanded
from tasks.uncertainty.budget import combine, observed


def of_dof(dof: float):
    return combine("b.x", "1", 1.0, [observed(0.5, "1", dof)])


def test_the_element_of_the_fewest_degrees_of_freedom_sets_the_factor_of_all():
    budgets = {"x": of_dof(5.0), "y": of_dof(200.0), "z": of_dof(12.0)}
    k = common_factor(budgets)
    assert k == 2.65  # Student's t of 5 dof at 95.45 %, 2.6487, rounded up
    stated = expanded(budgets["y"], k)
    assert (stated.k, stated.U) == (k, pytest.approx(2.65 * 0.5))


def test_fifty_degrees_of_freedom_are_enough_for_two():
    assert common_factor({"x": of_dof(50.0), "y": of_dof(1e4)}) == 2.0
    assert common_factor({"x": of_dof(49.0), "y": of_dof(1e4)}) > 2.0
