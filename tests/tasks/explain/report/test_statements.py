"""Sentences in two languages name value, U, unit, place, evidence and what else it could be."""

import re

import numpy as np

from schemas.discrepancy import Discrepancy, FoundParameter
from schemas.text import Statement
from tasks.explain.correction.consequences import Consequences
from tasks.explain.report import discrepancy_of
from tasks.explain.report.statements import (
    parameter_name,
    strength_of_evidence,
    times_more_probable,
)
from tasks.model.term import effect_name
from tasks.words import say
from tasks.words import texts as in_languages
from tests.tasks.explain.report.made_report import (
    BIAS,
    CHANGE,
    TILT,
    answer,
    explanation,
    finding,
    located,
    unnamed,
    where,
)


def texts(discrepancy: Discrepancy) -> tuple[str, str]:
    written = discrepancy.findings[0].statement
    return written.en, written.zh


def test_a_finding_says_value_expanded_uncertainty_and_unit_in_both_languages():
    for text in texts(answer(explanation(finding()))):
        assert "(1.234 ± 0.022) mrad" in text
        assert "k = 2" in text


def test_a_finding_says_where_it_sits_and_with_what_share():
    explained = explanation(finding())
    places = (where(share=0.38), where("accel_y", 0.62, segments=("turns_z",)))
    en, zh = texts(located(explained, places))
    assert en.index("accelerometer y (62 %): while +x is up") < en.index("accelerometer x")
    assert "加速度计 y（62 %）：+x 朝上时" in zh


def test_evidence_is_said_in_plain_words():
    en, zh = texts(answer(explanation(finding(delta_bic=512.3, held_out_gain=11.5))))
    assert "10⁵ times as probable (11.5 nats)" in en
    assert "ΔBIC = 512: very strong evidence" in en
    assert "10⁵ 倍" in zh
    assert "证据非常强" in zh


def test_a_pair_is_said_with_the_recording_that_would_separate_it():
    pair = finding(
        indistinguishable=("axis_wobble", "not_yet_in_the_list"),
        separated_by=Statement(en="the outer axis turned by 90°", zh="外轴转 90°"),
    )
    en, zh = texts(answer(explanation(pair)))
    wobble = in_languages(effect_name("axis_wobble"))
    assert f"cannot distinguish it from {wobble['en']} or not yet in the list." in en
    assert "To confirm, record: the outer axis turned by 90°." in en
    assert f"{wobble['zh']}或not yet in the list。" in zh
    assert "应补充记录：外轴转 90°。" in zh


def test_the_largest_shift_on_the_certificate_is_told_in_its_uncertainty():
    small = BIAS.model_copy(update={"element": "y", "before": 0.0002})
    en, zh = texts(answer(explanation(finding()), (small, BIAS), (CHANGE,)))
    assert "Bias of the X accelerometer, from (12.10 ± 0.30) mm/s²" in en
    assert "to (0.10 ± 0.30) mm/s²" in en
    assert "−40.0 U" in en
    assert "from fail to pass" in en
    assert "由“不合格”变为“合格”" in zh


def test_what_findings_change_together_is_said_with_their_numbers():
    effects = Consequences(
        ((BIAS,),) * 3, ((),) * 3, (BIAS,), sets=((0, 2), (1,), (0, 2))
    )  # fmt: skip
    three = explanation(finding(share=0.3), finding(share=0.2), finding(share=0.1))
    made = discrepancy_of(three, ((where(),),) * 3, effects)
    first, second, third = (each.statement for each in made.findings)
    assert [each.jointly_with for each in made.findings] == [(3,), (), (1,)]
    assert "Largest change on the certificate, together with finding 3: Bias of the X" in first.en
    assert "Largest change on the certificate: Bias of the X" in second.en
    assert "与发现 1 合计" in third.zh


def test_what_has_no_value_or_no_uncertainty_is_no_shift():
    gone = [BIAS.model_copy(update={name: None}) for name in ("before", "after", "U")]
    en, _ = texts(answer(explanation(finding()), tuple(gone)))
    assert "on the certificate" not in en


def test_no_mismatch_says_what_was_tested_and_how_often_that_is_wrong():
    written = answer(explanation()).statement
    assert "6 channels were tested over 2.75 min at 20 Hz" in written.en
    assert "2 rests, 2 constant rates, 1 turn by a known angle" in written.en
    assert "p = 0.41" in written.en
    assert "one clean recording in" in written.en
    assert "χ² per degree of freedom is 1.00" in written.en
    assert "6 个通道" in written.zh
    assert "误报" in written.zh


def test_an_explained_recording_says_what_was_left_out_and_the_gain():
    written = answer(explanation(finding()), (BIAS,), (CHANGE,)).statement
    assert (
        "Missing from the standard's model: Table not level (east = (1.234 ± 0.022) mrad)"
        in written.en
    )
    assert "from 2.91 to 1.02" in written.en
    assert "accelerometer x falls to 31 %" in written.en
    assert "1 value on the certificate" in written.en
    assert "转台不水平" in written.zh


def test_a_name_that_is_not_sure_has_its_rivals_beside_it_from_the_first_sentence_on():
    written = answer(explanation(finding(indistinguishable=("axis_wobble",)))).statement
    rival = say(effect_name("axis_wobble"), "en")
    assert re.search(f"Table not level [^;]*, or {rival}, which .* cannot distinguish", written.en)
    assert "（本次记录无法区分）" in written.zh


def test_the_answer_is_the_contracts_json():
    discrepancy = answer(explanation(finding(), unnamed()), (BIAS,), (CHANGE,))
    assert Discrepancy.model_validate_json(discrepancy.model_dump_json()) == discrepancy
    assert discrepancy.findings[0].channels == ("accel_x", "accel_y")
    assert discrepancy.findings[0].parameters == (TILT,)
    assert set(discrepancy.figures) > {"where.svg", "before_after.svg", "where-zh.svg"}


def test_many_parameters_are_told_by_the_three_most_significant():
    many = tuple(
        FoundParameter(name=f"c_{i}", value=float(i), unit="1", u=1.0) for i in range(1, 10)
    )
    en, zh = texts(answer(explanation(finding(parameters=many))))
    assert "c_9 = 9.0 ± 2.0, c_8 = 8.0 ± 2.0, c_7 = 7.0 ± 2.0, and 6 more (k = 2)" in en
    assert "，另有 6 个参数（k = 2）" in zh


def test_parameters_are_called_by_channel_triad_or_symbol():
    named = {
        "gyro_x": "gyro x", "accel": "accelerometers", "r_x": "r_x",
        "seconds": "delay of the unit behind the reference (negative: the reference is late)",
        "rms_gyro_x": "rms of the gyro x within the run",
        "rate_accel_y": "wander of the accelerometer y",
        "accel_y_3": "factor 3 of the accelerometer y", "vertical_rate": "vertical rate",
    }  # fmt: skip
    assert {name: say(parameter_name(name), "en") for name in named} == named


def test_words_of_evidence_follow_its_size():
    assert [say(strength_of_evidence(x), "en").split()[0] for x in (50.0, 8.0, 3.0, -1.0)] == [
        "very", "strong", "some", "no",
    ]  # fmt: skip
    beyond, times = times_more_probable(1e6), times_more_probable(np.log(5.0))
    assert in_languages(beyond) == {"en": "more than 10¹⁰⁰ times", "zh": "10¹⁰⁰ 倍以上"}
    assert in_languages(times) == {"en": "5 times", "zh": "5 倍"}
