"""What the certificate says, before it is laid out."""

from dataclasses import asdict
from typing import Any, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from schemas.calibration import (
    Calibration,
    Distribution,
    EnvironmentSeen,
    Information,
    Item,
    Method,
)
from schemas.certificate import State
from schemas.laboratory import EquipmentLimit, LimitName, ResultAxes
from schemas.tolerance import Limit, Quantity, Tolerance, Verdict
from tasks.calibrate.calibrate import calibrate, evaluation_for
from tasks.calibrate.information.entry import WITHOUT_EARTH, separated
from tasks.certificate.budgets import budgets
from tasks.certificate.equipment import axes_of_results, flatness, limits_of, settings, whose_limits
from tasks.certificate.fields import literal, slug
from tasks.certificate.results import Group, contained, information_rows
from tasks.conformity import decide
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.joint import JOINT
from tasks.specifications.register import SPECIFICATIONS
from tasks.words import known, say
from tests.tasks.certificate.sample_certificate import (
    AXES,
    calibration,
    certificate,
    content,
    item,
    items,
    manifest,
    printed,
    tolerance,
)


def group(result: Calibration, title: str) -> Group:
    made = content(certificate(result))
    return next(g for section in made.sections for g in section.groups if g.title[1] == title)


def texts(answer: Any) -> list[str]:
    if isinstance(answer, dict):
        return [text for value in answer.values() for text in texts(value)]
    if isinstance(answer, list | tuple):
        return [text for value in answer for text in texts(value)]
    return [answer] if isinstance(answer, str) else []


KIND = Item.model_fields["uncertainty_kind"].annotation


@pytest.mark.parametrize(
    ("keys", "text"),
    [
        (set(get_args(State)) - {"issued"}, "certificate-watermark"),
        (get_args(Method), "certificate-method"),
        (get_args(Method), "certificate-followed"),
        (get_args(Method), "certificate-basis"),
        (get_args(Verdict), "conformity-verdict"),
        (get_args(Verdict), "certificate-scope"),
        (get_args(Quantity), "conformity-quantity"),
        (get_args(KIND), "certificate-kind"),
        (get_args(KIND), "certificate-u-contains"),
        (get_args(KIND), "certificate-u-in-short"),
        (get_args(Distribution), "certificate-distribution"),
        (get_args(Tolerance.model_fields["rule"].annotation), "certificate-rule"),
    ],
)
def test_everything_that_can_be_said_has_its_words(keys, text):
    assert all(known(f"{text}.{slug(key)}") for key in keys)


def test_results_stand_in_the_order_of_appendix_b():
    titles = [section.title[0] for section in content(certificate()).sections]
    assert titles == [
        "标度因数", "零偏", "陀螺交叉耦合系数", "加速度计交叉耦合系数",
        "陀螺加速度敏感系数 (g)", "加速度计角速度灵敏系数 (p)",
    ]  # fmt: skip


def test_all_six_gyro_cross_couplings_have_their_names_of_appendix_b():
    rows = group(calibration(), "Gyro cross coupling coefficient").rows
    assert [(row.name[0], row.letter + row.sub) for row in rows] == [
        ("X 轴对 Y 轴交叉耦合系数", "Kgyx"),
        ("X 轴对 Z 轴交叉耦合系数", "Kgzx"),
        ("Y 轴对 X 轴交叉耦合系数", "Kgxy"),
        ("Y 轴对 Z 轴交叉耦合系数", "Kgzy"),
        ("Z 轴对 X 轴交叉耦合系数", "Kgxz"),
        ("Z 轴对 Y 轴交叉耦合系数", "Kgyz"),
    ]


def test_values_and_uncertainties_share_their_last_place():
    row = group(calibration(), "Gyro bias").rows[1]
    assert (row.value, row.U, row.limits) == ("−0.03194", "0.00035", ("±0.05",))


