"""The verdict: what passes, what fails, what nobody can say."""

import math
import re
from datetime import date
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.special import ndtr

from schemas.base import Unusable
from schemas.calibration import Budget, Calibration, SegmentUsed
from schemas.certificate import ConditionName
from schemas.laboratory import MeasurementStandard
from schemas.recording import AXES, Unit
from schemas.station import Configuration, configuration_of
from schemas.text import Remark, Statement
from schemas.tolerance import Decision, Limit, ProductionPrior, Tolerance
from tasks.conformity import Doubt, decide, deviations, expired
from tasks.conformity.decide import (
    Criterion,
    criterion,
    global_risks,
    probability_of_conformity,
    probability_of_nonconformity,
)
from tasks.conformity.limits import accepted_edges, accepted_text, conditional
from tasks.words import say, statement
from tests.tasks.conformity.sample_results import (
    BIAS,
    bias_limit,
    calibration,
    item,
    tolerance,
    with_uncertainty,
)


def verdict_of(value: dict[str, float | None], **limit: Any) -> str:
    return decide(calibration({"gyro_bias": item(value)}), tolerance(bias_limit(**limit))).verdict


def test_inside_every_limit_passes_without_reasons():
    decision = decide(calibration({"gyro_bias": item(BIAS)}), tolerance(bias_limit()))
    assert decision.verdict == "pass"
    assert [made.verdict for made in decision.limits] == ["pass"] * 3
    assert (decision.reasons, decision.document) == ((), "Q/1")
    assert decision.rule == "simple_acceptance"


def test_one_element_outside_fails_and_is_named_in_both_languages():
    decision = decide(
        calibration({"gyro_bias": item(BIAS | {"y": -0.06})}), tolerance(bias_limit())
    )
    assert decision.verdict == "fail"
    assert [made.verdict for made in decision.limits] == ["pass", "fail", "pass"]
    assert decision.reasons == (
        "Gyro bias B_gy: −0.0600 °/s, U = 0.0010 °/s (k = 2), is outside ±0.05 °/s "
        "(false rejection < 0.1 %)",
    )
    assert decision.reasons_zh == (
        "陀螺零偏 B_gy：−0.0600 °/s，U = 0.0010 °/s（k = 2），超出 ±0.05 °/s"
        "（错误拒绝概率 < 0.1 %）",
    )


def test_an_upper_limit_alone_leaves_the_bottom_open():
    assert verdict_of({"x": -9.0, "y": 0.0, "z": 0.0}, lower=None) == "pass"
    assert verdict_of({"x": 0.06, "y": 0.0, "z": 0.0}, lower=None) == "fail"


@pytest.mark.parametrize("missing", [None, math.nan, math.inf])
def test_a_missing_or_non_finite_element_is_inconclusive(missing):
    broken = item(BIAS).model_copy(update={"value": BIAS | {"z": missing}})
    decision = decide(calibration({}).model_copy(update={"items": {"gyro_bias": broken}}),
                      tolerance(bias_limit()))  # fmt: skip
    assert decision.verdict == "inconclusive"
    assert decision.limits[2].value is None
    assert decision.reasons == ("Gyro bias (z) not determined: no cause stated",)


def test_an_unavailable_item_is_inconclusive_with_its_reason():
    result = calibration(
        {}, {"gyro_bias": "only 5 of 12 positions"}, unavailable_zh={"gyro_bias": "仅有5个位置"}
    )
    decision = decide(result, tolerance(bias_limit()))
    assert decision.verdict == "inconclusive"
    assert [made.element for made in decision.limits] == ["x", "y", "z"]
    assert decision.reasons == ("Gyro bias (x, y, z) not determined: only 5 of 12 positions",)
    assert decision.reasons_zh == ("陀螺零偏（x, y, z）未得：仅有5个位置",)


def test_an_item_called_unavailable_does_not_pass_on_the_numbers_it_has():
    result = calibration({"gyro_bias": item(BIAS)}, {"gyro_bias": "table fault"})
    assert decide(result, tolerance(bias_limit())).verdict == "inconclusive"


def test_a_foreign_unavailable_item_is_inconclusive_too():
    result = calibration({"gyro_bias": item(BIAS)}, {"odd": "not seen"})
    limits = tolerance(bias_limit(), Limit(item="odd", unit="1", upper=1.0))
    assert decide(result, limits).verdict == "inconclusive"


