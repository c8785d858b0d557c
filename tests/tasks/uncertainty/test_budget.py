"""Budgets by the law of propagation, against the GUM, GTC and the specifications' examples."""

import math
from dataclasses import dataclass
from decimal import ROUND_CEILING, Decimal

import GTC
import numpy as np
import pytest
from gum_functions import combine_function
from hypothesis import given
from hypothesis import strategies as st

from schemas.base import Unusable
from schemas.calibration import Budget
from tasks.specifications.evidence import solve
from tasks.uncertainty.budget import Contribution, InputQuantity, combine
from tasks.uncertainty.monte_carlo import acquisition, combine_as_example
from tasks.uncertainty.propagation import TWO_SIGMA, coverage_factor
from tasks.words.numbers import round_up

# Budgets by the law of propagation, against the GUM's own examples and by their properties.


# GUM table H.2: simultaneous voltage (V), current (A) and phase (rad).
READINGS = np.array(
    [
        [5.007, 4.994, 5.005, 4.990, 4.999],
        [19.663e-3, 19.639e-3, 19.640e-3, 19.685e-3, 19.678e-3],
        [1.0456, 1.0438, 1.0468, 1.0428, 1.0433],
    ]
)
IMPEDANCE = {
    "R": lambda v, i, phi: v / i * np.cos(phi),
    "X": lambda v, i, phi: v / i * np.sin(phi),
    "Z": lambda v, i, phi: v / i,
}
# GUM table H.6: thermometer reading and observed correction, °C.
READ = np.array([21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010,
                 26.511])  # fmt: skip
OBSERVED = -np.array([0.171, 0.169, 0.166, 0.159, 0.164, 0.165, 0.156, 0.157, 0.159, 0.161, 0.160])


def quantity(
    symbol: str, u: float, estimate: float = 0.0, dof: float = math.inf, sample: str | None = None
) -> InputQuantity:
    return InputQuantity(symbol, symbol, "1", u, "B", "normal", estimate, dof, sample)


def electrical() -> tuple[list[InputQuantity], np.ndarray]:
    means = READINGS.mean(axis=1)
    covariance = np.cov(READINGS) / READINGS.shape[1]
    u = np.sqrt(np.diag(covariance))
    inputs = [
        quantity(symbol, ui, mean, 4, "five readings")
        for symbol, ui, mean in zip(("V", "I", "φ"), u, means, strict=True)
    ]
    return inputs, covariance / np.outer(u, u)


@pytest.mark.parametrize(
    ("name", "value", "u"), [("R", 127.732, 0.071), ("X", 219.847, 0.295), ("Z", 254.260, 0.236)]
)
def test_gum_h2_gives_the_published_resistance_reactance_and_impedance(name, value, u):
    inputs, correlation = electrical()
    assert correlation[np.triu_indices(3, 1)].round(2) == pytest.approx([-0.36, 0.86, -0.65])
    budget = combine_function(name, "Ω", IMPEDANCE[name], inputs, correlation)
    assert round(budget.value, 3) == value
    # For X the unrounded inputs give 0.29558, as they do in GTC; the GUM prints 0.295 for both
    # of its ways, which is what the second way gives.
    assert budget.u_c == pytest.approx(u, abs=0.0006)
    assert budget.dof == pytest.approx(4)
    assert {(c.first, c.second): round(c.r, 2) for c in budget.correlations} == {
        ("V", "I"): -0.36,
        ("V", "φ"): 0.86,
        ("I", "φ"): -0.65,
    }


def test_gum_h3_thermometer_line_gives_the_published_correction_at_30_degrees():
    design = np.column_stack([np.ones(11), READ - 20.0])
    line = solve(design)
    parameters = line.of(OBSERVED)
    residuals = OBSERVED - design @ parameters
    variance = residuals @ residuals / 9
    u = line.uncertainty(variance * np.eye(11))
    covariance = variance * line.operator @ line.operator.T
    r = covariance[0, 1] / u[0] / u[1]
    assert [round(parameters[0], 4), round(parameters[1], 5)] == [-0.1712, 0.00218]
    assert [round(u[0], 4), round(u[1], 5)] == [0.0029, 0.00067]
    assert [round(math.sqrt(variance), 4), round(r, 3)] == [0.0035, -0.930]
    inputs = [quantity(s, u[i], parameters[i], 9, "the line") for i, s in enumerate(("y1", "y2"))]
    budget = combine_function(
        "b(30 °C)", "°C", lambda y1, y2: y1 + 10.0 * y2, inputs, np.array([[1, r], [r, 1]])
    )
    assert round(budget.value, 4) == -0.1494
    assert round(budget.u_c, 4) == 0.0041
    assert budget.dof == pytest.approx(9)