def test_small_coefficients_and_their_limits_share_one_power_of_ten():
    given = items()
    p = given["accel_rate_sensitivity"]
    given["accel_rate_sensitivity"] = p.model_copy(
        update={"value": dict.fromkeys(p.value, 1e-05), "U": dict.fromkeys(p.U, 1.3e-07)}
    )
    result = calibration(items=given)
    limit = Limit(item="accel_rate_sensitivity", unit="m", magnitude=5e-5)
    made = content(certificate(result, decide(result, tolerance(limits=(limit,)))))
    rate = made.sections[5].groups[0]
    assert rate.exponent == -3
    assert (rate.rows[0].value, rate.rows[0].U) == ("0.01000", "0.00013")
    assert rate.rows[0].limits == ("(a) ±0.05",)


def test_g_sensitivity_gives_both_values_and_says_which_one_is_limited():
    g = group(calibration(), "Gyro g-sensitivity")
    assert (g.rows[0].value, g.rows[0].second, g.rows[0].limits) == (
        "0.00951", "0.00683", ("(b) ±0.01",)
    )  # fmt: skip
    assert g.sentences[-1] == (
        "允许限适用于：扣除地球自转后的值。",
        "The limits are applied to: the value with Earth's rotation removed.",
    )
    assert g.matrices[0].cells[1] == ("0.00118", "0.00742", "−0.00305")


def test_a_second_value_with_an_uncertainty_of_its_own_prints_it():
    made = items()["gyro_g_sensitivity"]
    own = {element: 1.5 * U for element, U in made.U.items() if U is not None}
    apart = made.model_copy(update={"U_without_earth_rotation": own})
    title = "Gyro g-sensitivity"
    plain = group(calibration(), title)
    shown = group(calibration(items={**items(), "gyro_g_sensitivity": apart}), title)
    assert (plain.U_apart, shown.U_apart) == (False, True)
    assert all(row.U_second != row.U for row in shown.rows)


def test_rate_sensitivity_gives_both_signs_and_a_zero_diagonal():
    p = group(calibration(), "Accelerometer rate sensitivity")
    assert (p.unit, p.exponent, p.rows[1].value, p.rows[1].second) == (
        "m", -3, "19.9400", "−19.9400"
    )  # fmt: skip
    assert p.matrices[0].cells[0] == ("0", "−0.0231", "19.9400")
    assert any("m/s² per (rad/s)²" in en for _, en in p.sentences)


def test_a_null_element_says_why_in_both_languages():
    given = items()
    given["gyro_bias"] = item("deg/s", "7.2.2", AXES, [0.01, None, 0.02], 1e-4)
    result = calibration(
        items=given, unavailable={"gyro_bias": "gyro y is null"},
        unavailable_zh={"gyro_bias": "Y 轴陀螺无数据"},
    )  # fmt: skip
    bias = group(result, "Gyro bias")
    (mark,) = bias.rows[1].marks
    assert (bias.rows[1].value, bias.rows[1].U) == (None, None)
    assert (mark.verdict, mark.chance) == ("inconclusive", None)
    assert bias.sentences == (("未得：Y 轴陀螺无数据。", "Not determined: gyro y is null."),)


def test_an_item_that_was_not_estimated_keeps_its_place_and_its_reason():
    given = items()
    del given["gyro_g_sensitivity"], given["accel_rate_sensitivity"]
    result = calibration(items=given, unavailable={"gyro_g_sensitivity": "no positions"})
    made = content(certificate(result, decide(result, None)))
    g, p = made.sections[4].groups[0], made.sections[5].groups[0]
    assert [row.value for row in g.rows] == [None] * 9
    assert g.matrices == ()
    assert ("未得：no positions。", "Not determined: no positions.") in g.sentences
    assert p.sentences[-1] == (
        "未得：本次校准未包含此项。",
        "Not determined: this item is not part of this calibration.",
    )


def test_an_item_of_no_specification_is_printed_too():
    result = calibration(items=items() | {"lever_arm": item("m", "", ["x"], [0.0123], 1e-4)})
    other = content(certificate(result)).sections[-1]
    assert other.title == ("其他结果", "Other results")
    assert other.groups[0].rows[0].value == "0.01230"


