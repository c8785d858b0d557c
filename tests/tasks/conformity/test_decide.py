"""The verdict: what passes, what fails, what nobody can say."""

import math
import re
from datetime import date
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sample_results import BIAS, bias_limit, calibration, item, tolerance, with_uncertainty

from schemas.base import Unusable
from schemas.decision import Decision
from schemas.equipment import MeasurementStandard
from schemas.text import Remark, Statement
from schemas.tolerance import Limit
from tasks.conformity import decide, expired
from tasks.conformity.limits import accepted_edges, accepted_text
from tasks.conformity.reasons import conditional
from tasks.words import say, statement


def verdict_of(value: dict[str, float | None], **limit: Any) -> str:
    return decide(calibration({"gyro_bias": item(value)}), tolerance(bias_limit(**limit))).verdict


def test_inside_every_limit_passes_without_reasons() -> None:
    decision = decide(calibration({"gyro_bias": item(BIAS)}), tolerance(bias_limit()))
    assert decision.verdict == "pass"
    assert [made.verdict for made in decision.limits] == ["pass"] * 3
    assert (decision.reasons, decision.document) == ((), "Q/1")
    assert decision.rule == "simple_acceptance"


def test_one_element_outside_fails_and_is_named_in_both_languages() -> None:
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


def test_a_value_on_its_limit_is_accepted() -> None:
    assert verdict_of({"x": 0.05, "y": -0.05, "z": 0.0}) == "pass"


def test_a_magnitude_limits_both_signs() -> None:
    magnitude = {"lower": None, "upper": None, "magnitude": 0.05}
    assert verdict_of(BIAS, **magnitude) == "pass"
    assert verdict_of(BIAS | {"x": -0.06}, **magnitude) == "fail"
    assert verdict_of(BIAS | {"x": 0.06}, **magnitude) == "fail"


def test_an_upper_limit_alone_leaves_the_bottom_open() -> None:
    assert verdict_of({"x": -9.0, "y": 0.0, "z": 0.0}, lower=None) == "pass"
    assert verdict_of({"x": 0.06, "y": 0.0, "z": 0.0}, lower=None) == "fail"


def test_a_lower_limit_alone_leaves_the_top_open() -> None:
    assert verdict_of({"x": 9.0, "y": 0.0, "z": 0.0}, upper=None) == "pass"


@pytest.mark.parametrize("missing", [None, math.nan, math.inf])
def test_a_missing_or_non_finite_element_is_inconclusive(missing: float | None) -> None:
    broken = item(BIAS).model_copy(update={"value": BIAS | {"z": missing}})
    decision = decide(calibration({}).model_copy(update={"items": {"gyro_bias": broken}}),
                      tolerance(bias_limit()))  # fmt: skip
    assert decision.verdict == "inconclusive"
    assert decision.limits[2].value is None
    assert decision.reasons == ("Gyro bias (z) not determined: no cause stated",)


def test_an_element_left_out_of_the_result_is_inconclusive() -> None:
    assert verdict_of({"x": 0.01, "y": 0.01}) == "inconclusive"


def test_a_value_without_uncertainty_is_inconclusive() -> None:
    bare = item(BIAS).model_copy(update={"U": BIAS | {"x": None}})
    assert decide(calibration({"gyro_bias": bare}), tolerance(bias_limit())).verdict == (
        "inconclusive"
    )


def test_an_unavailable_item_is_inconclusive_with_its_reason() -> None:
    result = calibration(
        {}, {"gyro_bias": "only 5 of 12 positions"}, unavailable_zh={"gyro_bias": "仅有5个位置"}
    )
    decision = decide(result, tolerance(bias_limit()))
    assert decision.verdict == "inconclusive"
    assert [made.element for made in decision.limits] == ["x", "y", "z"]
    assert decision.reasons == ("Gyro bias (x, y, z) not determined: only 5 of 12 positions",)
    assert decision.reasons_zh == ("陀螺零偏（x, y, z）未得：仅有5个位置",)


def test_an_item_called_unavailable_does_not_pass_on_the_numbers_it_has() -> None:
    result = calibration({"gyro_bias": item(BIAS)}, {"gyro_bias": "table fault"})
    assert decide(result, tolerance(bias_limit())).verdict == "inconclusive"


