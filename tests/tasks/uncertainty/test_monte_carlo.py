"""Monte Carlo against the published examples of JCGM 101:2008 and by its properties."""

import math

import numpy as np
import pytest
from gum_functions import Validation, combine_function, validate

from schemas.base import Unusable
from schemas.calibration import Distribution
from tasks.uncertainty.budget import InputQuantity
from tasks.uncertainty.monte_carlo import (
    MonteCarlo,
    monte_carlo,
    numerical_tolerance,
    with_monte_carlo,
)


def quantity(
    symbol: str, u: float, distribution: Distribution = "normal", estimate: float = 0.0,
    dof: float = math.inf,
) -> InputQuantity:  # fmt: skip
    return InputQuantity(symbol, symbol, "1", u, "B", distribution, estimate, dof)


def added(*x: np.ndarray) -> np.ndarray:
    return sum(x, start=np.zeros(()))


def additive(us: list[float], distribution: Distribution) -> tuple[MonteCarlo, Validation]:
    inputs = [quantity(f"X{i}", u, distribution) for i, u in enumerate(us)]
    found = monte_carlo(added, inputs, seed=101, digits=3, probability=0.95)
    budget = combine_function("Y", "1", lambda *x: sum(x), inputs, probability=0.95)
    return found, validate(budget, found.symmetric, digits=2)


def test_jcgm_101_9_2_2_sum_of_four_normals():
    found, gum = additive([1.0] * 4, "normal")
    assert found.u == pytest.approx(2.00, abs=0.005)
    assert found.symmetric.low == pytest.approx(-3.92, abs=0.005)
    assert found.symmetric.high == pytest.approx(3.92, abs=0.005)
    assert gum.tolerance == 0.05
    assert gum.valid


def test_jcgm_101_9_2_3_sum_of_four_rectangulars():
    found, gum = additive([1.0] * 4, "rectangular")
    assert found.u == pytest.approx(2.00, abs=0.005)
    assert found.symmetric.low == pytest.approx(-3.88, abs=0.006)
    assert found.symmetric.high == pytest.approx(3.88, abs=0.006)
    assert round(gum.d_low, 2) == pytest.approx(0.04, abs=0.011)
    assert gum.valid


def test_jcgm_101_9_2_4_one_rectangular_ten_times_wider_is_not_validated():
    found, gum = additive([1.0, 1.0, 1.0, 10.0], "rectangular")
    assert found.u == pytest.approx(10.1, abs=0.051)
    assert found.symmetric.low == pytest.approx(-17.0, abs=0.05)
    assert found.symmetric.high == pytest.approx(17.0, abs=0.05)
    assert gum.tolerance == 0.5
    assert gum.d_low == pytest.approx(2.9, abs=0.05)
    assert not gum.valid


def test_jcgm_101_9_3_mass_calibration_finds_what_the_first_order_misses():
    inputs = [  # mg and kg/m³
        quantity("m", 0.050, estimate=100_000.000),
        quantity("δm", 0.020, estimate=1.234),
        quantity("ρa", 0.10 / math.sqrt(3), "rectangular", 1.20),
        quantity("ρW", 1000.0 / math.sqrt(3), "rectangular", 8000.0),
        quantity("ρR", 50.0 / math.sqrt(3), "rectangular", 8000.0),
    ]

    def model(m: float, dm: float, air: float, weight: float, reference: float) -> float:
        return (m + dm) * (1.0 + (air - 1.2) * (1.0 / weight - 1.0 / reference)) - 100_000.0

    found = monte_carlo(model, inputs, seed=1, digits=2, probability=0.95)
    budget = combine_function("δm", "mg", model, inputs, probability=0.95)
    assert [round(budget.value, 4), round(budget.u_c, 4)] == [1.2340, 0.0539]
    assert [round(budget.value - budget.U, 4), round(budget.value + budget.U, 4)] == [
        pytest.approx(1.1285, abs=1e-4),
        pytest.approx(1.3395, abs=1e-4),
    ]
    assert found.value == pytest.approx(1.2341, abs=found.tolerance)
    assert found.u == pytest.approx(0.0754, abs=found.tolerance)
    # The published shortest interval, [1.0834, 1.3825]: its place is the noisy part of it.
    assert found.shortest.high - found.shortest.low == pytest.approx(0.2991, abs=0.001)
    assert found.shortest.low == pytest.approx(1.0834, abs=0.005)
    gum = validate(budget, found.shortest, digits=1)
    assert gum.tolerance == 0.005
    assert not gum.valid
    assert gum.d_low == pytest.approx(0.0451, abs=0.005)


