"""What a certificate made without the physics is worth, and one made with it."""

from typing import Any

import pytest

from tests.proof.trial.cost import LIMIT, cost_of


def stated(*values: float, U: float = 0.1, scatter: int = 0) -> dict[str, Any]:
    return {"values": {f"item {n}": [v, U] for n, v in enumerate(values)}, "scatter": scatter}


def test_error_is_counted_in_the_certificates_own_uncertainty() -> None:
    cost = cost_of(stated(1.0, 2.0), stated(1.1, 2.4, U=0.2), stated(1.0, 2.1), seed=1)
    assert cost is not None
    assert cost.before == pytest.approx(2.0)
    assert cost.worst == "item 1"
    assert cost.after == pytest.approx(1.0)


def test_where_nothing_was_taken_off_the_error_stays() -> None:
    cost = cost_of(stated(1.0), stated(1.3), None, seed=1)
    assert cost is not None
    assert cost.after == cost.before == pytest.approx(3.0)
    assert cost.wrong_after == cost.wrong_before


def test_only_values_that_every_certificate_states_are_compared() -> None:
    assert cost_of(None, stated(1.0), None, seed=1) is None
    assert cost_of(stated(1.0), None, None, seed=1) is None
    assert cost_of(stated(), stated(1.0), None, seed=1) is None
    cost = cost_of(stated(1.0), stated(1.2, 99.0), stated(1.0), seed=1)
    assert cost is not None
    assert cost.worst == "item 0"


def test_nine_units_of_ten_conform_when_as_many_values_are_judged_as_on_a_certificate() -> None:
    clean = stated(*range(42))
    conform = [cost_of(clean, clean, None, seed) for seed in range(400)]
    share = sum(one is not None and one.conforms for one in conform) / 400
    assert 0.84 < share < 0.94
    assert not any(one is None or one.wrong_before for one in conform)


def test_error_turns_verdicts_both_ways() -> None:
    clean, off = stated(0.0), stated(1.5 * LIMIT * 0.1)
    costs = [cost_of(clean, off, clean, seed) for seed in range(2000)]
    failed = [one for one in costs if one and one.conforms and one.verdict_before == "fail"]
    passed = [one for one in costs if one and one.verdict_before == "pass" and not one.conforms]
    assert len(failed) > 1500
    assert passed  # units that changed by more than the limit the other way
    assert all(one and one.wrong_before for one in (*failed, *passed))
    assert not any(one and one.wrong_after for one in costs)


def test_value_whose_uncertainty_is_beyond_the_limits_is_left_open() -> None:
    clean = stated(0.0)
    for value, verdict in ((0.0, "inconclusive"), (0.6, "inconclusive"), (50.0, "fail")):
        cost = cost_of(clean, stated(value, U=1.1 * LIMIT * 0.1), None, seed=3)
        assert cost is not None
        assert cost.verdict_before == verdict


def test_more_scatter_than_without_the_effects_is_noticed() -> None:
    clean = stated(1.0, scatter=1)
    for scatter, unnoticed in ((0, True), (1, True), (2, False)):
        cost = cost_of(clean, stated(1.0, scatter=scatter), None, seed=1)
        assert cost is not None
        assert cost.unnoticed is unnoticed
