"""Decision rules: where a value is accepted, and when nothing is decided."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from schemas.tolerance import Limit, Tolerance
from tasks.conformity.risks import probability_of_nonconformity
from tasks.conformity.rules import Criterion, criterion

VALUE = st.floats(-3, 3)
U_OF = st.floats(0.001, 1.0)


def rule(limit: dict[str, Any] | None = None, **file: Any) -> Criterion:
    made = Limit(**({"item": "b", "unit": "1", "lower": -1.0, "upper": 1.0} | (limit or {})))
    tolerance = Tolerance(manufacturer="m", model="m", document="d", limits=(made,), **file)
    return criterion(tolerance, made)


def test_a_guard_band_moves_both_limits_inwards_by_u() -> None:
    guarded = rule(rule="guard_band")
    assert guarded.accepted(0.25) == (-0.75, 0.75)
    assert [guarded.verdict(v, 0.25) for v in (0.75, 0.76, 1.2)] == ["pass", "fail", "fail"]


def test_a_negative_factor_rejects_only_beyond_doubt() -> None:
    guarded = rule(rule="guard_band", guard_band_factor=-1.0)
    assert [guarded.verdict(v, 0.25) for v in (1.2, 1.3)] == ["pass", "fail"]


def test_the_rule_of_a_limit_outranks_that_of_its_file() -> None:
    own = rule({"rule": "guard_band", "guard_band_factor": 0.5}, rule="simple_acceptance")
    assert own.accepted(0.2) == (-0.9, 0.9)
    assert rule({"rule": "simple_acceptance"}, rule="guard_band").accepted(0.2) == (-1.0, 1.0)
    file = {"rule": "guard_band", "guard_band_factor": 0.5}
    assert rule({"guard_band_factor": 2.0}, **file).accepted(0.2) == (-0.6, 0.6)
    assert rule({"min_capability": 4.0}).verdict(0.0, 0.3) == "inconclusive"
    assert rule({"min_capability": 0.5}, min_capability=4.0).verdict(0.0, 1.5) == "pass"


def test_a_one_sided_limit_has_one_acceptance_limit() -> None:
    guarded = rule({"lower": None}, rule="guard_band")
    assert guarded.accepted(0.2) == (-math.inf, 0.8)
    assert guarded.capability(0.2) == math.inf
    assert guarded.verdict(-99.0, 50.0) == "pass"


def test_a_guard_band_that_leaves_nothing_to_accept_decides_nothing() -> None:
    wide = rule(rule="guard_band", guard_band_factor=2.0)
    assert wide.verdict(0.0, 0.6) == "inconclusive"
    assert wide.verdict(0.0, 0.5) == "pass"
    assert wide.verdict(1.7, 0.6) == "fail"


def test_a_shared_risk_asks_for_the_agreed_uncertainty_only() -> None:
    shared = rule({"U_max": 1.5}, rule="shared_risk")
    assert [shared.verdict(0.9, U) for U in (1.5, 1.6)] == ["pass", "inconclusive"]
    assert rule(rule="shared_risk", min_capability=3.0).verdict(0.9, 0.4) == "inconclusive"


def test_an_agreed_uncertainty_bounds_a_one_sided_limit_too() -> None:
    bounded = rule({"lower": None, "U_max": 0.1})
    assert [bounded.verdict(0.0, U) for U in (0.1, 0.11)] == ["pass", "inconclusive"]


def test_marginal_is_nearer_than_u_on_either_side() -> None:
    plain = rule()
    near = [plain.marginal(v, 0.1) for v in (0.85, 0.95, 1.05, 1.15, -0.95, -1.05, 0.0)]
    assert near == [False, True, True, False, True, True, False]


@given(VALUE, U_OF)
def test_without_a_guard_band_the_rule_is_simple_acceptance(value: float, U: float) -> None:
    none = rule(rule="guard_band", guard_band_factor=0.0)
    assert none.verdict(value, U) == rule().verdict(value, U)


@given(VALUE, U_OF, st.floats(0, 2), st.floats(0, 2))
def test_a_wider_guard_band_never_accepts_more(
    value: float, U: float, factor: float, more: float
) -> None:
    narrow = rule(rule="guard_band", guard_band_factor=factor)
    wide = rule(rule="guard_band", guard_band_factor=factor + more)
    assert not (wide.verdict(value, U) == "pass" and narrow.verdict(value, U) != "pass")


@given(VALUE, U_OF, st.sampled_from([(-1.0, 1.0), (None, 1.0), (-1.0, None)]))
def test_what_a_full_guard_band_accepts_is_falsely_accepted_at_most_once_in_forty(
    value: float, U: float, sides: tuple[float | None, float | None]
) -> None:
    """One limit: Φ(−2) = 2.275 %. Two: twice that where both are a whole U away, 4.6 %."""
    guarded = rule({"lower": sides[0], "upper": sides[1]}, rule="guard_band")
    if guarded.verdict(value, U) == "pass":
        risk = probability_of_nonconformity(value, U / 2, guarded.limits)
        both = None not in sides and guarded.capability(U) < 1.5
        assert risk <= (0.0456 if both else 0.0230)
        assert not guarded.marginal(value, U)


@given(VALUE, U_OF)
def test_the_marginal_band_is_symmetric(value: float, U: float) -> None:
    plain = rule()
    assert plain.marginal(value, U) == plain.marginal(-value, U)
    assert plain.verdict(value, U) == plain.verdict(-value, U)


@pytest.mark.parametrize("factor", [0.0, 1.0])
def test_the_acceptance_limit_itself_is_accepted(factor: float) -> None:
    guarded = rule(rule="guard_band", guard_band_factor=factor)
    assert all(guarded.verdict(edge, 0.25) == "pass" for edge in guarded.accepted(0.25))
