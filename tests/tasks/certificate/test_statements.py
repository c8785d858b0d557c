"""How the certificate tells limits, rules, risks and conditional verdicts."""

import re
from datetime import UTC, datetime
from typing import Any

import pytest

from schemas.certificate import Certificate, Step, StepName
from schemas.recording import Segment
from schemas.text import Remark
from schemas.tolerance import Limit, ProductionPrior, Tolerance
from tasks.certificate.content import Content
from tasks.certificate.results import Group, sections
from tasks.certificate.statements import alike
from tasks.conformity import decide
from tasks.conformity.limits import probability_text
from tasks.run_validity.remark import run_remark
from tasks.specifications.joint.remarks import CLAUSES
from tasks.specifications.register import SPECIFICATIONS
from tasks.words import remark
from tests.tasks.certificate.sample_certificate import (
    AXES,
    calibration,
    certificate,
    content,
    item,
    items,
    laboratory,
    manifest,
    printed,
    tolerance,
)

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


def test_a_conditional_pass_is_marked_where_it_stands_and_on_the_cover():
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


def test_the_largest_risks_are_told_with_whose_they_are():
    zh, en = fields(content(made([0.0499, 0.0501, 0.02], tolerance())))["Risk of a wrong decision"]
    assert "false acceptance of a pass, 1 − P_c, the largest 27.9 % (B_gx)" in en
    assert "false rejection of a fail, P_c, the largest 27.9 % (B_gy)" in en
    assert "错误接受概率 1 − P_c，最大者 27.9 %" in zh


def test_a_guard_band_prints_its_rule_its_width_and_its_acceptance_limits():
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


def test_several_rules_are_told_one_by_one_with_their_items():
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


def test_relative_limits_are_told_both_ways():
    limit = Limit(item="gyro_scale_factor", unit="1", relative=True, nominal=1.0, magnitude=0.003)
    group = content(made([0.01, 0.01, 0.02], limited(limit))).sections[0].groups[0]
    assert group.rows[0].limits == ("0.997 … 1.003",)
    assert ("相对允许限：±0.3 % × 1。", "Relative limits: ±0.3 % × 1.") in group.sentences


def test_a_prior_gives_the_risks_over_the_production():
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
def test_a_probability_is_never_printed_as_certainty(probability, text):
    assert probability_text(probability) == text


# Remarks told once with their segments, and who signs: whoever took the steps.

NAMES = [f"rate_{axis}_{rate:+d}" for axis in "xyz" for rate in (-300, -100, -10, 10, 100, 300)]
MORNING = datetime(2026, 11, 21, 8, tzinfo=UTC)


def unsteady(name: str, number: int, **changes: object) -> Remark:
    varies = run_remark(
        "unsteady_rate", name, segment=name, witness="encoders", wander=f"{number / 100}",
        clause="7.2", percent="0.1",
    )  # fmt: skip
    return varies.model_copy(update=changes)


def test_what_is_so_of_one_segment_after_the_other_is_told_once_with_the_list():
    every = tuple(unsteady(name, number) for number, name in enumerate(NAMES))
    made = content(certificate(calibration(remarks=every)))
    (row,) = made.remarks
    zh, en = row.text
    assert en.startswith("rate_x_-300: according to ")
    assert en.endswith("to 17 more segments. This prevents a pass.")
    assert row.segments == ", ".join(NAMES[1:])
    assert "另有 17 段" in zh


def test_of_many_segments_only_number_and_kind_stand_in_the_remark():
    rests = [f"rest_{n}" for n in range(5)]
    labelled = [
        Segment(name=name, kind="static", t_start=n, t_end=n + 1) for n, name in enumerate(rests)
    ] + [
        Segment(name=n, kind="rate", axis=n[5], rate_deg_s=float(n[7:]), t_start=9, t_end=10)
        for n in NAMES
    ]
    of = manifest().model_copy(update={"segments": tuple(labelled)})
    slow = Remark(code="slow", en="Slow.", zh="采样慢。", segments=(*rests, *NAMES))
    few = Remark(code="few", en="Odd.", zh="异常。", segments=tuple(rests[:2]))
    made = content(certificate(calibration(remarks=(slow, few)), manifest=of))
    first, second = made.remarks
    assert first.text == (
        "采样慢。[静止 5 段；恒速转动 18 段]", "Slow. [5 rests; 18 constant rates]",
    )  # fmt: skip
    assert first.segments == ", ".join((*rests, *NAMES))
    assert (second.text[1], second.segments) == ("Odd. [rest_0, rest_1]", "")