def test_only_listed_elements_are_limited():
    assert verdict_of({"x": 0.01, "y": None, "z": 9.0}, elements=("x",)) == "pass"


def test_a_remark_that_blocks_a_pass_makes_it_inconclusive():
    warm = Remark(code="temperature", en="It was 31 °C.", zh="温度为31 °C。", blocks_pass=True)
    result = calibration({"gyro_bias": item(BIAS)}, remarks=(warm,))
    decision = decide(result, tolerance(bias_limit()))
    assert decision.verdict == "inconclusive"
    assert (decision.reasons, decision.reasons_zh) == (("It was 31 °C.",), ("温度为31 °C。",))


def test_no_tolerance_is_inconclusive():
    decision = decide(calibration({"gyro_bias": item(BIAS)}), None)
    assert (decision.verdict, decision.document, decision.limits) == ("inconclusive", None, ())
    assert len(decision.reasons) == len(decision.reasons_zh) == 1


@pytest.mark.parametrize(
    ("limit", "names"),
    [
        (bias_limit(unit="rad/s"), "'rad/s'"),
        (bias_limit(item="gyro_bais"), "gyro_bais"),
        (bias_limit(elements=("x", "w")), "'w'"),
        (bias_limit(elements=()), "x, y, z"),
        (bias_limit(applied_to="value_model"), "value_model"),
    ],
)
def test_a_limit_that_does_not_fit_the_result_is_refused(limit, names):
    with pytest.raises(Unusable, match=names):
        decide(calibration({"gyro_bias": item(BIAS)}), tolerance(limit))


def g_sensitivity(**limit: Any) -> Decision:
    g = {a + b: 0.012 for a in "xyz" for b in "xyz"}
    earth = {element: value - 0.003 for element, value in g.items()}
    result = item(g, unit="(deg/s)/g", value_without_earth_rotation=earth)
    limited = Limit(item="gyro_g_sensitivity", unit="(deg/s)/g", magnitude=0.01, **limit)
    return decide(calibration({"gyro_g_sensitivity": result}), tolerance(limited))


def test_a_g_sensitivity_limit_says_which_quantity_it_applies_to():
    assert g_sensitivity().verdict == "fail"
    corrected = g_sensitivity(applied_to="value_without_earth_rotation")
    assert corrected.verdict == "pass"
    assert corrected.limits[0].applied_to == "value_without_earth_rotation"
    assert corrected.limits[0].value == pytest.approx(0.009)


def test_a_quantity_that_could_not_be_computed_is_inconclusive():
    result = item({a + b: 0.001 for a in "xyz" for b in "xyz"}, unit="(deg/s)/g")
    limit = Limit(item="gyro_g_sensitivity", unit="(deg/s)/g", magnitude=0.01,
                  applied_to="value_without_earth_rotation")  # fmt: skip
    decision = decide(calibration({"gyro_g_sensitivity": result}), tolerance(limit))
    assert decision.verdict == "inconclusive"


@pytest.mark.parametrize("value", [0.01, -0.06])
def test_an_uncertainty_wider_than_half_the_limits_decides_nothing(value):
    decision = with_uncertainty(value, 0.051)
    assert decision.verdict == "inconclusive"
    assert {made.verdict for made in decision.limits} == {"inconclusive"}
    assert "U = 0.051 °/s, larger than half the interval ±0.05 °/s" in decision.reasons[0]
    assert "U = 0.051 °/s，大于允许区间 ±0.05 °/s 的一半" in decision.reasons_zh[0]


def test_a_one_sided_limit_without_a_bound_on_u_asks_for_one():
    decision = with_uncertainty(0.01, 5.0, lower=None)
    assert decision.verdict == "inconclusive"
    assert {made.verdict for made in decision.limits} == {"inconclusive"}
    assert "is 50.6 %, and U is not limited: specify U_max" in decision.reasons[0]
    assert "合格概率为 50.6 %" in decision.reasons_zh[0]
    assert with_uncertainty(0.01, 0.02, lower=None).verdict == "pass"


def test_a_pass_outside_the_limits_is_conditional():
    decision = with_uncertainty(
        0.0625, 0.0125, lower=None, rule="guard_band", guard_band_factor=-1.0, U_max=1.0
    )
    assert (decision.verdict, decision.marginal) == ("pass", True)
    assert "accepted but lies outside its limit" in say(conditional(decision)[0], "en")


