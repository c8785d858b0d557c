"""The coverage interval of a linear budget, against closed forms and Monte Carlo."""

import math

import numpy as np
import pytest
from gum_functions import validate
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from schemas.calibration import Budget, Calibration
from tasks.specifications.jjf1536 import JJF1536
from tasks.specifications.jjf2003 import JJF2003
from tasks.uncertainty.budget import PROBABILITY, Contribution, InputQuantity, combine, half_width
from tasks.uncertainty.monte_carlo import (
    monte_carlo,
)
from tests.tasks.items_only import items_only

ROOT3 = math.sqrt(3.0)
SHAPES = ("normal", "rectangular", "triangular", "arcsine", "t")


def alone(shape: str, dof: float = math.inf, probability: float = PROBABILITY) -> float:
    return half_width([(shape, 1.0, dof)], probability)


def quantity(symbol: str, shape: str, u: float, dof: float = math.inf, x: float = 0.0):
    return InputQuantity(symbol, symbol, "1", u, "B", shape, x, dof)


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ("normal", stats.norm.ppf(0.975)),
        ("rectangular", 0.95 * ROOT3),
        ("triangular", math.sqrt(6.0) * (1.0 - math.sqrt(0.05))),
        ("arcsine", math.sqrt(2.0) * math.sin(0.95 * math.pi / 2.0)),
    ],
)
def test_one_input_has_the_interval_of_its_own_distribution(shape, expected):
    assert alone(shape) == pytest.approx(expected, rel=1e-3)
    assert half_width([(shape, 3.0, math.inf)]) == pytest.approx(3.0 * alone(shape))


def test_a_rectangular_result_has_the_coverage_factor_of_jjf_1059():
    assert round(alone("rectangular"), 2) == 1.65  # JJF 1059.1, table 3
    assert round(alone("rectangular", probability=0.99), 2) == 1.71


@pytest.mark.parametrize("dof", [1.0, 2.0, 3.0, 4.0, 5.5, 20.0, 140.0, 300.0, 1e4, 1e7])
def test_an_observed_input_has_student_s_interval(dof):
    assert alone("t", dof) == pytest.approx(stats.t.ppf(0.975, dof), rel=1e-4)


def test_a_trapezium_has_its_closed_form():
    a, b = 1.0, 0.5  # half widths: the tail beyond x is (a + b − x)²/(8ab)
    found = half_width([("rectangular", a / ROOT3, 0.0), ("rectangular", b / ROOT3, 0.0)])
    assert found == pytest.approx(a + b - math.sqrt(0.05 / 2.0 * 8.0 * a * b), rel=1e-4)


def test_normal_inputs_add_in_quadrature():
    found = half_width([("normal", 3.0, math.inf), ("normal", 4.0, math.inf)])
    assert found == pytest.approx(5.0 * alone("normal"))


def test_nothing_uncertain_has_no_width():
    assert half_width([]) == 0.0
    assert half_width([("normal", 0.0, math.inf)]) == 0.0


inputs = st.lists(
    st.tuples(
        st.sampled_from(SHAPES),
        st.floats(-3.0, 0.0).map(lambda exponent: 10.0**exponent),
        st.floats(1.0, 300.0),
    ),
    min_size=1,
    max_size=6,
)


@settings(max_examples=25)
@given(inputs)
def test_any_sum_covers_as_random_draws_of_it_do(shapes):
    width = half_width(shapes)
    rng = np.random.default_rng(1)
    total = np.zeros(100_000)
    for shape, size, dof in shapes:
        x = quantity("x", shape, size, dof)
        if shape == "t":
            total += size * rng.standard_t(dof, len(total))
        else:
            u = rng.uniform(-1.0, 1.0, len(total))
            total += size * {
                "normal": lambda u: stats.norm.ppf((u + 1.0) / 2.0),
                "rectangular": lambda u: ROOT3 * u,
                "triangular": lambda u: math.sqrt(6.0) * np.sign(u) * (1.0 - np.sqrt(1.0 - abs(u))),
                "arcsine": lambda u: math.sqrt(2.0) * np.sin(math.pi / 2.0 * u),
            }[x.distribution](u)
    inside = np.mean(np.abs(total) <= width)
    # The arcsine's density has no end at its edges: there 0.1 % of width holds 0.5 % of it.
    edges = any(shape == "arcsine" for shape, _, _ in shapes)
    assert inside == pytest.approx(PROBABILITY, abs=0.007 if edges else 0.003)


@settings(max_examples=30)
@given(inputs, st.sampled_from(SHAPES), st.floats(1e-3, 1.0))
def test_the_width_grows_with_the_probability(shapes, shape, size):
    assert half_width(shapes, 0.5) < half_width(shapes, 0.95) < half_width(shapes, 0.99)


def test_a_budget_says_it_and_one_with_correlated_inputs_does_not():
    lines = [Contribution(quantity(s, "rectangular", 1.0), 2.0) for s in "ab"]
    budget = combine("y", "1", 0.0, lines)
    assert budget.half_width_95 == pytest.approx(2.0 * math.sqrt(2.0) * alone("triangular"), 1e-4)
    joined = combine("y", "1", 0.0, lines, np.array([[1.0, 0.5], [0.5, 1.0]]))
    assert joined.half_width_95 is None


# What is not linear in its inputs: p ∝ 1/ω², the scale factors and the misalignment as ratios.


@pytest.fixture(scope="module")
def clean(plant) -> Calibration:
    return items_only(JJF2003, plant("plant_clean", 4))


@pytest.fixture(scope="module")
def ahrs(plant) -> Calibration:
    return items_only(JJF1536, plant("ahrs_clean"))


def drawn(budget: Budget) -> list[InputQuantity]:
    return [
        InputQuantity(line.symbol, line.name, line.unit, line.u, line.kind,
                      line.distribution, 0.0, line.dof)
        for line in budget.inputs
    ]  # fmt: skip


def slope(budget: Budget, symbol: str) -> float:
    return next(line.sensitivity for line in budget.inputs if line.symbol == symbol)


def stands_beside(budget: Budget, model) -> None:
    """Clause 8 of JCGM 101, with the interval that the budget states."""
    assert budget.half_width_95 is not None
    symbols = [line.symbol for line in budget.inputs]
    found = monte_carlo(
        lambda *x: model(dict(zip(symbols, x, strict=True))),
        drawn(budget),
        seed=1,
        probability=PROBABILITY,
    )
    stated = budget.model_copy(
        update={"U": budget.half_width_95, "coverage_probability": PROBABILITY}
    )
    assert validate(stated, found.symmetric).valid
    assert found.u == pytest.approx(budget.u_c, rel=0.1)  # t is wider than its scale


@pytest.mark.parametrize("element", ["yx", "xz"])
def test_the_linear_budget_of_p_stands_beside_monte_carlo(clean, element):
    budget = clean.items["accel_rate_sensitivity"].budgets[element]
    tilt = slope(budget, "α5")
    stands_beside(
        budget, lambda x: (budget.value + x["u_A"] + tilt * x["α5"]) / (1.0 + x["ε1"]) ** 2
    )


def test_the_linear_budget_of_the_misalignment_stands_beside_monte_carlo(ahrs):
    budget = ahrs.items["ahrs_misalignment"].budgets["yx"]
    relative, fixture = -slope(budget, "α1θ") / budget.value, slope(budget, "α4")
    stands_beside(
        budget,
        lambda x: (
            (budget.value + x["u_A"]) / (1.0 + relative * x["α1θ"]) + fixture * np.tan(x["α4"])
        ),
    )