def test_gum_h1_end_gauge_gives_the_published_degrees_of_freedom_and_interval():
    nanometres = {"ls": (25.0, 18), "d": (9.7, 25.6), "δα": (2.9, 50), "δθ": (16.6, 2)}
    lines = [Contribution(quantity(s, u, dof=dof), 1.0) for s, (u, dof) in nanometres.items()]
    budget = combine("l", "nm", 50_000_838.0, lines, probability=0.99)
    assert round(budget.u_c) == 32
    assert math.floor(budget.dof) == 16
    assert round(budget.k, 2) == 2.92
    assert round(budget.k * round(budget.u_c)) == 93


@pytest.mark.parametrize(
    ("dof", "k"),  # GUM table G.2, column 95.45 %
    [(1, 13.97), (2, 4.53), (3, 3.31), (4, 2.87), (8, 2.37), (16, 2.17), (50, 2.05), (100, 2.025)],
)
def test_coverage_factors_are_those_of_gum_table_g2(dof, k):
    assert coverage_factor(dof) == pytest.approx(k, abs=0.0051)


def test_infinite_degrees_of_freedom_give_exactly_two():
    assert coverage_factor(math.inf) == 2.0


def test_degrees_of_freedom_are_truncated_but_not_by_rounding_noise():
    assert coverage_factor(16.9) == coverage_factor(16)
    assert coverage_factor(17 * (1 - 1e-15)) == coverage_factor(17)


def test_linear_sum_of_fully_correlated_inputs():
    lines = [Contribution(quantity(s, 0.1), 1.0) for s in ("a", "b", "c")]
    assert combine("sum", "1", 0.0, lines, np.ones((3, 3))).u_c == pytest.approx(0.3)


def test_a_compensating_input_has_a_negative_share():
    lines = [Contribution(quantity("a", 1.0), 1.0), Contribution(quantity("b", 0.3), -1.0)]
    budget = combine("difference", "1", 0.0, lines, np.array([[1, 0.9], [0.9, 1]]))
    assert [round(line.share, 2) for line in budget.inputs] == [1.33, -0.33]


@given(
    st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(1e-6, 1e3)), min_size=1, max_size=6),
    st.integers(0, 2**32 - 1),
)
def test_shares_of_the_variance_add_up_to_one(pairs, seed):
    lines = [Contribution(quantity(f"x{i}", u), c) for i, (c, u) in enumerate(pairs)]
    vectors = np.random.default_rng(seed).standard_normal((len(pairs), len(pairs) + 2))
    vectors /= np.linalg.norm(vectors, axis=1)[:, None]
    budget = combine("y", "1", 0.0, lines, vectors @ vectors.T)
    expected = 1.0 if budget.u_c > 0 else 0.0
    assert sum(line.share for line in budget.inputs) == pytest.approx(expected)
    assert pytest.approx(budget.U) == budget.k * budget.u_c


def test_correlated_inputs_of_finite_dof_from_different_samples_are_refused():
    r = np.array([[1.0, 0.5], [0.5, 1.0]])
    lines = [Contribution(quantity(s, 1.0, dof=5), 1.0) for s in ("a", "b")]
    with pytest.raises(Unusable, match="no effective degrees of freedom"):
        combine("y", "1", 0.0, lines, r)


def test_rounding_noise_in_a_correlation_matrix_is_no_correlation():
    lines = [Contribution(quantity(s, 1.0, dof=5), 1.0) for s in ("a", "b")]
    budget = combine("y", "1", 0.0, lines, np.array([[1.0, 1e-17], [1e-17, 1.0]]))
    assert budget.correlations == ()
    assert budget.dof == pytest.approx(10)