@pytest.mark.parametrize("U", [None, 0.0])
@pytest.mark.parametrize("value", [0.01, 9.0])
def test_no_uncertainty_or_one_of_zero_is_inconclusive(value, U):
    decision = with_uncertainty(value, U)
    assert decision.verdict == "inconclusive"
    assert decision.reasons == (
        "Gyro bias (x, y, z): no uncertainty above zero was obtained, so no decision is possible",
    )


def test_a_failure_that_rounding_would_hide_has_as_many_digits_as_show_it():
    (x, *_) = with_uncertainty(0.0500004123456789, 0.001).reasons
    assert x == (
        "Gyro bias B_gx: 0.0500004 °/s, U = 0.0010 °/s (k = 2), is outside ±0.05 °/s "
        "(conditional fail, false rejection 50.0 %)"
    )


def test_further_doubts_prevent_a_pass_and_stand_among_the_reasons():
    doubt = Statement(en="the lamp flickered", zh="灯闪烁")
    decision = decide(
        calibration({"gyro_bias": item(BIAS)}), tolerance(bias_limit()), doubts=(doubt,)
    )
    assert decision.verdict == "inconclusive"
    assert (decision.reasons, decision.reasons_zh) == (("the lamp flickered",), ("灯闪烁",))


def standard(valid_until: date | None) -> MeasurementStandard:
    return MeasurementStandard(
        name="Table", name_zh="转台", serial="T-1", accuracy="", certificate="",
        valid_until=valid_until,
    )  # fmt: skip


def test_a_standard_that_ran_out_before_the_day_is_a_reason():
    last = date(2026, 11, 20)
    assert expired([standard(last), standard(None)], last) == ()
    (reason,) = expired([standard(last)], date(2026, 11, 21))
    assert statement(reason).pair == (
        "Table (T-1): its certificate was valid until 2026-11-20, before 2026-11-21",
        "转台（T-1）：其证书有效期至 2026-11-20，早于 2026-11-21",
    )


def test_a_second_value_missing_off_the_diagonal_leaves_the_diagonal_decided():
    g: dict[str, float | None] = {a + b: 0.001 for a in "xyz" for b in "xyz"}
    earth = {element: v if element[0] == element[1] else None for element, v in g.items()}
    result = item(g, unit="(deg/s)/g", value_without_earth_rotation=earth)
    limit = Limit(item="gyro_g_sensitivity", unit="(deg/s)/g", magnitude=0.01,
                  applied_to="value_without_earth_rotation")  # fmt: skip
    why = {"gyro_g_sensitivity": "one heading only"}
    decision = decide(calibration({"gyro_g_sensitivity": result}, why), tolerance(limit))
    assert [made.element for made in decision.limits if made.verdict == "pass"] == [
        "xx",
        "yy",
        "zz",
    ]
    assert decision.reasons == (
        "Gyro g-sensitivity (xy, xz, yx, yz, zx, zy) not determined: one heading only",
    )


@given(st.dictionaries(st.sampled_from("xyz"), st.none() | st.floats(-0.1, 0.1)), st.booleans())
def test_a_pass_needs_every_element_inside_and_nothing_against_it(value, blocked):
    remarks = (Remark(code="c", en="e", zh="z", blocks_pass=blocked),)
    result = calibration({"gyro_bias": item(value)}, remarks=remarks)
    passed = decide(result, tolerance(bias_limit())).verdict == "pass"
    inside = [v is not None and abs(v) <= 0.05 for v in map(value.get, "xyz")]
    assert passed == (all(inside) and not blocked)


def test_where_u_is_larger_than_the_guard_bands_allow_there_is_no_acceptance_interval():
    decided = with_uncertainty(0.0, 0.056, rule="guard_band").limits[0]
    assert decided.verdict == "inconclusive"
    assert (decided.accept_lower, decided.accept_upper) == (None, None)
    assert accepted_text(decided) == "–"
    assert accepted_edges(decided) is None
    exact_fit = with_uncertainty(0.0, 0.05, rule="guard_band").limits[0]
    assert (exact_fit.accept_lower, exact_fit.accept_upper) == (0.0, 0.0)