def test_remarks_that_differ_in_more_than_figures_stay_apart():
    other = remark("unsteady_rate", "Something else.", NAMES[:1], blocks_pass=True, run="remarks")
    blocking = unsteady(NAMES[1], 1, blocks_pass=False)
    whole = Remark(code="unsteady_rate", en="A.", zh="A.")
    groups = alike([unsteady(NAMES[0], 1), other, blocking, whole, whole])
    assert [len(group) for group in groups] == [1, 1, 1, 1, 1]


def test_the_reasons_count_the_remarks_that_are_printed():
    blocking = tuple(unsteady(name, 1, blocks_pass=True) for name in NAMES)
    made = content(certificate(calibration(remarks=blocking)))
    assert made.reasons[-1][1] == "Remarks below that prevent a pass: 1."


def steps(**persons: str) -> tuple[Step, ...]:
    names: dict[str, StepName] = {"draft": "draft", "check": "check", "issue": "issue"}
    return tuple(
        Step(step=names[name], person=person, at=MORNING) for name, person in persons.items()
    )


@pytest.mark.parametrize(
    ("state", "taken", "names"),
    [
        ("draft", {"draft": "Sun"}, ["Wu", "not yet checked", "not yet issued"]),
        ("checked", {"draft": "Sun", "check": "Qian"}, ["Wu", "Qian", "not yet issued"]),
        ("issued", {"draft": "Sun", "check": "Qian", "issue": "Zhou"}, ["Wu", "Qian", "Zhou"]),
    ],
)
def test_who_took_a_step_signs_and_nobody_else(state, taken, names):
    """Wu measured, and Sun drafted; the laboratory's file names Wang Fang and Zhang Wei."""
    made = content(certificate(state=state, steps=steps(**taken), operator="Wu"))
    signed = {each.role[1]: each for each in made.signatures}
    assert [signed[role].name[1] for role in ("Operator", "Checked by", "Issued by")] == names


def test_a_title_belongs_to_whom_the_laboratory_names():
    for person, title in (("Zhou", "not given"), ("张伟 Zhang Wei", "Technical director")):
        taken = steps(draft="Sun", check="Qian", issue=person)
        signed = content(certificate(steps=taken)).signatures
        assert signed[-1].title[1] == title
    anybody = certificate(laboratory=laboratory(issuer=None), steps=steps(issue="Zhou"))
    assert content(anybody).signatures[-1].title[1] == "Technical director"


# What a certificate of the joint method claims: a fit of the models, and not the clauses.


def groups(method: str) -> dict[str, Group]:
    made = calibration(
        method=method,
        items={
            name: item.model_copy(
                update={"clause": f"{CLAUSES[name.partition('_')[0]]}, joint method"}
            )
            for name, item in items().items()
        },
    )
    found = printed(sections(made, decide(made, tolerance()), SPECIFICATIONS[method]))
    return {group.title[1]: group for section in found for group in section.groups}


def test_no_value_of_a_joint_fit_is_said_to_be_by_an_equation_of_the_clauses():
    headings = [
        heading
        for name in ("Gyro g-sensitivity", "Accelerometer rate sensitivity")
        for column in groups("joint")[name].columns
        for heading in column
    ]
    assert "Value" in headings  # of the g-sensitivity, which the fit gives once
    assert not any(re.search(r"by eq\.|^\(a\) 式\(7\)", heading) for heading in headings)
    assert "(a) by eq. (7)" in dict(groups("jjf2003")["Gyro g-sensitivity"].columns).values()


def test_the_g_sensitivity_of_a_joint_fit_has_one_column_without_letters():
    group = groups("joint")["Gyro g-sensitivity"]
    assert len(group.columns) == len(group.matrices) == 1
    assert {row.second for row in group.rows} == {None}
    assert not any(line.startswith("(") for row in group.rows for line in row.limits)
    assert not any("applied to" in en for _, en in group.sentences)