def test_the_same_seed_gives_the_same_result_and_another_does_not():
    inputs = [quantity("a", 1.0), quantity("b", 0.5, "arcsine")]
    first, again = (monte_carlo(added, inputs, seed=7) for _ in range(2))
    assert first == again
    assert monte_carlo(added, inputs, seed=8) != first


@pytest.mark.parametrize(
    ("distribution", "half"),  # half the symmetric 95 % interval at u = 1
    [
        ("normal", 1.960),
        ("rectangular", 0.95 * math.sqrt(3)),
        ("triangular", (1 - math.sqrt(0.05)) * math.sqrt(6)),
        ("arcsine", math.sin(0.95 * math.pi / 2) * math.sqrt(2)),
    ],
)
def test_each_distribution_has_its_standard_uncertainty_and_its_shape(distribution, half):
    found = monte_carlo(
        added, [quantity("a", 2.0, distribution, 5.0)], seed=3, probability=0.95, digits=2
    )
    assert found.value == pytest.approx(5.0, abs=0.05)
    assert found.u == pytest.approx(2.0, abs=0.05)
    assert (found.symmetric.high - found.symmetric.low) / 2 == pytest.approx(2 * half, abs=0.08)


def test_a_t_input_has_the_interval_of_student():
    found = monte_carlo(
        added, [quantity("a", 1.0, "t", dof=10)], seed=3, probability=0.95, digits=2
    )
    assert found.symmetric.high == pytest.approx(2.228, abs=0.05)
    assert found.u == pytest.approx(math.sqrt(10 / 8), abs=0.05)


def test_correlated_normals_are_drawn_jointly():
    inputs = [quantity("a", 1.0), quantity("b", 1.0), quantity("c", 0.1, "rectangular")]
    r = np.array([[1.0, -0.9, 0.0], [-0.9, 1.0, 0.0], [0.0, 0.0, 1.0]])
    found = monte_carlo(added, inputs, r, seed=2)
    assert found.u == pytest.approx(math.sqrt(0.2 + 0.01), abs=0.01)


def test_correlated_inputs_that_are_not_normal_are_refused():
    inputs = [quantity("a", 1.0), quantity("b", 1.0, "rectangular")]
    with pytest.raises(Unusable, match="only normal inputs"):
        monte_carlo(added, inputs, np.array([[1.0, 0.5], [0.5, 1.0]]), seed=1)


def test_a_model_that_is_not_defined_where_inputs_reach_is_refused():
    def root(a: np.ndarray) -> np.ndarray:
        with np.errstate(invalid="ignore"):
            return np.sqrt(a)

    with pytest.raises(Unusable, match="not finite"):
        monte_carlo(root, [quantity("a", 1.0)], seed=1)


@pytest.mark.parametrize(
    ("u", "digits", "delta"),  # JCGM 101, 7.9.2, examples 1 and 2 among them
    [(0.00035, 2, 0.000005), (2.0, 1, 0.5), (0.0996, 2, 0.005), (0.0754, 1, 0.005), (0.0, 2, 0.0)],
)
def test_numerical_tolerance(u, digits, delta):
    assert numerical_tolerance(u, digits) == pytest.approx(delta)


def test_a_budget_takes_over_the_monte_carlo_interval():
    inputs = [quantity("a", 1.0, "rectangular", 3.0)]
    budget = combine_function("y", "1", lambda a: a, inputs)
    found = monte_carlo(added, inputs, seed=5)
    taken = with_monte_carlo(budget, found)
    assert taken.evaluation == "Monte Carlo"
    assert taken.coverage_interval == (found.symmetric.low, found.symmetric.high)
    assert pytest.approx(taken.U) == taken.k * taken.u_c
    assert taken.U < budget.U
    assert taken.inputs == budget.inputs
