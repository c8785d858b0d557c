"""The reliability method on histories whose answer is known."""

import math

import numpy as np
import pytest

from tasks.reminders.reliability import TARGET, Interval, advise, failure_rates

YEAR = 365.0


def history(conforming: int, failed: int = 0, days: float = YEAR) -> list[Interval]:
    return [Interval(days, True)] * conforming + [Interval(days, False)] * failed


@pytest.mark.parametrize("intervals", [1, 5, 60])
def test_without_a_failure_the_bound_is_the_classical_one(intervals: int) -> None:
    """exp(−λ·Σt) = 5 % at the 95 % quantile."""
    (high,) = failure_rates(history(intervals), (0.95,))
    assert high == pytest.approx(-math.log(0.05) / (intervals * YEAR), rel=1e-3)


def test_equal_intervals_give_the_quantiles_of_a_binomial_proportion() -> None:
    """With p = exp(−λt), a flat prior on λ is 1/p on p: p is Beta(conforming, failed + 1)."""
    from scipy.stats import beta

    low, middle, high = failure_rates(history(17, 3), (0.05, 0.5, 0.95))
    quantiles = beta(17, 4).ppf([0.95, 0.5, 0.05])
    expected = -np.log(quantiles) / YEAR
    assert [low, middle, high] == pytest.approx(list(expected), rel=2e-3)


def test_the_interval_ends_where_the_target_is_met() -> None:
    found = advise(history(190, 10), YEAR)
    assert found.days == pytest.approx(YEAR * math.log(TARGET) / math.log(0.95), rel=0.1)
    assert found.advice == "keep"
    assert found.shortest is not None
    assert found.longest is not None
    assert found.shortest < found.days < found.longest


@pytest.mark.parametrize(
    ("made", "advice"),
    [
        (history(2), "too few"),
        (history(0, 2), "too few"),
        (history(0, 3), "shorten"),
        (history(5, 5), "shorten"),
        (history(5), "keep"),
        (history(100), "may be longer"),
    ],
)
def test_an_interval_is_changed_only_where_the_history_contradicts_it(
    made: list[Interval], advice: str
) -> None:
    assert advise(made, YEAR).advice == advice


def test_the_true_interval_lies_in_the_range_as_often_as_stated() -> None:
    """λ drawn from what is assumed of it, then histories by it: 90 %, within 4 σ of 200 draws."""
    draw = np.random.default_rng(5)
    inside = 0
    for rate in draw.uniform(0, 1 / YEAR, 200):
        made = [Interval(YEAR, bool(draw.random() < math.exp(-rate * YEAR))) for _ in range(12)]
        if not any(each.conforming for each in made):
            inside += 1
            continue
        low, high = failure_rates(made, (0.05, 0.95))
        inside += low <= rate <= high
    assert inside / 200 > 0.90 - 4 * 0.0212
