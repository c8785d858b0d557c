"""A rule is off as long as asked, and acts where an outcome would differ without it."""

import dataclasses

import numpy as np
import pytest

from tasks.explain.evidence import groups, shares
from tests.proof.ablation.run import SWITCHES
from tests.proof.ablation.switch import Switch, Watch, alike, off

WALK = np.cumsum(np.random.default_rng(1).standard_normal(400))


@pytest.mark.parametrize("switch", SWITCHES, ids=lambda each: each.name)
def test_each_rule_is_off_while_asked_and_then_on_again(switch: Switch):
    watch = Watch([switch])
    with watch.on(), off(switch):
        pass
    with watch.on():
        pass
    assert not watch.acted


def test_rules_have_names_of_their_own():
    names = [each.name for each in SWITCHES]
    assert len(names) == len(set(names))


def test_a_constant_is_off_in_the_module_that_is_named_and_in_no_other():
    with off(Switch("small", "", "evidence.shares:SMALL", 0.0)):
        assert shares.SMALL == 0.0
        assert groups.SAME_STEP > 0.0
    assert shares.SMALL > 0.0


def test_a_rule_acts_where_its_outcome_would_differ_and_nowhere_else():
    constant = Switch(
        "CHANCE", "", "evidence.shares:INTERVALS", 40, "evidence.shares:chance_of_largest"
    )
    rule = Switch("chance", "", "evidence.shares:chance_of_largest", lambda walk: 1.0)
    watch = Watch([constant, rule], stage="explanation")
    with watch.on():
        shares.chance_of_largest(np.zeros(400))
        assert not watch.acted
        before = shares.chance_of_largest(WALK)
    assert watch.acted["CHANCE"] == {"explanation"}
    assert shares.chance_of_largest(WALK) == before


def test_outcomes_are_compared_element_by_element():
    @dataclasses.dataclass(frozen=True)
    class Outcome:
        values: np.ndarray

    one = Outcome(np.array([1.0, np.nan]))
    assert alike(one, Outcome(np.array([1.0, np.nan])))
    assert not alike(one, Outcome(np.array([1.0, 2.0])))
    assert not alike((1.0, None), (1.0, one))
    assert alike({"a": [float("nan")]}, {"a": [float("nan")]})
