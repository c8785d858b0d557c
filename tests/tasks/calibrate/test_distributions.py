"""Monte Carlo of an item's elements: beside the law of propagation, and where that fails."""

import math
from dataclasses import replace

import numpy as np
import pytest

from schemas.calibration import Budget, Calibration
from schemas.laboratory import ErrorBound
from tasks.calibrate.calibrate import evaluation_for, monte_carlo_budget
from tasks.specifications.estimate import ITEMS, Estimate
from tasks.specifications.jjf1536 import JJF1536
from tasks.specifications.jjf2003 import JJF2003
from tasks.uncertainty.budget import Contribution, InputQuantity, combine, observed
from tasks.uncertainty.equipment import limit_of, with_rates_by_label
from tests.tasks.items_only import items_only

BOUND = ErrorBound(half_width=1e-5, distribution="rectangular")
DRAWN = {  # every divisor, and what has none; drawing every element takes a while
    "gyro_bias", "accel_scale_factor", "accel_rate_sensitivity", "ahrs_scale_factor",
    "ahrs_zero_offset",
}  # fmt: skip
SOME2003, SOME1536 = (
    replace(each, items=tuple(item for item in each.items if item.key in DRAWN))
    for each in (JJF2003, JJF1536)
)
METHODS = {"plant_clean": SOME2003, "ahrs_clean": SOME1536}


@pytest.fixture(scope="module")
def both(plant) -> dict[str, tuple[Calibration, Calibration]]:
    """Each recording by Monte Carlo and by the law of propagation."""
    found = {}
    for name, method in METHODS.items():
        recording = plant(name, 4)
        found[name] = tuple(
            items_only(method, recording, evaluation)
            for evaluation in (evaluation_for(recording, "Monte Carlo"), evaluation_for(recording))
        )
    return found


@pytest.mark.parametrize("name", METHODS)
def test_where_items_are_nearly_linear_it_stands_beside_the_law_of_propagation(both, name):
    drawn_, gum = both[name]
    for item, each in drawn_.items.items():
        assert each.uncertainty_kind == "Monte Carlo"
        assert each.value == gum.items[item].value
        for element, budget in each.budgets.items():
            linear = gum.items[item].budgets[element]
            low, high = budget.coverage_interval
            assert budget.evaluation == "Monte Carlo"
            assert (budget.u_c, budget.U) == (each.u[element], each.U[element])
            assert (high - low) / 2.0 * 0.9999 <= each.U[element]
            assert each.U[element] == pytest.approx(each.k * budget.u_c)
            # Student's t of few degrees of freedom is wider than its u, Welch's sum of it too.
            assert 0.95 * linear.u_c < budget.u_c < 1.42 * linear.u_c
            assert (low + high) / 2.0 == pytest.approx(budget.value, abs=0.1 * budget.u_c)


def test_the_same_recording_gives_the_same_draws_and_every_element_its_own(plant, both):
    recording = plant("ahrs_clean", 4)
    one = replace(JJF1536, items=JJF1536.items[:1])
    again = items_only(one, recording, evaluation_for(recording, "Monte Carlo"))
    assert again.items["ahrs_scale_factor"] == both["ahrs_clean"][0].items["ahrs_scale_factor"]
    line = observed(1.0, "m", 9.0)
    x, y = (drawn("accel_bias", a, Estimate(1.0, (line,)), "digest") for a in "xy")
    assert x.coverage_interval != y.coverage_interval


def drawn(item: str, element: str, estimate: Estimate, seed: str) -> Budget:
    return monte_carlo_budget(ITEMS[item], element, estimate, seed)


def rate(u: float, sensitivity: float) -> Contribution:
    quantity = replace(JJF2003.equipment.rates[0][1].quantity, u=u)
    return Contribution(quantity, sensitivity)


def test_p_of_a_poorly_known_rate_has_the_skew_of_one_over_its_square():
    u, p = 0.2, 0.01
    found = Estimate(p, (observed(1e-9, "m"), rate(u, -2.0 * p)))
    budget = drawn("accel_rate_sensitivity", "xy", found, "digest")
    linear = combine("p", "m", p, found.lines_in("m"))
    tail = 0.0455 / 2.0  # a rectangular ε has its quantiles at ±√3·u·(1 − 2·tail)
    edge = math.sqrt(3.0) * u * (1.0 - 2.0 * tail)
    low, high = budget.coverage_interval
    assert low == pytest.approx(p / (1.0 + edge) ** 2, rel=0.01)
    assert high == pytest.approx(p / (1.0 - edge) ** 2, rel=0.01)
    assert high - p > 2.0 * (p - low)
    assert budget.value == p
    assert high > p + 1.3 * linear.U


def test_a_gravity_hardly_known_divides_the_accelerometer_scale_factor():
    gravity = InputQuantity("g", "g", "m/s2", 1.0, "B", "rectangular")
    k, g = 1.1, 9.8
    found = Estimate(k, (observed(1e-9, "1"), Contribution(gravity, -k / g)))
    budget = drawn("accel_scale_factor", "x", found, "digest")
    edge = math.sqrt(3.0) * (1.0 - 0.0455)
    assert budget.coverage_interval == pytest.approx((k * g / (g + edge), k * g / (g - edge)), 0.01)


def test_what_is_no_divisor_of_the_item_adds_up():
    found = Estimate(1e-3, (observed(1e-9, "rad/s"), rate(0.2, -2e-3)))
    low, high = drawn("gyro_fit_offset", "x", found, "digest").coverage_interval
    assert high - 1e-3 == pytest.approx(1e-3 - low, rel=0.02)


def test_of_few_degrees_of_freedom_the_interval_settles_and_u_is_the_linear_one():
    found = Estimate(5.0, (observed(1.0, "1", 2.0),))
    budget = drawn("gyro_bias", "x", found, "digest")
    assert budget.u_c == 1.0
    linear = combine("b", "1", 5.0, found.lines_in("1"))
    assert budget.k == pytest.approx(linear.k, rel=0.03)


def test_an_element_that_nothing_makes_uncertain_is_not_drawn():
    budget = drawn("gyro_bias", "x", Estimate(5.0, (observed(0.0, "1"),)), "digest")
    assert (budget.u_c, budget.U, budget.coverage_interval) == (0.0, 0.0, None)


def test_every_symbol_of_a_divisor_is_one_of_the_equipment():
    known = {"g", limit_of("time_base").symbol}
    known |= {limit.symbol for _, limit in with_rates_by_label(JJF2003.equipment, BOUND).rates}
    for equipment in (JJF2003.equipment, JJF1536.equipment):
        known |= {limit.symbol for _, limit in equipment.rates}
        known |= {f"{limit.symbol}θ" for limit in equipment.angles}  # of a turned angle
        known |= {limit.symbol for limit in (equipment.ripple,) if limit}
    assert {symbol for item in ITEMS.values() for symbol in item.divisor} <= known
    assert np.all([item.power in (1, 2) for item in ITEMS.values()])
