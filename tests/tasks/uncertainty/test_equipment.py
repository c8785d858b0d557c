"""Type B: the equipment's limits as standard uncertainties."""

import math

import pytest

from schemas.laboratory import EquipmentLimit
from tasks.uncertainty.budget import combine, resolution
from tasks.uncertainty.equipment import (
    ARCSECOND,
    JJF1536,
    JJF2003,
    RATE,
    ErrorLimit,
    with_limits,
)


def test_standard_uncertainties_of_table_1():
    root3 = math.sqrt(3.0)
    assert RATE.u == pytest.approx(1e-5 / root3)
    assert JJF2003.ripple is not None
    assert JJF2003.ripple.u == pytest.approx(5e-4 / root3)
    assert [limit.u for limit in JJF2003.angles] == pytest.approx(
        [10 * ARCSECOND / root3, 5 * ARCSECOND / root3]
    )
    for limit in (JJF2003.axes, JJF2003.fixture, JJF2003.level):
        assert limit is not None
        assert limit.u == pytest.approx(10 * ARCSECOND / root3)


@pytest.mark.parametrize(("deg_s", "u"), [(0.5, 1e-2), (1.0, 1e-3), (10.0, 1e-4), (-300.0, 1e-4)])
def test_jjf1536_rate_uncertainty_depends_on_the_rate(deg_s, u):
    (limit,) = JJF1536.rate_at(math.radians(deg_s))
    assert limit.u == pytest.approx(u)
    assert JJF1536.position is not None
    assert JJF1536.position.u == pytest.approx(5 * ARCSECOND)


@pytest.mark.parametrize(
    ("distribution", "divisor"),
    [("normal", 2.0), ("rectangular", 3**0.5), ("triangular", 6**0.5), ("arcsine", 2**0.5)],
)
def test_half_widths_are_divided_as_the_distribution_asks(distribution, divisor):
    limit = ErrorLimit("a", "a", "1", 6.0, distribution, "clause")
    assert limit.quantity.u == pytest.approx(6.0 / divisor)


def test_a_laboratory_s_own_limits_go_before_table_1():
    certified = EquipmentLimit(half_width=2e-6, distribution="normal", source="certificate 7")
    own = with_limits(JJF1536, {"rate": certified, "axes": certified})
    (rate,) = own.rate_at(0.001)
    assert (rate.u, rate.clause) == (1e-6, "certificate 7")
    assert own.axes is not None
    assert (own.axes.u, own.axes.symbol) == (1e-6, "α3")
    assert own.position == JJF1536.position


def test_readings_are_each_rounded_by_an_error_of_their_own():
    step = 0.2
    line = resolution(step / 2.0, "deg/s", math.hypot(0.5, -0.5))
    u_c = combine("y", "1", 0.0, [line]).u_c
    assert u_c == pytest.approx(step / math.sqrt(12.0) * math.sqrt(0.5))


@pytest.mark.parametrize("deg_s", [10.0 - 1e-9, 9.95, 10.0])
def test_a_rate_just_below_the_edge_of_a_class_belongs_to_it(deg_s):
    (limit,) = JJF1536.rate_at(math.radians(deg_s))
    assert limit.symbol == "ε1"