@pytest.mark.parametrize("upper", [1.3338541310494842, 1.3338541310494846])
def test_no_reason_prints_the_binary_digits_of_a_limit_or_of_a_value_near_it(upper):
    decision = with_uncertainty(1.3338541310494844, 2.0, lower=0.0, upper=upper)
    assert decision.verdict == "inconclusive"
    digits = re.findall(r"\d+\.\d+", " ".join((*decision.reasons, *decision.reasons_zh)))
    assert digits
    assert max(map(len, digits)) <= len("1.33385413")


# Doubts, conditional verdicts and the risks that each verdict carries.

DOUBT = Statement(en="its validation failed", zh="其验证未通过")


@pytest.mark.parametrize("y", [-0.02, -0.06])
def test_a_doubt_about_an_item_leaves_it_undecided_and_readable(y):
    decision = decide(calibration({"gyro_bias": item(BIAS | {"y": y})}), tolerance(bias_limit()),
                      doubts_of={"gyro_bias": Doubt(DOUBT)})  # fmt: skip
    assert decision.verdict == "inconclusive"
    assert {made.verdict for made in decision.limits} == {"inconclusive"}
    assert [made.value for made in decision.limits] == [0.01, y, 0.03]
    assert (decision.reasons, decision.reasons_zh) == ((DOUBT.en,), (DOUBT.zh,))


def test_a_doubt_about_one_item_does_not_hide_that_another_fails():
    items = {"gyro_bias": item(BIAS | {"x": 1.0}), "accel_bias": item(BIAS, "m/s2")}
    limits = tolerance(bias_limit(), Limit(item="accel_bias", unit="m/s2", magnitude=1.0))
    decision = decide(calibration(items), limits, doubts_of={"accel_bias": Doubt(DOUBT)})
    assert decision.verdict == "fail"
    assert DOUBT.en in decision.reasons


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
    values, verdict, marginal
):
    result = calibration({"gyro_bias": item(dict(zip("xyz", values, strict=True)))})
    decision = decide(result, tolerance(bias_limit()))
    assert (decision.verdict, decision.marginal) == (verdict, marginal)


def test_each_verdict_carries_its_own_risk():
    """u is U/2 = 0.0005: 0.0495 lies one u inside the limit, 0.0510 two u outside."""
    result = calibration({"gyro_bias": item({"x": 0.0495, "y": 0.0510, "z": None})})
    passed, failed, open_ = decide(result, tolerance(bias_limit())).limits
    assert passed.false_acceptance == pytest.approx(0.1587, abs=1e-4)
    assert failed.false_rejection == pytest.approx(0.0228, abs=1e-4)
    assert (passed.false_rejection, failed.false_acceptance) == (None, None)
    assert passed.probability_of_conformity == pytest.approx(0.8413, abs=1e-4)
    assert open_.probability_of_conformity is None
    assert passed.capability == pytest.approx(50.0)


def test_few_degrees_of_freedom_make_a_decision_riskier():
    budget = Budget(result="x", unit="deg/s", value=0.0495, inputs=(), u_c=0.0005, dof=3, k=2.0,
                    coverage_probability=0.95, U=0.001)  # fmt: skip
    plain = item({"x": 0.0495, "y": 0.0495, "z": 0.0495})
    budgeted = plain.model_copy(update={"budgets": {"x": budget}})
    x, y, _ = decide(calibration({"gyro_bias": budgeted}), tolerance(bias_limit())).limits
    assert x.false_acceptance == pytest.approx(0.1955, abs=1e-4)  # t table: P(t₃ > 1)
    assert y.false_acceptance == pytest.approx(0.1587, abs=1e-4)


def test_the_value_without_earth_rotation_is_decided_on_with_its_own_uncertainty():
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


# Probabilities of conformity and risks against published figures and independent arithmetic.

REAL = st.floats(-10, 10)
SMALL = st.floats(0.01, 10)


@pytest.mark.parametrize(
    ("value", "u", "limits", "published"),
    [
        # JCGM 106, 7.3: breakdown voltage of a Zener diode, burst strength of a container;
        # 7.4: kinematic viscosity of a motor oil.
        (-5.47, 0.05, (-math.inf, -5.40), 0.92),
        (509.7, 8.6, (490.0, math.inf), 0.99),
        (13.6, 1.8, (12.5, 16.3), 0.66),
    ],
)
def test_worked_examples_of_jcgm_106_are_met(value, u, limits, published):
    assert round(probability_of_conformity(value, u, limits), 2) == published