def test_one_sample_has_one_number_of_degrees_of_freedom():
    pair = (quantity("a", 1.0, dof=4, sample="s"), quantity("b", 1.0, dof=5, sample="s"))
    lines = [Contribution(q, 1.0) for q in pair]
    with pytest.raises(Unusable, match=r"“s” have \[4.0, 5.0\]"):
        combine("y", "1", 0.0, lines)


@pytest.mark.parametrize(
    ("matrix", "why"),
    [
        ([[1.0]], "2 × 2"),
        ([[1.0, 0.2], [0.3, 1.0]], "symmetric"),
        ([[1.0, 1.5], [1.5, 1.0]], "negative variance"),
    ],
)
def test_a_matrix_that_is_no_correlation_is_refused(matrix, why):
    lines = [Contribution(quantity(s, 1.0), 1.0) for s in ("a", "b")]
    with pytest.raises(Unusable, match=why):
        combine("y", "1", 0.0, lines, np.array(matrix))


def test_two_inputs_with_one_symbol_are_refused():
    with pytest.raises(Unusable, match="symbol a"):
        combine("y", "1", 0.0, [Contribution(quantity("a", 1.0), 1.0)] * 2)


def test_a_result_without_uncertainty_has_shares_of_zero():
    budget = combine("y", "1", 1.0, [Contribution(quantity("a", 0.0, dof=3), 1.0)])
    assert (budget.u_c, budget.U, budget.inputs[0].share) == (0.0, 0.0, 0.0)
    assert math.isinf(budget.dof)


def test_a_budget_survives_being_written_and_read_with_infinite_dof_as_null():
    inputs, correlation = electrical()
    budget = combine("y", "1", 0.0, [Contribution(quantity("a", 1.0), 2.0)])
    assert '"dof":null' in budget.model_dump_json()
    for one in (budget, combine_function("R", "Ω", IMPEDANCE["R"], inputs, correlation)):
        assert Budget.model_validate_json(one.model_dump_json()) == one
    assert budget.coverage_probability == TWO_SIGMA


# GTC, an independent implementation of the GUM, agrees on u_c and on degrees of freedom.

AGREES = 1e-6


@dataclass(frozen=True)
class Sample:
    """Inputs that were observed together: estimates, u, sensitivities, dof, correlation."""

    x: np.ndarray
    u: np.ndarray
    c: np.ndarray
    dof: float
    r: np.ndarray