def test_a_foreign_unavailable_item_is_inconclusive_too() -> None:
    result = calibration({"gyro_bias": item(BIAS)}, {"odd": "not seen"})
    limits = tolerance(bias_limit(), Limit(item="odd", unit="1", upper=1.0))
    assert decide(result, limits).verdict == "inconclusive"


def test_a_failure_outweighs_what_is_missing() -> None:
    assert verdict_of({"x": 1.0, "y": None, "z": 0.0}) == "fail"


def test_only_listed_elements_are_limited() -> None:
    assert verdict_of({"x": 0.01, "y": None, "z": 9.0}, elements=("x",)) == "pass"


def test_a_remark_that_blocks_a_pass_makes_it_inconclusive() -> None:
    warm = Remark(code="temperature", en="It was 31 °C.", zh="温度为31 °C。", blocks_pass=True)
    result = calibration({"gyro_bias": item(BIAS)}, remarks=(warm,))
    decision = decide(result, tolerance(bias_limit()))
    assert decision.verdict == "inconclusive"
    assert (decision.reasons, decision.reasons_zh) == (("It was 31 °C.",), ("温度为31 °C。",))


def test_no_tolerance_is_inconclusive() -> None:
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
def test_a_limit_that_does_not_fit_the_result_is_refused(limit: Limit, names: str) -> None:
    with pytest.raises(Unusable, match=names):
        decide(calibration({"gyro_bias": item(BIAS)}), tolerance(limit))


def g_sensitivity(**limit: Any) -> Decision:
    g = {a + b: 0.012 for a in "xyz" for b in "xyz"}
    earth = {element: value - 0.003 for element, value in g.items()}
    result = item(g, unit="(deg/s)/g", value_without_earth_rotation=earth)
    limited = Limit(item="gyro_g_sensitivity", unit="(deg/s)/g", magnitude=0.01, **limit)
    return decide(calibration({"gyro_g_sensitivity": result}), tolerance(limited))


def test_a_g_sensitivity_limit_says_which_quantity_it_applies_to() -> None:
    assert g_sensitivity().verdict == "fail"
    corrected = g_sensitivity(applied_to="value_without_earth_rotation")
    assert corrected.verdict == "pass"
    assert corrected.limits[0].applied_to == "value_without_earth_rotation"
    assert corrected.limits[0].value == pytest.approx(0.009)


def test_a_quantity_that_could_not_be_computed_is_inconclusive() -> None:
    result = item({a + b: 0.001 for a in "xyz" for b in "xyz"}, unit="(deg/s)/g")
    limit = Limit(item="gyro_g_sensitivity", unit="(deg/s)/g", magnitude=0.01,
                  applied_to="value_without_earth_rotation")  # fmt: skip
    decision = decide(calibration({"gyro_g_sensitivity": result}), tolerance(limit))
    assert decision.verdict == "inconclusive"


@pytest.mark.parametrize("value", [0.01, -0.06])
def test_an_uncertainty_wider_than_half_the_limits_decides_nothing(value: float) -> None:
    decision = with_uncertainty(value, 0.051)
    assert decision.verdict == "inconclusive"
    assert {made.verdict for made in decision.limits} == {"inconclusive"}
    assert "U = 0.051 °/s, larger than half the interval ±0.05 °/s" in decision.reasons[0]
    assert "U = 0.051 °/s，大于允许区间 ±0.05 °/s 的一半" in decision.reasons_zh[0]


def test_an_uncertainty_of_half_the_limits_still_decides() -> None:
    assert with_uncertainty(0.01, 0.05).verdict == "pass"


def test_a_value_wholly_outside_fails_however_uncertain_it_is() -> None:
    assert with_uncertainty(0.2, 0.051).verdict == "fail"


def test_a_one_sided_limit_has_no_interval_to_compare_with() -> None:
    assert with_uncertainty(0.01, 5.0, lower=None, U_max=6.0).verdict == "pass"


def test_a_one_sided_limit_without_a_bound_on_u_asks_for_one() -> None:
    decision = with_uncertainty(0.01, 5.0, lower=None)
    assert decision.verdict == "inconclusive"
    assert {made.verdict for made in decision.limits} == {"inconclusive"}
    assert "is 50.6 %, and U is not limited: specify U_max" in decision.reasons[0]
    assert "合格概率为 50.6 %" in decision.reasons_zh[0]
    assert with_uncertainty(0.01, 0.02, lower=None).verdict == "pass"