def test_readings_are_numbered_once_with_the_items_that_rest_on_them():
    made = content(certificate())
    shorts = [reading.short for reading in made.readings]
    assert shorts == [f"R{n}" for n in range(1, 10)]
    about = {reading.short: reading.items for reading in made.readings}
    assert about["R3"] == ("陀螺零偏、陀螺加速度敏感系数", "Gyro bias, Gyro g-sensitivity")
    assert about["R5"][1] == "Gyro g-sensitivity"


@pytest.mark.parametrize("state", ["draft", "checked"])
def test_what_is_not_issued_has_a_watermark_and_no_date_of_issue(state):
    made = content(certificate(state=state))
    assert made.watermark is not None
    assert made.signatures[-1].date == ("尚未签发", "not yet issued")
    assert content(certificate()).watermark is None


def test_nothing_is_left_blank_when_nothing_is_given():
    result = calibration(items={}, environment=EnvironmentSeen(), remarks=(), settings={})
    bare = certificate(
        result, decide(result, None), laboratory=None, order=None, state="draft",
        manifest=manifest(manufacturer="", model=" \t", serial="\x07"),
    )  # fmt: skip
    made = content(bare)
    for fields in (made.front, made.conformity, made.trace):
        assert all(text.strip() for field in fields for text in (*field.label, *field.value))
    answer = asdict(made)
    for part in ("laboratory", "laboratory_address", "signatures", "standards"):
        assert all(text.strip() for text in texts(answer[part]))
        assert "未提供" in texts(answer[part])
    unit = {field.label[1]: field.value for field in made.front}
    assert unit["Serial number"] == unit["Model"] == ("未提供", "not given")
    assert made.environment[0].measured == ("未提供", "not given")


def test_jjf_1536_has_its_own_items_and_conditions():
    offset = item("deg/s", "JJF 1536-2015, 7.2", AXES, [0.001, -0.002, 0.0005], 1e-5)
    result = calibration(method="jjf1536", items={"ahrs_zero_offset": offset})
    made = content(certificate(result, decide(result, None)))
    assert [section.title[0] for section in made.sections] == ["标度因数", "零偏", "失准角"]
    assert made.sections[1].groups[0].rows[0].name == (
        "航向角零偏", "Zero offset of the heading angle"
    )  # fmt: skip
    assert made.environment[0].required == "(20 ± 3) °C"
    assert made.statement[0][1].endswith("; clauses 7.2.")


@given(st.text(max_size=60))
def test_literal_keeps_every_printable_character(text):
    kept = literal(text)
    assert all(c.isprintable() for c in kept)
    assert [c for c in kept if c != " "] == [c for c in text if c.isprintable() and c != " "]


def test_settings_are_called_by_their_names_in_every_language_and_have_units():
    made = certificate(
        calibration(
            settings={
                "gravity_m_s2": 9.8015,
                "latitude_deg": None,
                "uncertainty": "GUM",
                "limits": "JJF 2003-2022, Table 1",
                "limit of position": "2.4e-05 (certificate 2026-123)",
                "effective bits": "12 (the example's)",
            }
        )
    )
    (answer,) = [each.value for each in content(made).trace if each.label[1] == "Settings"]
    assert answer == (
        "所用重力加速度：9.8015 m/s²；所用纬度：未提供；不确定度：GUM 法，A 类与 B 类合成；"
        "校准装置的极限：JJF 2003—2022，表 1；"
        "实验室给出的极限，角位置定位精度：4.95″（certificate 2026-123）；"
        "有效位数：12（取规范示例值）",
        "gravity used: 9.8015 m/s²; latitude used: not given; uncertainty: GUM, type A and B "
        "combined; limits of the equipment: JJF 2003-2022, Table 1; laboratory limit, "
        "angular positioning: 4.95″ (certificate 2026-123); "
        "effective bits: 12 (as in the specification's example)",
    )


# What the certificate prints beside the results, and what it says the clause's value contains.