@st.composite
def samples(draw: st.DrawFn) -> Sample:
    count = draw(st.integers(1, 4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    vectors = rng.standard_normal((count, count + 1))
    if draw(st.booleans()):  # independent inputs
        vectors = np.eye(count)
    vectors /= np.linalg.norm(vectors, axis=1)[:, None]
    r = vectors @ vectors.T
    np.fill_diagonal(r, 1.0)
    return Sample(
        x=rng.uniform(1.0, 5.0, count),
        u=10.0 ** rng.uniform(-4, -1, count),
        c=rng.uniform(-3.0, 3.0, count),
        dof=draw(st.one_of(st.just(math.inf), st.integers(1, 60), st.floats(1.0, 60.0))),
        r=np.clip(r, -1.0, 1.0),
    )


budgets = st.lists(samples(), min_size=1, max_size=4)


def for_us(parts: list[Sample]) -> tuple[list[InputQuantity], np.ndarray]:
    quantities = [
        InputQuantity(f"x{n}{i}", "x", "1", u, "A", "normal", x, part.dof, f"sample {n}")
        for n, part in enumerate(parts)
        for i, (x, u) in enumerate(zip(part.x, part.u, strict=True))
    ]
    correlation, first = np.zeros((len(quantities),) * 2), 0
    for part in parts:
        last = first + len(part.x)
        correlation[first:last, first:last] = part.r
        first = last
    return quantities, correlation


def for_gtc(parts: list[Sample]) -> list[object]:
    numbers = []
    for part in parts:
        members = GTC.multiple_ureal(list(part.x), list(part.u), part.dof)
        for i, a in enumerate(members):
            for j in range(i):
                GTC.set_correlation(float(part.r[i, j]), a, members[j])
        numbers.extend(members)
    return numbers


def agrees(found_u: float, found_dof: float, judge: object) -> None:
    assert found_u == pytest.approx(GTC.uncertainty(judge), rel=AGREES)
    expected = GTC.dof(judge)
    assert found_dof == pytest.approx(expected, rel=AGREES)


@given(budgets)
def test_linear_budgets_agree(parts):
    quantities, correlation = for_us(parts)
    c = np.concatenate([part.c for part in parts])
    lines = [Contribution(q, float(ci)) for q, ci in zip(quantities, c, strict=True)]
    budget = combine("y", "1", 0.0, lines, correlation)
    numbers = for_gtc(parts)
    agrees(budget.u_c, budget.dof, sum(n * float(ci) for n, ci in zip(numbers, c, strict=True)))


@pytest.mark.parametrize("dof", [3.0, 10.0, 60.0])
def test_coverage_factor_at_whole_degrees_of_freedom_agrees(dof):
    x = InputQuantity("x", "x", "1", 1.0, "A", "t", dof=dof)
    budget = combine("y", "1", 0.0, [Contribution(x, 1.0)])
    assert budget.k == pytest.approx(
        GTC.reporting.k_factor(dof, 100 * budget.coverage_probability), rel=1e-9
    )


# Appendix A of both specifications, digit for digit.

SCALE, PAIR = (1.22e-4,), (2.51e-3,) * 2
PRINTED = {  # clause: what is added up to u3, u3, u_c, U
    "JJF 2003-2022, A.1": (SCALE, "1.22e-4", "2.12e-4", "4.3e-4"),
    "JJF 2003-2022, A.2": ((3.41e-5,) * 6, "2.046e-4", "2.68e-4", "5.36e-4"),
    "JJF 2003-2022, A.3": (PAIR, "5.02e-3", "5.02e-3", "1.1e-2"),
    "JJF 2003-2022, A.4": (SCALE, "1.22e-4", "2.12e-4", "4.3e-4"),
    "JJF 2003-2022, A.5": (PAIR, "5.02e-3", "5.02e-3", "1.1e-2"),
    "JJF 1536-2015, A.1": (SCALE, "1.22e-4", "2.12e-4", "4.3e-4"),
    "JJF 1536-2015, A.2": ((3.41e-5,) * 4, "1.36e-4", "2.20e-4", "4.4e-4"),
    "JJF 1536-2015, A.3": (PAIR, "5.02e-3", "5.02e-3", "1.1e-2"),
}


def to_digits_of(printed: str, value: float) -> Decimal:
    digits = len(Decimal(printed).as_tuple().digits)
    return Decimal(f"{value:.{digits - 1}e}")


@pytest.mark.parametrize("clause", PRINTED)
def test_every_printed_digit_of_the_worked_examples(clause):
    components, u3, u_c, U = PRINTED[clause]
    budget = combine_as_example("result", "1", 0.0, components)
    table, bits, repeatability = budget.inputs
    assert (table.u, f"{bits.u:.2e}") == (1.0e-4, "1.41e-04")
    assert to_digits_of(u3, repeatability.u) == Decimal(u3)
    assert Decimal(repr(budget.u_c)) == Decimal(u_c)
    three_digits = len(Decimal(U).as_tuple().digits) == 3
    # A.2 of JJF 2003 prints U as it is; all others print it rounded up to two digits.
    assert (Decimal(repr(budget.U)) if three_digits else round_up(budget.U)) == Decimal(U)


def test_without_three_digits_of_u_c_jjf1536_a2_would_not_come_out():
    exact = (1e-8 + acquisition(12) ** 2 + (4 * 3.41e-5) ** 2) ** 0.5
    assert Decimal(repr(2 * exact)).quantize(Decimal("1e-5"), ROUND_CEILING) == Decimal("4.5e-4")
    assert round_up(2 * exact) == Decimal("4.4e-4")


def test_the_examples_budget_says_what_it_is():
    budget = combine_as_example("gyro_bias", "deg/s", 0.1, (1e-3, 2e-3), table=5e-5, bits=16)
    assert budget.evaluation == "as the specification's example"
    assert budget.k == 2.0
    assert [line.u for line in budget.inputs] == [5e-5, acquisition(16), 3e-3]
    assert sum(line.share for line in budget.inputs) == pytest.approx(1.0)
