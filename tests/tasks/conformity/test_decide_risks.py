"""Doubts, conditional verdicts and the risks that each verdict carries."""

from typing import Any

import pytest
from sample_results import BIAS, bias_limit, calibration, item, tolerance, with_uncertainty
from scipy.special import ndtr

from schemas.text import Remark, Statement
from schemas.tolerance import Limit, ProductionPrior
from schemas.uncertainty import Budget
from tasks.conformity import Doubt, decide

DOUBT = Statement(en="its validation failed", zh="其验证未通过")


@pytest.mark.parametrize("y", [-0.02, -0.06])
def test_a_doubt_about_an_item_leaves_it_undecided_and_readable(y: float) -> None:
    decision = decide(calibration({"gyro_bias": item(BIAS | {"y": y})}), tolerance(bias_limit()),
                      doubts_of={"gyro_bias": Doubt(DOUBT)})  # fmt: skip
    assert decision.verdict == "inconclusive"
    assert {made.verdict for made in decision.limits} == {"inconclusive"}
    assert [made.value for made in decision.limits] == [0.01, y, 0.03]
    assert (decision.reasons, decision.reasons_zh) == ((DOUBT.en,), (DOUBT.zh,))


def test_a_doubt_about_an_item_without_a_limit_does_not_count() -> None:
    decision = decide(calibration({"gyro_bias": item(BIAS), "accel_bias": item(BIAS, "m/s2")}),
                      tolerance(bias_limit()), doubts_of={"accel_bias": Doubt(DOUBT)})  # fmt: skip
    assert (decision.verdict, decision.reasons) == ("pass", ())


def test_a_doubt_about_one_item_does_not_hide_that_another_fails() -> None:
    items = {"gyro_bias": item(BIAS | {"x": 1.0}), "accel_bias": item(BIAS, "m/s2")}
    limits = tolerance(bias_limit(), Limit(item="accel_bias", unit="m/s2", magnitude=1.0))
    decision = decide(calibration(items), limits, doubts_of={"accel_bias": Doubt(DOUBT)})
    assert decision.verdict == "fail"
    assert DOUBT.en in decision.reasons


def test_a_failure_outranks_a_condition_that_was_not_met_and_names_both() -> None:
    warm = Remark(code="temperature", en="It was 31 °C.", zh="温度为31 °C。", blocks_pass=True)
    result = calibration({"gyro_bias": item(BIAS | {"x": 0.2})}, remarks=(warm,))
    decision = decide(result, tolerance(bias_limit()))
    assert decision.verdict == "fail"
    assert [reason for reason in decision.reasons if "outside" in reason or "31" in reason] == [
        *decision.reasons
    ]


@pytest.mark.parametrize(
    ("values", "verdict", "marginal"),
    [
        ((0.01, 0.02, 0.03), "pass", False),
        ((0.01, 0.02, 0.0495), "pass", True),
        ((0.01, 0.02, 0.0505), "fail", True),
        ((0.01, 0.0495, 0.0505), "fail", True),
        ((0.2, 0.02, 0.0505), "fail", False),
        ((0.0495, None, 0.0), "inconclusive", False),
    ],
)
def test_a_verdict_is_conditional_where_it_hangs_on_values_within_u_of_a_limit(
    values: tuple[float | None, ...], verdict: str, marginal: bool
) -> None:
    result = calibration({"gyro_bias": item(dict(zip("xyz", values, strict=True)))})
    decision = decide(result, tolerance(bias_limit()))
    assert (decision.verdict, decision.marginal) == (verdict, marginal)


def test_each_verdict_carries_its_own_risk() -> None:
    """u is U/2 = 0.0005: 0.0495 lies one u inside the limit, 0.0510 two u outside."""
    result = calibration({"gyro_bias": item({"x": 0.0495, "y": 0.0510, "z": None})})
    passed, failed, open_ = decide(result, tolerance(bias_limit())).limits
    assert passed.false_acceptance == pytest.approx(0.1587, abs=1e-4)
    assert failed.false_rejection == pytest.approx(0.0228, abs=1e-4)
    assert (passed.false_rejection, failed.false_acceptance) == (None, None)
    assert passed.probability_of_conformity == pytest.approx(0.8413, abs=1e-4)
    assert open_.probability_of_conformity is None
    assert passed.capability == pytest.approx(50.0)