@pytest.mark.parametrize(
    ("z", "published"), [(0.84, 0.80), (1.28, 0.90), (1.64, 0.95), (2.33, 0.99), (3.09, 0.999)]
)
def test_table_1_of_jcgm_106_is_met(z, published):
    """One limit at z standard uncertainties from the value, on either side."""
    for limits in ((-z, math.inf), (-math.inf, z)):
        conforms = probability_of_conformity(0.0, 1.0, limits)
        assert conforms == pytest.approx(published, abs=0.001)
        assert probability_of_nonconformity(0.0, 1.0, limits) == pytest.approx(1 - conforms)


@pytest.mark.parametrize(
    ("r", "published"), [(0.0, 0.50), (0.83, 0.05), (1.0, 0.025), (1.5, 0.0016), (3.0, 1e-6)]
)
def test_largest_risk_of_a_guard_band_is_that_of_ilac_g8(r, published):
    """ILAC-G8:09/2019, Table 1: a value on its acceptance limit, w = r·U with U = 2u."""
    assert probability_of_nonconformity(-2 * r, 1.0, (-math.inf, 0.0)) <= published
    assert probability_of_nonconformity(-2 * r, 1.0, (-math.inf, 0.0)) > 0.9e-3 * published


@pytest.mark.parametrize(
    ("sd", "u", "accepted", "consumer", "producer"),
    [
        # Deaver, How to maintain your confidence (1993): limits of 2 sd, ratio 4 and 2, the
        # second with an acceptance limit of 0.91 of the limit.
        (1.0, 0.25, 2.0, 0.008, 0.015),
        (1.0, 0.5, 1.82, 0.008, 0.066),
    ],
)
def test_published_global_risks_are_met(sd, u, accepted, consumer, producer):
    risks = global_risks(ProductionPrior(mean=0.0, sd=sd), u, (-2.0, 2.0), (-accepted, accepted))
    assert risks.consumer == pytest.approx(consumer, abs=0.0006)
    assert risks.producer == pytest.approx(producer, abs=0.0006)


@pytest.mark.parametrize("dof", [math.inf, 3.0, 17.5])
def test_a_probability_is_the_integral_of_the_density(dof):
    density = stats.norm(1.3, 0.4) if math.isinf(dof) else stats.t(dof, 1.3, 0.4)
    grid = np.linspace(0.9, 2.2, 20_001)
    plain = np.trapezoid(density.pdf(grid), grid)
    assert probability_of_conformity(1.3, 0.4, (0.9, 2.2), dof) == pytest.approx(plain, abs=1e-8)


@pytest.mark.parametrize("limits", [(-0.5, 1.2), (-math.inf, 0.7), (0.2, math.inf)])
def test_global_risks_are_those_of_the_bivariate_normal(limits):
    prior, u, shift = ProductionPrior(mean=0.3, sd=0.6), 0.2, 0.15
    accepted = limits[0] + shift, limits[1] - shift
    risks = global_risks(prior, u, limits, accepted)
    joint = stats.multivariate_normal(
        [0.3, 0.3], [[0.6**2, 0.6**2], [0.6**2, 0.6**2 + u**2]], seed=1
    )

    def box(part: tuple[float, float]) -> float:
        corners = ((part[1], accepted[1], 1), (part[0], accepted[1], -1),
                   (part[1], accepted[0], -1), (part[0], accepted[0], 1))  # fmt: skip
        return float(sum(sign * joint.cdf([x, y]) for x, y, sign in corners))

    inside, accepted_in_all = box(limits), box((-math.inf, math.inf))
    conform = stats.norm(0.3, 0.6).cdf(limits[1]) - stats.norm(0.3, 0.6).cdf(limits[0])
    assert risks.consumer == pytest.approx(accepted_in_all - inside, abs=1e-5)
    assert risks.producer == pytest.approx(conform - inside, abs=1e-5)


@given(REAL, SMALL, REAL, SMALL, st.floats(1, 50) | st.just(math.inf))
def test_both_probabilities_add_up_to_one(value, u, lower, width, dof):
    about = (value, u, (lower, lower + width), dof)
    total = probability_of_conformity(*about) + probability_of_nonconformity(*about)
    assert total == pytest.approx(1.0, abs=1e-12)


# Decision rules: where a value is accepted, and when nothing is decided.

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


