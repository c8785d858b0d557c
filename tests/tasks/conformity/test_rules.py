"""Decision rules: where a value is accepted, and when nothing is decided."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from schemas.tolerance import Limit, Tolerance
from tasks.conformity.rules import (
    Criterion,
    criterion,
    probability_of_conformity,
    probability_of_nonconformity,
)

VALUE = st.floats(-3, 3)
U_OF = st.floats(0.001, 1.0)


def rule(limit: dict[str, Any] | None = None, **file: Any) -> Criterion:
    made = Limit(**({"item": "b", "unit": "1", "lower": -1.0, "upper": 1.0} | (limit or {})))
    tolerance = Tolerance(manufacturer="m", model="m", document="d", limits=(made,), **file)
    return criterion(tolerance, made)


def verdict(rule: Criterion, value: float, U: float) -> str:
    return rule.verdict(value, U, probability_of_conformity(value, U / 2, rule.limits))


def marginal(rule: Criterion, value: float, U: float) -> bool:
    return rule.marginal(value, U, verdict(rule, value, U))  # type: ignore[arg-type]


def test_a_guard_band_moves_both_limits_inwards_by_u() -> None:
    guarded = rule(rule="guard_band")
    assert guarded.accepted(0.25) == (-0.75, 0.75)
    assert [verdict(guarded, v, 0.25) for v in (0.75, 0.76, 1.2)] == ["pass", "fail", "fail"]


def test_a_negative_factor_rejects_only_beyond_doubt() -> None:
    guarded = rule(rule="guard_band", guard_band_factor=-1.0)
    assert [verdict(guarded, v, 0.25) for v in (1.2, 1.3)] == ["pass", "fail"]


def test_a_file_without_rules_asks_for_simple_acceptance_and_a_capability_of_one() -> None:
    usual = rule()
    assert (usual.rule, usual.factor, usual.min_capability) == ("simple_acceptance", 0.0, 1.0)


def test_the_rule_of_a_limit_outranks_that_of_its_file() -> None:
    own = rule({"rule": "guard_band", "guard_band_factor": 0.5}, rule="simple_acceptance")
    assert own.accepted(0.2) == (-0.9, 0.9)
    assert rule({"rule": "simple_acceptance"}, rule="guard_band").accepted(0.2) == (-1.0, 1.0)
    file = {"rule": "guard_band", "guard_band_factor": 0.5}
    assert rule({"guard_band_factor": 2.0}, **file).accepted(0.2) == (-0.6, 0.6)
    assert verdict(rule({"min_capability": 4.0}), 0.0, 0.3) == "inconclusive"
    assert verdict(rule({"min_capability": 0.5}, min_capability=4.0), 0.0, 1.5) == "pass"


def test_a_one_sided_limit_has_one_acceptance_limit() -> None:
    guarded = rule({"lower": None}, rule="guard_band")
    assert guarded.accepted(0.2) == (-math.inf, 0.8)
    assert guarded.capability(0.2) == math.inf
    assert verdict(guarded, -99.0, 50.0) == "pass"


def test_a_guard_band_that_leaves_nothing_to_accept_decides_nothing() -> None:
    wide = rule(rule="guard_band", guard_band_factor=2.0)
    assert verdict(wide, 0.0, 0.6) == "inconclusive"
    assert verdict(wide, 0.0, 0.5) == "pass"
    assert verdict(wide, 1.7, 0.6) == "fail"


def test_a_shared_risk_asks_for_the_agreed_uncertainty_only() -> None:
    shared = rule({"U_max": 1.5}, rule="shared_risk")
    assert [verdict(shared, 0.9, U) for U in (1.5, 1.6)] == ["pass", "inconclusive"]
    assert verdict(rule(rule="shared_risk", min_capability=3.0), 0.9, 0.4) == "inconclusive"


def test_an_agreed_uncertainty_bounds_a_one_sided_limit_too() -> None:
    bounded = rule({"lower": None, "U_max": 0.1})
    assert [verdict(bounded, 0.0, U) for U in (0.1, 0.11)] == ["pass", "inconclusive"]


def test_a_one_sided_limit_that_nothing_bounds_is_decided_on_only_where_it_is_clear() -> None:
    alone = rule({"lower": None})
    assert [verdict(alone, v, 50.0) for v in (0.99, -99.0, 99.0)] == [
        "inconclusive",
        "pass",
        "fail",
    ]
    assert [verdict(alone, v, 0.1) for v in (0.9, 0.97, 1.03, 1.1)] == [
        "pass",
        "inconclusive",
        "inconclusive",
        "fail",
    ]


def test_what_is_accepted_outside_its_limits_is_marginal_however_far() -> None:
    generous = rule(rule="guard_band", guard_band_factor=-1.0)
    assert verdict(generous, 1.25, 0.25) == "pass"
    assert marginal(generous, 1.25, 0.25)


def test_marginal_is_nearer_than_u_on_either_side() -> None:
    plain = rule()
    near = [marginal(plain, v, 0.1) for v in (0.85, 0.95, 1.05, 1.15, -0.95, -1.05, 0.0)]
    assert near == [False, True, True, False, True, True, False]


@given(VALUE, U_OF)
def test_without_a_guard_band_the_rule_is_simple_acceptance(value: float, U: float) -> None:
    none = rule(rule="guard_band", guard_band_factor=0.0)
    assert verdict(none, value, U) == verdict(rule(), value, U)


@given(VALUE, U_OF, st.floats(0, 2), st.floats(0, 2))
def test_a_wider_guard_band_never_accepts_more(
    value: float, U: float, factor: float, more: float
) -> None:
    narrow = rule(rule="guard_band", guard_band_factor=factor)
    wide = rule(rule="guard_band", guard_band_factor=factor + more)
    assert not (verdict(wide, value, U) == "pass" and verdict(narrow, value, U) != "pass")


@given(VALUE, U_OF, st.sampled_from([(-1.0, 1.0), (None, 1.0), (-1.0, None)]))
def test_what_a_full_guard_band_accepts_is_falsely_accepted_at_most_once_in_forty(
    value: float, U: float, sides: tuple[float | None, float | None]
) -> None:
    """One limit: Φ(−2) = 2.275 %. Two: twice that where both are a whole U away, 4.6 %."""
    guarded = rule({"lower": sides[0], "upper": sides[1]}, rule="guard_band")
    if verdict(guarded, value, U) == "pass":
        risk = probability_of_nonconformity(value, U / 2, guarded.limits)
        both = None not in sides and guarded.capability(U) < 1.5
        assert risk <= (0.0456 if both else 0.0230)
        assert not marginal(guarded, value, U)


@given(VALUE, U_OF)
def test_the_marginal_band_is_symmetric(value: float, U: float) -> None:
    plain = rule()
    assert marginal(plain, value, U) == marginal(plain, -value, U)
    assert verdict(plain, value, U) == verdict(plain, -value, U)


@pytest.mark.parametrize("factor", [0.0, 1.0])
def test_the_acceptance_limit_itself_is_accepted(factor: float) -> None:
    guarded = rule(rule="guard_band", guard_band_factor=factor)
    assert all(verdict(guarded, edge, 0.25) == "pass" for edge in guarded.accepted(0.25))