def test_few_degrees_of_freedom_make_a_decision_riskier() -> None:
    budget = Budget(result="x", unit="deg/s", value=0.0495, inputs=(), u_c=0.0005, dof=3, k=2.0,
                    coverage_probability=0.95, U=0.001)  # fmt: skip
    plain = item({"x": 0.0495, "y": 0.0495, "z": 0.0495})
    budgeted = plain.model_copy(update={"budgets": {"x": budget}})
    x, y, _ = decide(calibration({"gyro_bias": budgeted}), tolerance(bias_limit())).limits
    assert x.false_acceptance == pytest.approx(0.1955, abs=1e-4)  # t table: P(t₃ > 1)
    assert y.false_acceptance == pytest.approx(0.1587, abs=1e-4)


def test_a_prior_gives_the_risks_over_the_production() -> None:
    limited = tolerance(bias_limit(prior=ProductionPrior(mean=0.0, sd=0.025)))
    made = decide(calibration({"gyro_bias": item(BIAS)}), limited).limits[0]
    assert made.global_risks is not None
    assert 0 < made.global_risks.consumer < made.global_risks.producer < 0.002


def test_a_value_in_the_guard_band_fails_and_says_where_it_lies() -> None:
    limited = tolerance(bias_limit(rule="guard_band"))
    decision = decide(calibration({"gyro_bias": item(BIAS | {"z": 0.0495})}), limited)
    assert decision.verdict == "fail"
    assert decision.reasons == (
        "Gyro bias B_gz: 0.0495 °/s, U = 0.0010 °/s (k = 2), is inside ±0.05 °/s but outside the "
        "acceptance limits ±0.0490 °/s (conditional fail, false rejection 84.1 %)",
    )


def test_a_relative_limit_is_named_as_it_was_given() -> None:
    limited = tolerance(bias_limit(lower=None, upper=None, relative=True, nominal=0.4,
                                   magnitude=0.05))  # fmt: skip
    result = calibration({"gyro_bias": item({"x": 0.40, "y": 0.43, "z": 0.41})})
    (reason,) = decide(result, limited).reasons
    assert "is outside 0.38 … 0.42 °/s (±5 % × 0.4 °/s)" in reason


@pytest.mark.parametrize(
    ("limit", "why", "why_zh"),
    [
        ({"rule": "shared_risk", "U_max": 0.02}, "larger than the agreed 0.02 °/s",
         "大于约定的 0.02 °/s"),
        ({"min_capability": 3.0}, "C_m = T/(2 U) = 1.7 for ±0.05 °/s, below 3",
         "C_m = T/(2 U) = 1.7，小于 3"),
    ],
)  # fmt: skip
def test_an_uncertainty_too_large_for_its_rule_says_for_which(
    limit: dict[str, Any], why: str, why_zh: str
) -> None:
    decision = with_uncertainty(0.01, 0.03, **limit)
    assert decision.verdict == "inconclusive"
    assert why in decision.reasons[0]
    assert why_zh in decision.reasons_zh[0]


def test_the_value_without_earth_rotation_is_decided_on_with_its_own_uncertainty() -> None:
    g: dict[str, float | None] = dict.fromkeys((a + b for a in "xyz" for b in "xyz"), 0.0095)
    own = dict.fromkeys(g, 0.004)
    result = item(g, unit="(deg/s)/g", value_without_earth_rotation=g)
    limit = Limit(item="gyro_g_sensitivity", unit="(deg/s)/g", magnitude=0.01,
                  applied_to="value_without_earth_rotation")  # fmt: skip
    for uncertain, U in ((result, 0.001), (result.model_copy(
            update={"U_without_earth_rotation": own}), 0.004)):  # fmt: skip
        made = decide(calibration({"gyro_g_sensitivity": uncertain}), tolerance(limit)).limits[0]
        assert made.U == U
        assert made.false_acceptance == pytest.approx(ndtr(-0.0005 / (U / 2)), abs=1e-6)