def noise(**changes: Any) -> Information:
    given: dict[str, Any] = {
        "title": "Angle random walk of the gyros",
        "title_zh": "陀螺角度随机游走系数",
        "unit": "deg/sqrt(h)",
        "value": {"x": 0.08433, "y": None, "z": 0.0841},
        "u": {"x": 0.00067, "y": None, "z": 0.0006},
        "U": {"x": 0.00134, "y": None, "z": 0.0012},
        "en": "From 18 rests. y: the noise is masked by the output's resolution.",
        "zh": "由 18 段静止数据求得。y：输出分辨力掩盖了噪声。",
    }
    return Information(**(given | changes))


def test_numbers_are_rounded_to_the_place_of_u_and_u_upward():
    (row,) = printed(information_rows(calibration(information={"walk": noise()})))
    x, y, z = row.lines[0]
    assert (x.element, x.value, x.U) == ("x", "0.0843", "0.0014")
    assert (y.value, y.U) == (None, None)
    assert (z.value, z.U) == ("0.0841", "0.0012")
    assert row.unit == "°/√h"


def test_a_value_without_u_has_three_digits_and_no_more():
    shown = noise(value={"x": 582.0471}, u={"x": 205.8}, U={"x": None})
    (row,) = printed(information_rows(calibration(information={"s": shown})))
    ((x, _, _),) = row.lines
    assert (x.value, x.U, row.exponent) == ("582", None, 0)


def test_elements_of_a_matrix_stand_where_a_matrix_has_them():
    value = {"xy": 1.0, "yx": 2.0}
    shown = noise(value=value, u=None, U=None)
    (row,) = printed(information_rows(calibration(information={"p": shown})))
    names = [[cell and cell.element for cell in line] for line in row.lines]
    assert names == [[None, "xy", None], ["yx", None, None]]


def test_the_item_says_what_the_clause_contains_and_how_many_times_u():
    made = calibration()
    made = calibration(information=separated(made.items["gyro_g_sensitivity"], None))
    ((zh, en),) = printed(contained(made, "gyro_g_sensitivity", SPECIFICATIONS[made.method]))
    assert en.startswith("The value by eq. (7) includes Earth's rotation:")
    assert "0.0027 (°/s)/g, 11 times U" in en
    assert "即 U 的 11 倍" in zh


def test_a_value_of_the_joint_method_is_not_said_to_follow_an_equation():
    made = calibration()
    made = calibration(
        information=separated(made.items["gyro_g_sensitivity"], None), method="joint"
    )
    ((zh, en),) = printed(contained(made, "gyro_g_sensitivity", SPECIFICATIONS[made.method]))
    assert en.startswith("The value includes Earth's rotation:")
    assert zh.startswith("上述值含地球自转：")


def test_a_difference_within_u_is_not_mentioned_at_the_item():
    made = calibration()
    item = made.items["gyro_g_sensitivity"]
    close = {e: v - 0.5 * item.U[e] for e, v in item.value.items()}
    shown = separated(made.items["gyro_g_sensitivity"], None)[WITHOUT_EARTH].model_copy(
        update={"value": close}
    )
    assert (
        contained(
            calibration(information={WITHOUT_EARTH: shown}),
            "gyro_g_sensitivity",
            SPECIFICATIONS["jjf2003"],
        )
        == ()
    )


def test_information_never_enters_the_decision():
    far = noise(value={"x": 1e9, "y": 1e9, "z": 1e9}, about="gyro_bias")
    bare, shown = certificate(), certificate(calibration(information={"walk": far}))
    assert content(shown).verdict == content(bare).verdict
    assert content(shown).reasons == content(bare).reasons


# Whose limits stand in the budgets, and what stands in none.

OWN = EquipmentLimit(half_width=2e-6, distribution="normal", source="CNAS 2026-117")


