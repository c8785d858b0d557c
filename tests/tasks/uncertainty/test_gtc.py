"""GTC, an independent implementation of the GUM, agrees on u_c and on degrees of freedom."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import GTC
import numpy as np
import pytest
from gum_functions import combine_function
from hypothesis import given, settings
from hypothesis import strategies as st

from schemas.base import Unusable
from tasks.uncertainty.budget import Contribution, InputQuantity, combine

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


def product_and_sines(sin: Callable[[object], object], numbers: list[object]) -> object:
    total: object = 1.0
    for number in numbers:
        total = total * number  # type: ignore[operator]
    for number in numbers:
        total = total + sin(number * number) / number  # type: ignore[operator]
    return total


@settings(max_examples=50)
@given(budgets)
def test_budgets_of_a_function_agree(parts):
    quantities, correlation = for_us(parts)
    budget = combine_function(
        "y", "1", lambda *x: product_and_sines(math.sin, list(x)), quantities, correlation
    )
    judge = product_and_sines(GTC.sin, for_gtc(parts))
    assert budget.value == pytest.approx(GTC.value(judge), rel=1e-12)
    agrees(budget.u_c, budget.dof, judge)


@pytest.mark.parametrize("dof", [3.0, 10.0, 60.0])
def test_coverage_factor_at_whole_degrees_of_freedom_agrees(dof):
    x = InputQuantity("x", "x", "1", 1.0, "A", "t", dof=dof)
    budget = combine("y", "1", 0.0, [Contribution(x, 1.0)])
    assert budget.k == pytest.approx(
        GTC.reporting.k_factor(dof, 100 * budget.coverage_probability), rel=1e-9
    )


def test_both_refuse_correlation_between_inputs_of_finite_dof_that_are_not_one_sample():
    with pytest.raises(RuntimeError, match="not in the same ensemble"):
        GTC.set_correlation(0.5, GTC.ureal(1, 1, 5), GTC.ureal(1, 1, 5))
    x = [InputQuantity(s, s, "1", 1.0, "A", "t", dof=5) for s in ("a", "b")]
    with pytest.raises(Unusable, match="sample"):
        combine("y", "1", 0.0, [Contribution(q, 1.0) for q in x], np.array([[1, 0.5], [0.5, 1]]))
