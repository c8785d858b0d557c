"""The first sentence says how much is explained, how much is not, and what to look at first."""

import numpy as np
import pytest

from schemas.discrepancy import Discrepancy, FoundParameter, HeldOut
from tasks.explain.correction.consequences import Consequences
from tasks.explain.report import discrepancy_of
from tasks.readings.plausibility import found_on_sight
from tasks.words import message
from tests.tasks.explain.report.made_report import (
    BIAS,
    answer,
    explanation,
    finding,
    located,
    unnamed,
    where,
)


def first_sentence(discrepancy: Discrepancy) -> str:
    return discrepancy.statement.en.partition(". ")[0]


def test_the_largest_finding_is_what_to_look_at_first():
    text = first_sentence(answer(explanation(finding())))
    assert text == (
        "62 % of the mismatch above noise is explained, 38 % is not; look first at: Table not level"
    )
    assert "首先应检查：转台不水平" in answer(explanation(finding())).statement.zh


def test_where_more_is_left_than_any_finding_removes_the_worst_channel_comes_first():
    left = np.array([1.0, 31.4, 2.0, 1.0, 1.0, 1.0])
    text = answer(explanation(finding(share=0.2), left_over=left)).statement.en
    assert "look first at: the residual of the gyro y (χ² = 31.40 per degree of freedom)" in text
    assert "χ² per degree of freedom: gyro y 31.40, gyro z 2.00." in text


@pytest.mark.parametrize(
    ("run", "first"),
    [
        ("invalid", "As it was imported, this run is invalid: The encoders turn"),
        ("remarks", "No physics"),
    ],
)
def test_what_makes_a_run_invalid_on_sight_stands_before_no_mismatch(run, first):
    sentence = message("plausibility-table-unit", ratio="57", option="--units table=deg")
    seen = found_on_sight("table_unit", sentence, run=run)
    answered = answer(explanation(verdict="no_mismatch", remarks=(seen,)))
    assert answered.statement.en.startswith(first)


def test_small_remainders_are_one_line():
    small = (finding(share=0.004), unnamed(share=0.0))
    discrepancy = answer(explanation(finding(), small=small))
    assert [each.en for each in discrepancy.small_remainders] == [
        "Table not level (< 1 %)",
        "unnamed: a relaxation of 12 s after each move (< 1 %)",
    ]
    assert "Minor remainders: Table not level (< 1 %); unnamed:" in discrepancy.statement.en
    assert len(discrepancy.findings) == 1


def test_a_channel_that_was_not_recorded_has_nothing_left_over():
    left = np.array([1.0, 1.0, 1.0, np.nan, np.nan, np.nan])
    assert set(answer(explanation(finding(), left_over=left)).left_over) == {
        "gyro_x", "gyro_y", "gyro_z",
    }  # fmt: skip


def test_what_the_standards_parameters_absorb_is_no_share_of_a_mismatch():
    absorbed = explanation(finding(share=0.0, held_out_gain=0.0))
    assert "The residual shows no mismatch above noise" in first_sentence(answer(absorbed))
    left = np.array([50.0] + 5 * [1.0])
    beside = explanation(finding(share=0.0, held_out_gain=0.0), left_over=left)
    assert "The residual shows no mismatch" not in first_sentence(answer(beside))


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [(2.0, 1.0, "falls from 2.00 to 1.00"), (1.1, 1.3, "rises from 1.10 to 1.30"),
     (1.0, 1.0, "freedom is 1.00")],
)  # fmt: skip
def test_where_unseen_segments_go_is_said_as_it_is(before, after, says):
    for ratio in (1.0, 0.5):
        held_out = HeldOut(
            rms_ratio={"accel_x": ratio}, chi2_per_dof_before=before, chi2_per_dof_after=after
        )
        text = answer(explanation(finding(), held_out=held_out)).statement.en
        assert says in text
        assert ("rms residual of the accelerometer x falls to 50 %" in text) == (ratio < 1.0)


@pytest.mark.parametrize(("p", "words"), [(0.4, "agree between"), (1e-5, "to withhold the name")])
def test_a_law_says_whether_it_is_the_same_in_all_parts(p, words):
    written = answer(explanation(finding(homogeneity_p=p))).findings[0]
    assert words in written.statement.en
    assert written.homogeneity_p == p


def test_a_group_is_told_with_its_members_and_the_recording_that_separates_it():
    group = ("time_offset", "bandwidth")
    made = finding(effect="time_offset", group=group, indistinguishable=("bandwidth",),
                   separated_by="oscillation at several frequencies",
                   common=(FoundParameter(name="group_delay", value=4.5e-3, unit="s", u=5e-5),),
                   )  # fmt: skip
    written = answer(explanation(made)).findings[0]
    assert written.group == group
    assert "an offset between the clocks or the unit's low-pass filter" in written.statement.en
    assert "Their common part is group delay = (4.50 ± 0.10) ms (k = 2)." in (written.statement.en)
    assert "cannot distinguish it from" not in written.statement.en  # once is enough
    assert "To confirm, record: oscillation at several frequencies." in written.statement.en


def test_every_finding_ends_in_what_to_do_next():
    made = explanation(finding(), unnamed(), verdict="partly_explained")
    for written in answer(made, (BIAS,)).findings:
        for language, word in (("en", "Next step: "), ("zh", "下一步：")):
            end = getattr(written.statement, language).rpartition(word)[2]
            assert end.rstrip(".。") == getattr(written.next, language)


def test_what_others_take_back_is_told_of_the_set():
    alone = BIAS.model_copy(update={"after": BIAS.before - 10.9 * BIAS.U})
    of_set = BIAS.model_copy(update={"after": BIAS.before - 1.0 * BIAS.U})
    both = explanation(finding(share=0.4), finding(share=0.2))
    effects = Consequences(((alone,), ()), ((), ()), (of_set,))
    written = discrepancy_of(both, [(where(),), (where(),)], effects)
    assert "by −10.9 U, but the other findings offset that: together they change it by −1.0 U" in (
        written.findings[0].statement.en
    )
    assert written.consequences == (of_set,)


def test_the_json_has_the_fields_of_the_contract():
    discrepancy = located(explanation(finding(), homogeneous()), (where(),), (where(),))
    written = discrepancy.model_dump(mode="json")
    assert written["explained_share"] == pytest.approx(1.0)
    assert written["left_over"]["accel_x"] == pytest.approx(1.31)
    assert written["small_remainders"] == []
    plain, tested = written["findings"]
    assert (plain["share"], plain["homogeneity_p"], plain["group"]) == (0.62, None, None)
    assert (tested["homogeneity_p"], tested["group"]) == (0.3, ["axis_tilt", "axis_wobble"])
    assert set(plain["next"]) - {"message"} == {"en", "zh"}


def homogeneous():
    return finding(share=0.38, homogeneity_p=0.3, group=("axis_tilt", "axis_wobble"))
