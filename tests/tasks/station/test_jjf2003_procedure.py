from collections import Counter
from math import cos, radians, sin

import pytest

from schemas.base import Unusable
from schemas.procedure import Position, RateRun
from tasks.station import procedures

JJF2003 = procedures.load("jjf2003")
POSITIONS = [step for step in JJF2003.steps if isinstance(step, Position)]
RUNS = [step for step in JJF2003.steps if isinstance(step, RateRun)]


def payload_axes_in_navigation(outer, middle, inner):
    """Rz(outer)·Rx(middle)·Rz(inner) multiplied out; rows E, N, U, columns payload x, y, z."""
    co, so = cos(radians(outer)), sin(radians(outer))
    cm, sm = cos(radians(middle)), sin(radians(middle))
    ci, si = cos(radians(inner)), sin(radians(inner))
    return [
        [co * ci - so * cm * si, -co * si - so * cm * ci, so * sm],
        [so * ci + co * cm * si, -so * si + co * cm * ci, -co * sm],
        [sm * si, sm * ci, cm],
    ]


@pytest.mark.parametrize("step", JJF2003.steps, ids=lambda step: step.name)
def test_angles_bring_the_axis_up_that_the_step_names(step):
    upwards = payload_axes_in_navigation(*step.angles_deg)[2]
    wanted = [0.0, 0.0, 0.0]
    wanted["xyz".index(step.up[1])] = 1.0 if step.up[0] == "+" else -1.0
    assert upwards == pytest.approx(wanted, abs=1e-12)


def test_twelve_positions_are_each_axis_up_and_down_at_two_opposite_headings():
    twelve = [step for step in POSITIONS if step.item == "twelve_position"]
    assert Counter(step.up for step in twelve) == dict.fromkeys(
        ("+x", "-x", "+y", "-y", "+z", "-z"), 2
    )
    for first, second in zip(twelve[::2], twelve[1::2], strict=True):
        assert (first.turn_deg, second.turn_deg) == (0, 180)
        one = payload_axes_in_navigation(*first.angles_deg)
        other = payload_axes_in_navigation(*second.angles_deg)
        assert other[2] == pytest.approx(one[2], abs=1e-12)
        for row in (0, 1):  # what pointed east or north points the other way
            assert other[row] == pytest.approx([-value for value in one[row]], abs=1e-12)


def test_every_axis_has_seven_to_eleven_rates_of_both_signs():
    assert [run.axis for run in RUNS] == ["x", "y", "z"]
    for run in RUNS:
        rates = run.rates_deg_s
        assert 7 <= len(set(rates)) == len(rates) <= 11
        assert sorted(rates) == sorted(-rate for rate in rates)
        assert max(rates) == 300
        assert run.up == f"+{run.axis}"
        assert run.spin_axis == 0


def test_each_rate_run_stands_between_two_rests_in_the_same_attitude():
    for place, step in enumerate(JJF2003.steps):
        if isinstance(step, RateRun):
            for rest in (JJF2003.steps[place - 1], JJF2003.steps[place + 1]):
                assert rest.item == "rate_sensitivity"
                assert rest.angles_deg == step.angles_deg


def test_limits_are_those_of_clause_6():
    assert JJF2003.environment.temperature_degc == (15.0, 25.0)
    assert JJF2003.environment.humidity_percent == (20.0, 85.0)


def test_unknown_procedure_is_refused_with_the_known_names():
    with pytest.raises(Unusable, match=r"jjf1999.*jjf2003"):
        procedures.load("jjf1999")
