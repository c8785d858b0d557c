"""How the certificate tells limits, rules, risks and conditional verdicts."""

import io
import re
from typing import Any

import pypdf
import pytest
from sample_certificate import AXES, calibration, certificate, content, item, items, tolerance

from schemas.certificate import Certificate
from schemas.tolerance import Limit, ProductionPrior, Tolerance
from tasks.certificate.content import Content
from tasks.certificate.pdf import render
from tasks.conformity import decide
from tasks.conformity.limits import probability_text

BIAS = {"item": "gyro_bias", "unit": "deg/s"}


def made(values: list[float], limits: Tolerance, **changes: Any) -> Certificate:
    """A certificate on gyro biases with u = 0.000171 °/s, U = 0.000342 °/s."""
    bias = item("deg/s", "7.2.2", AXES, values, 1.71e-4)
    result = calibration(items=items() | {"gyro_bias": bias}, **changes)
    return certificate(result, decide(result, limits))


def limited(*limits: Limit, **file: Any) -> Tolerance:
    return tolerance(limits=limits, **file)


def fields(text: Content) -> dict[str, tuple[str, str]]:
    return {field.label[1]: field.value for field in text.conformity}


def test_a_conditional_pass_is_marked_where_it_stands_and_on_the_cover() -> None:
    text = content(made([0.0499, 0.01, 0.02], tolerance()))
    assert text.verdict_text == ("有条件合格", "conditional pass")
    assert text.scope is not None
    assert text.scope[1].endswith("; in 1 item a value lies within U of a limit")
    x, y, _ = text.sections[1].groups[0].rows
    assert (x.marks[0].words[1], x.marks[0].chance) == ("conditional pass", "72.1 %")
    assert (y.marks[0].words[1], y.marks[0].chance) == ("pass", "> 99.9 %")
    assert text.reasons[0][1] == (
        "Gyro bias B_gx: 0.04990 °/s, U = 0.00035 °/s (k = 2), is accepted but lies within U of "
        "its limit, ±0.05 °/s (conditional pass, false acceptance 27.9 %)"
    )
    assert "ILAC-G8:09/2019" in fields(text)["Marks"][1]


def test_the_largest_risks_are_told_with_whose_they_are() -> None:
    zh, en = fields(content(made([0.0499, 0.0501, 0.02], tolerance())))["Risk of a wrong decision"]
    assert "false acceptance of a pass, 1 − P_c, the largest 27.9 % (B_gx)" in en
    assert "false rejection of a fail, P_c, the largest 27.9 % (B_gy)" in en
    assert "错误接受概率 1 − P_c，最大者 27.9 %" in zh


def test_a_guard_band_prints_its_rule_its_width_and_its_acceptance_limits() -> None:
    limits = limited(Limit(**BIAS, magnitude=0.05), rule="guard_band", guard_band_factor=0.83)
    text = content(made([0.01, 0.01, 0.02], limits))
    assert text.sections[1].groups[0].rows[0].limits == (
        "±0.05",
        ("接受限 ±0.04972", "AL ±0.04972"),
    )
    rule = fields(text)["Decision rule"][1]
    assert "guard band (JCGM 106, 8.3)" in rule
    assert "w = 0.83 U" in rule
    assert "C_m = T/(2 U) ≥ 1" in rule
    assert rule.endswith("; U has k = 2")


def test_several_rules_are_told_one_by_one_with_their_items() -> None:
    text = fields(
        content(
            made(
                [0.01, 0.01, 0.02],
                limited(
                    Limit(**BIAS, upper=0.05, rule="shared_risk", U_max=0.001),
                    Limit(item="accel_bias", unit="m/s2", magnitude=0.03),
                    Limit(item="gyro_scale_factor", unit="1", lower=0.9, upper=1.1),
                ),
            )
        )
    )
    assert text["Decision rule 1"][1].startswith("Gyro bias: shared risk")
    assert "Gyro bias decided on only if U ≤ 0.001 °/s" in text["Decision rule 1"][1]
    assert text["Decision rule 2"][1].startswith("Accelerometer bias, Gyro scale factor: simple")


def test_relative_limits_are_told_both_ways() -> None:
    limit = Limit(item="gyro_scale_factor", unit="1", relative=True, nominal=1.0, magnitude=0.003)
    group = content(made([0.01, 0.01, 0.02], limited(limit))).sections[0].groups[0]
    assert group.rows[0].limits == ("0.997 … 1.003",)
    assert ("相对允许限：±0.3 % × 1。", "Relative limits: ±0.3 % × 1.") in group.sentences


def test_a_prior_gives_the_risks_over_the_production() -> None:
    limits = limited(Limit(**BIAS, magnitude=0.05, prior=ProductionPrior(mean=0.045, sd=0.01)))
    text = fields(content(made([0.01, 0.01, 0.02], limits)))
    found = re.fullmatch(
        r"Gyro bias: consumer's (\d\.\d) %, producer's (\d\.\d) % \(JCGM 106, 9\.5\)",
        text["Risks over the production"][1],
    )
    assert found
    assert all(0.1 <= float(each) <= 1.0 for each in found.groups())


@pytest.mark.parametrize(
    ("probability", "text"),
    [(0.0, "< 0.1 %"), (0.0009, "< 0.1 %"), (0.0012, "0.1 %"), (0.1587, "15.9 %"),
     (0.998, "99.8 %"), (0.99999, "> 99.9 %"), (1.0, "> 99.9 %")],
)  # fmt: skip
def test_a_probability_is_never_printed_as_certainty(probability: float, text: str) -> None:
    assert probability_text(probability) == text


@pytest.mark.rehearsal
def test_rule_width_and_risk_are_on_the_paper() -> None:
    limits = limited(Limit(**BIAS, magnitude=0.05), rule="guard_band")
    reader = pypdf.PdfReader(io.BytesIO(render(made([0.0499, 0.01, 0.02], limits))))
    paper = re.sub(r"\s+", "", "".join(page.extract_text() for page in reader.pages))
    for words in ("保护带判定", "guardband(JCGM106,8.3)", "接受限±0.04966", "有条件不合格",
                  "conditionalfail", "falserejection72.1%", "ILAC-G8:09/2019"):  # fmt: skip
        assert words in paper