def test_a_pass_outside_the_limits_is_conditional() -> None:
    decision = with_uncertainty(
        0.0625, 0.0125, lower=None, rule="guard_band", guard_band_factor=-1.0, U_max=1.0
    )
    assert (decision.verdict, decision.marginal) == ("pass", True)
    assert "accepted but lies outside its limit" in say(conditional(decision)[0], "en")


@pytest.mark.parametrize("U", [None, 0.0])
@pytest.mark.parametrize("value", [0.01, 9.0])
def test_no_uncertainty_or_one_of_zero_is_inconclusive(value: float, U: float | None) -> None:
    decision = with_uncertainty(value, U)
    assert decision.verdict == "inconclusive"
    assert decision.reasons == (
        "Gyro bias (x, y, z): no uncertainty above zero was obtained, so no decision is possible",
    )


def test_a_failure_that_rounding_would_hide_has_as_many_digits_as_show_it() -> None:
    (x, *_) = with_uncertainty(0.0500004123456789, 0.001).reasons
    assert x == (
        "Gyro bias B_gx: 0.0500004 °/s, U = 0.0010 °/s (k = 2), is outside ±0.05 °/s "
        "(conditional fail, false rejection 50.0 %)"
    )


def test_a_failure_says_which_of_two_values_was_decided_on() -> None:
    reasons = g_sensitivity().reasons
    assert reasons[5] == (
        "Gyro g-sensitivity g_yz, the value by the clause: 0.0120 (°/s)/g, "
        "U = 0.0010 (°/s)/g (k = 2), is outside ±0.01 (°/s)/g "
        "(false rejection < 0.1 %)"
    )


def test_a_failing_ratio_has_no_unit() -> None:
    scale = item({"x": 1.02, "y": 1.0, "z": 1.0}, unit="1")
    limit = Limit(item="gyro_scale_factor", unit="1", lower=0.99, upper=1.01)
    decision = decide(calibration({"gyro_scale_factor": scale}), tolerance(limit))
    assert decision.reasons == (
        "Gyro scale factor K_gxx: 1.0200, U = 0.0010 (k = 2), is outside 0.99 … 1.01 "
        "(false rejection < 0.1 %)",
    )


def test_further_doubts_prevent_a_pass_and_stand_among_the_reasons() -> None:
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


def test_a_standard_that_ran_out_before_the_day_is_a_reason() -> None:
    last = date(2026, 11, 20)
    assert expired([standard(last), standard(None)], last) == ()
    (reason,) = expired([standard(last)], date(2026, 11, 21))
    assert statement(reason).pair == (
        "Table (T-1): its certificate was valid until 2026-11-20, before 2026-11-21",
        "转台（T-1）：其证书有效期至 2026-11-20，早于 2026-11-21",
    )


def test_a_second_value_missing_off_the_diagonal_leaves_the_diagonal_decided() -> None:
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
def test_a_pass_needs_every_element_inside_and_nothing_against_it(
    value: dict[str, float | None], blocked: bool
) -> None:
    remarks = (Remark(code="c", en="e", zh="z", blocks_pass=blocked),)
    result = calibration({"gyro_bias": item(value)}, remarks=remarks)
    passed = decide(result, tolerance(bias_limit())).verdict == "pass"
    inside = [v is not None and abs(v) <= 0.05 for v in map(value.get, "xyz")]
    assert passed == (all(inside) and not blocked)


def test_where_u_is_larger_than_the_guard_bands_allow_there_is_no_acceptance_interval() -> None:
    decided = with_uncertainty(0.0, 0.056, rule="guard_band").limits[0]
    assert decided.verdict == "inconclusive"
    assert (decided.accept_lower, decided.accept_upper) == (None, None)
    assert accepted_text(decided) == "–"
    assert accepted_edges(decided) is None
    exact_fit = with_uncertainty(0.0, 0.05, rule="guard_band").limits[0]
    assert (exact_fit.accept_lower, exact_fit.accept_upper) == (0.0, 0.0)


@pytest.mark.parametrize("upper", [1.3338541310494842, 1.3338541310494846])
def test_no_reason_prints_the_binary_digits_of_a_limit_or_of_a_value_near_it(upper: float) -> None:
    decision = with_uncertainty(1.3338541310494844, 2.0, lower=0.0, upper=upper)
    assert decision.verdict == "inconclusive"
    digits = re.findall(r"\d+\.\d+", " ".join((*decision.reasons, *decision.reasons_zh)))
    assert digits
    assert max(map(len, digits)) <= len("1.33385413")