def test_a_guard_band_moves_both_limits_inwards_by_u():
    guarded = rule(rule="guard_band")
    assert guarded.accepted(0.25) == (-0.75, 0.75)
    assert [verdict(guarded, v, 0.25) for v in (0.75, 0.76, 1.2)] == ["pass", "fail", "fail"]


def test_a_negative_factor_rejects_only_beyond_doubt():
    guarded = rule(rule="guard_band", guard_band_factor=-1.0)
    assert [verdict(guarded, v, 0.25) for v in (1.2, 1.3)] == ["pass", "fail"]


def test_a_file_without_rules_asks_for_simple_acceptance_and_a_capability_of_one():
    usual = rule()
    assert (usual.rule, usual.factor, usual.min_capability) == ("simple_acceptance", 0.0, 1.0)


def test_the_rule_of_a_limit_outranks_that_of_its_file():
    own = rule({"rule": "guard_band", "guard_band_factor": 0.5}, rule="simple_acceptance")
    assert own.accepted(0.2) == (-0.9, 0.9)
    assert rule({"rule": "simple_acceptance"}, rule="guard_band").accepted(0.2) == (-1.0, 1.0)
    file = {"rule": "guard_band", "guard_band_factor": 0.5}
    assert rule({"guard_band_factor": 2.0}, **file).accepted(0.2) == (-0.6, 0.6)
    assert verdict(rule({"min_capability": 4.0}), 0.0, 0.3) == "inconclusive"
    assert verdict(rule({"min_capability": 0.5}, min_capability=4.0), 0.0, 1.5) == "pass"


def test_a_one_sided_limit_has_one_acceptance_limit():
    guarded = rule({"lower": None}, rule="guard_band")
    assert guarded.accepted(0.2) == (-math.inf, 0.8)
    assert guarded.capability(0.2) == math.inf
    assert verdict(guarded, -99.0, 50.0) == "pass"


def test_a_guard_band_that_leaves_nothing_to_accept_decides_nothing():
    wide = rule(rule="guard_band", guard_band_factor=2.0)
    assert verdict(wide, 0.0, 0.6) == "inconclusive"
    assert verdict(wide, 0.0, 0.5) == "pass"
    assert verdict(wide, 1.7, 0.6) == "fail"


def test_a_shared_risk_asks_for_the_agreed_uncertainty_only():
    shared = rule({"U_max": 1.5}, rule="shared_risk")
    assert [verdict(shared, 0.9, U) for U in (1.5, 1.6)] == ["pass", "inconclusive"]
    assert verdict(rule(rule="shared_risk", min_capability=3.0), 0.9, 0.4) == "inconclusive"


def test_a_one_sided_limit_that_nothing_bounds_is_decided_on_only_where_it_is_clear():
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


def test_what_is_accepted_outside_its_limits_is_marginal_however_far():
    generous = rule(rule="guard_band", guard_band_factor=-1.0)
    assert verdict(generous, 1.25, 0.25) == "pass"
    assert marginal(generous, 1.25, 0.25)


def test_marginal_is_nearer_than_u_on_either_side():
    plain = rule()
    near = [marginal(plain, v, 0.1) for v in (0.85, 0.95, 1.05, 1.15, -0.95, -1.05, 0.0)]
    assert near == [False, True, True, False, True, True, False]


@given(VALUE, U_OF, st.sampled_from([(-1.0, 1.0), (None, 1.0), (-1.0, None)]))
def test_what_a_full_guard_band_accepts_is_falsely_accepted_at_most_once_in_forty(value, U, sides):
    """One limit: Φ(−2) = 2.275 %. Two: twice that where both are a whole U away, 4.6 %."""
    guarded = rule({"lower": sides[0], "upper": sides[1]}, rule="guard_band")
    if verdict(guarded, value, U) == "pass":
        risk = probability_of_nonconformity(value, U / 2, guarded.limits)
        both = None not in sides and guarded.capability(U) < 1.5
        assert risk <= (0.0456 if both else 0.0230)
        assert not marginal(guarded, value, U)


@pytest.mark.parametrize("factor", [0.0, 1.0])
def test_the_acceptance_limit_itself_is_accepted(factor):
    guarded = rule(rule="guard_band", guard_band_factor=factor)
    assert all(verdict(guarded, edge, 0.25) == "pass" for edge in guarded.accepted(0.25))


# Conditions that were not met, or not checked: deviations that prevent a pass unless waived.