@pytest.fixture(scope="module")
def made(ideal_run):
    """A result for each set of limits of a laboratory's own."""

    def build(about: ResultAxes | None = None, **own: EquipmentLimit):
        recording = ideal_run(noise=1e-4)
        evaluation = evaluation_for(recording, own=own, axes=about)
        return calibrate(JJF2003, recording, run="r", code_version="v", evaluation=evaluation)

    return build


def test_recommended_and_assumed_limits_are_said_to_be_such(made):
    ((zh, en),) = printed(whose_limits(made()))
    assert "limits recommended by JJF 2003-2022, Table 1, JJF 2003-2022, 6.2, which this" in en
    assert "local gravity assumed known to ±0.0005 m/s²" in en
    assert "latitude assumed known to ±0.05°" in en
    assert "JJF 2003—2022，表 1" in zh
    assert "纬度假定已知至 ±0.05°" in zh


def test_which_axes_the_results_are_about_is_always_stated(made):
    """It agrees with what is stated of the flatness: that is in no budget of the fixture's axes."""
    zh, en = printed(axes_of_results(made()))
    ((flat_zh, flat_en),) = printed(tuple(flatness(made(), JJF2003)))
    assert "hold for the axes of the fixture" in en
    assert "以夹具的轴线为准" in zh
    assert "0.02 mm" in flat_en
    assert "41″" in flat_zh
    mounted = made(mounting=OWN)
    zh, en = printed(axes_of_results(mounted))
    assert not list(flatness(mounted, JJF2003))
    assert "axes of the unit's mounting plane" in en
    assert "安装基面的轴线为准" in zh
    ordered = made("mounting plane")
    _, en = printed(axes_of_results(ordered))
    ((_, flat_en),) = printed(tuple(flatness(ordered, JJF2003)))
    assert "ordered for the axes of the unit's mounting plane" in en
    assert "0.02 mm" in flat_en
    names = [say(each.name, "en") for each in settings(ordered)]
    assert "axes of the results" in names


def test_a_limit_of_the_laboratory_is_not_called_recommended_or_assumed(made):
    result = made(rate=OWN, gravity=OWN)
    ((_, en),) = printed(whose_limits(result))
    own, others = en.split("limits recommended")
    assert "stated by the laboratory: table rate over whole turns, local gravity" in own
    assert "table rate over whole turns" not in others
    assert "local gravity assumed" not in others
    found = printed(budgets(result))
    assert found is not None
    rows = {row.symbol: row for row in found.limits}
    assert rows["ε1"].source == ("CNAS 2026-117",) * 2
    assert (rows["ε1"].half_width, rows["ε1"].distribution[1]) == ("U = 2×10⁻⁶", "normal")
    assert rows["α1"].half_width == "±10″"
    assert rows["α4"].source == ("JJF 2003—2022，6.2", "JJF 2003-2022, 6.2")


def test_table_1_is_no_setting_where_every_limit_is_the_laboratorys_own(made):
    def printed_settings(**own: EquipmentLimit) -> str:
        return " ".join(say(each.value, "en") for each in settings(made(**own)))

    assert "Table 1" in printed_settings(rate=OWN)
    own = printed_settings(**dict.fromkeys(get_args(LimitName), OWN))
    assert "Table 1" not in own
    assert own.count("CNAS 2026-117") == len(get_args(LimitName))


def test_the_joint_method_has_the_assumed_latitude_among_its_limits(ideal_run):
    result = calibrate(JOINT, ideal_run(noise=1e-4), run="r", code_version="v")
    rows = {row.symbol: row for row in printed(budgets(result)).limits}
    assert rows["φ"].source[1] == "assumed: latitude stated to 0.1°"
    assert rows["φ"].half_width == "±0.05°"
    ((_, en),) = printed(whose_limits(result))
    assert en.count("latitude assumed") == 1


def test_a_budget_line_carries_the_half_width_and_the_source_of_its_limit(made):
    limits = {line.symbol: line for line in limits_of(made())}
    assert limits["g"].half_width == 5e-4
    assert limits["g"].u == pytest.approx(5e-4 / 3**0.5)
    assert limits["α4"].source == "JJF 2003-2022, 6.2"
