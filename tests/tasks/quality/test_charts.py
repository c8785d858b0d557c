"""Control charts, against the worked examples of handbooks and the rules as Nelson states them."""

import numpy as np
import pytest

from tasks.quality.charts import RULES, individuals, nelson

# NIST/SEMATECH e-Handbook, 6.3.2.2: flow rates of ten batches
FLOW = np.array([49.6, 47.6, 49.9, 51.3, 47.8, 51.2, 52.6, 52.4, 53.6, 52.1])
# Montgomery, Introduction to Statistical Quality Control, example 6.5: costs of loan applications
COSTS = np.array(
    [310, 288, 297, 298, 307, 303, 294, 297, 308, 306, 294, 299, 297, 299, 314, 295, 293, 306, 301,
     304.0]
)  # fmt: skip
BROKEN = {  # each rule by itself, in sigma: the last value is the one that breaks it
    1: [0.5, -0.5, 3.1],
    2: [-0.5, *[0.5, 0.7] * 4, 0.5],
    3: [0.9, -0.9, -0.5, -0.3, 0.2, 0.4, 0.6],
    4: [0.3, *[0.5, -0.5] * 6, 0.5],
    5: [-0.5, 2.5, 0.5, 2.5],
    6: [-0.5, 1.5, 1.2, 0.5, 1.5, 1.2],
    7: [1.5, *[0.5, 0.5, -0.5] * 5],
    8: [0.5, *[1.5, -1.5, -1.2, 1.3] * 2],
}


def test_limits_are_those_of_the_handbook() -> None:
    chart = individuals(FLOW)
    assert chart is not None
    assert chart.centre == pytest.approx(50.81)
    assert chart.mean_range == pytest.approx(1.8778, abs=5e-5)
    assert chart.limits == pytest.approx((45.8159, 55.8041), abs=2e-3)  # by d2 = 1.128
    assert not chart.broken.any()


def test_limits_are_those_of_montgomery() -> None:
    chart = individuals(COSTS)
    assert chart is not None
    assert chart.centre == pytest.approx(300.5)
    assert chart.mean_range == pytest.approx(7.79, abs=5e-3)
    assert chart.limits == pytest.approx((279.78, 321.22), abs=0.02)
    assert chart.range_limit == pytest.approx(25.45, abs=0.01)
    assert not chart.broken[0].any()


@pytest.mark.parametrize("rule", range(1, RULES + 1))
def test_each_rule_is_broken_by_its_own_pattern_at_the_last_value(rule: int) -> None:
    pattern = np.array(BROKEN[rule])
    broken = nelson(pattern)[rule - 1]
    assert broken[-1]
    assert not broken[:-1].any()
    assert nelson(-pattern)[rule - 1][-1]


@pytest.mark.parametrize("rule", [2, 3, 4, 7, 8])
def test_one_value_less_in_the_row_breaks_nothing(rule: int) -> None:
    first = {2: 1, 3: 1, 4: 0, 7: 1, 8: 1}[rule]  # where the row begins
    assert not nelson(np.array(BROKEN[rule])[first + 1 :])[rule - 1].any()


def test_noise_breaks_the_first_rule_as_often_as_nelson_says() -> None:
    z = np.random.default_rng(2).standard_normal(400_000)
    rates = nelson(z).mean(axis=1)
    assert rates[0] == pytest.approx(0.0027, rel=0.1)
    assert rates[1] == pytest.approx(2 * 0.5**9, rel=0.1)
    assert (rates < 0.008).all()


def test_a_single_value_and_equal_values_have_no_violations() -> None:
    assert individuals(np.array([1.0])) is None
    chart = individuals(np.ones(20))
    assert chart is not None
    assert not chart.broken[:6].any()