WAIVED: tuple[ConditionName, ...] = ("largest_rate", "environment")


def turned(to: float, axes: tuple[str, ...] = AXES, **more: Any) -> Calibration:
    segments = [
        {"name": axis, "kind": "rate", "t_start": 0, "t_end": 30, "origin": "label", "axis": axis,
         "rate_deg_s": to, "rows": 9}
        for axis in axes
    ]  # fmt: skip
    return calibration({}).model_copy(
        update={"segments": tuple(map(SegmentUsed.model_validate, segments))} | more
    )


def names(result: Calibration, largest: float | None) -> list[str]:
    return [each.name for each in deviations(result, Configuration(rate_range_deg_s=largest))]


def test_the_largest_rate_of_the_units_range_has_to_be_included_about_every_axis():
    assert names(turned(-500.0), 500.0) == []
    assert names(turned(300.0), 500.0) == ["largest_rate"]
    assert names(turned(500.0, ("x", "y")), 500.0) == ["largest_rate"]


def test_a_range_that_nobody_states_was_not_checked():
    assert names(turned(500.0), None) == ["largest_rate"]


def test_a_unit_that_was_not_turned_has_no_largest_rate_to_check():
    assert names(calibration({}), None) == []


def test_jjf_1536_asks_for_rates_within_the_range_and_not_for_the_largest():
    assert names(turned(100.0, method="jjf1536"), 500.0) == []


def test_air_that_was_not_recorded_is_a_condition_that_was_not_checked():
    remark = Remark(code="environment_not_recorded", en="Air.", zh="Air.")
    assert names(turned(500.0, remarks=(remark,)), 500.0) == ["environment"]


@pytest.mark.parametrize("waived", [(), WAIVED])
def test_what_the_order_waives_is_still_told(waived):
    (each,) = deviations(turned(300.0), Configuration(rate_range_deg_s=500.0), waived)
    assert each.waived == bool(waived)
    assert each.printed.id == f"conformity-deviation.{'waived' if waived else 'open'}"


def test_the_order_adds_to_the_manifest_and_may_not_contradict_it():
    unit = Unit.model_validate(
        {"manufacturer": "M", "model": "U", "serial": "1", "rate_range_deg_s": 500}
    )
    both = configuration_of(unit, Configuration(firmware="2.1", rate_range_deg_s=500.0))
    assert (both.rate_range_deg_s, both.firmware) == (500.0, "2.1")
    with pytest.raises(Unusable, match=r"order says configuration.rate_range_deg_s = 300.*500"):
        configuration_of(unit, Configuration(rate_range_deg_s=300.0))
    bad = unit.model_copy(update={"rate_range_deg_s": "fast"})
    with pytest.raises(Unusable, match=r"rate_range_deg_s.*correct it there"):
        configuration_of(bad, None)


# Small probabilities to their last digits, and the standard uncertainty of a k that is not 2.

TWELVE_SIGMA = 1.7764821120776789e-33  # ½·erfc(12/√2)


def test_a_risk_of_twelve_sigma_has_its_digits():
    assert 0.5 * math.erfc(12.0 / math.sqrt(2.0)) == pytest.approx(TWELVE_SIGMA, rel=1e-9, abs=0.0)
    above, below = (12.0, math.inf), (-math.inf, -12.0)
    for limits in (above, below, (12.0, 40.0), (-40.0, -12.0)):
        conforms = probability_of_conformity(0.0, 1.0, limits)
        assert conforms == pytest.approx(TWELVE_SIGMA, rel=1e-6, abs=0.0)
    for limits in ((-math.inf, 12.0), (-12.0, math.inf)):
        outside = probability_of_nonconformity(0.0, 1.0, limits)
        assert outside == pytest.approx(TWELVE_SIGMA, rel=1e-6, abs=0.0)


def test_the_risk_of_a_value_counts_with_u_and_not_with_half_of_the_expanded_one():
    uncertain = item({"x": 0.04}, k=4.0).model_copy(update={"U": {"x": 0.04}, "u": {"x": 0.01}})
    made = decide(calibration({"gyro_bias": uncertain}), tolerance(bias_limit())).limits[0]
    one_sigma = 0.5 * math.erfc(1.0 / math.sqrt(2.0))
    assert 1.0 - made.probability_of_conformity == pytest.approx(one_sigma, rel=1e-6)
