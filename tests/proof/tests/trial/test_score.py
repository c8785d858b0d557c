"""Answers made by hand, and what they are worth."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from schemas.recording import ACCEL, GYRO
from tests.proof.plant.case import Case, channel_noise
from tests.proof.tests.trial.answers import answered, declared
from tests.proof.trial.score import Gap, Rate, misfits, row, rows_of, scored, totals_of

LEVER = {"lever_arm": {"r": [0.001, 0.002, 0.003]}}
TILT = {"axis_tilt": {"east": 1e-4, "north": 0.0}}
CABLE = {"x_cable_drag": {"gyro": [1e-4, 0.0, 0.0]}}


def test_first_name_right() -> None:
    score = answered(LEVER, "unnamed", "lever_arm")
    assert score.detected
    assert score.right
    assert not score.wrong
    assert not score.abstained


def test_wrong_name_beside_the_right_one_counts() -> None:
    score = answered(LEVER, "lever_arm", "axis_tilt")
    assert score.right
    assert score.wrong == ("axis_tilt",)
    assert score.wrong_beyond_twins == ("axis_tilt",)


def test_twin_that_lists_the_truth_counts_both_ways() -> None:
    score = answered(LEVER, ("size_effect", "lever_arm"))
    assert not score.right
    assert score.right_or_twin
    assert score.wrong == ("size_effect",)
    assert score.wrong_beyond_twins == ()


def test_name_only_listed_as_a_twin_is_not_wrong() -> None:
    score = answered(LEVER, ("lever_arm", "size_effect"))
    assert score.right
    assert score.wrong == ()


def test_any_name_is_wrong_outside_the_catalogue() -> None:
    assert answered(CABLE, "axis_wobble").wrong == ("axis_wobble",)
    left = answered(CABLE, "unnamed")
    assert left.abstained
    assert not left.wrong


def test_finding_on_a_clean_recording_is_a_false_alarm() -> None:
    alarms = [answered({}, kind="clean", z=None), answered({}, "unnamed", kind="clean", z=None)]
    assert totals_of(alarms)["clean"].detected == Rate(1, 2)


def test_failure_of_explain_is_no_detection() -> None:
    trial = {"kind": "single", "asked_z": 10.0, "z": {}, "concealment": {}}
    answer = {"failed": "ValueError: no", "seconds": 0.5}
    score = scored("0001", declared(LEVER), trial, answer, None)
    assert score.failed == "ValueError: no"
    assert not score.detected


def test_parameters_of_what_was_rightly_named_are_compared() -> None:
    stated = [{"name": "r_y", "value": 0.0021, "unit": "m", "u": 1e-4}]
    findings = [
        {"effect": name, "indistinguishable_from": [], "parameters": stated}
        for name in ("lever_arm", "size_effect")
    ]
    trial = {"kind": "single", "asked_z": 10.0, "z": {}, "concealment": {}}
    answer = {"verdict": "explained", "findings": findings, "seconds": 0.5}
    score = scored("0001", declared(LEVER), trial, answer, None)
    assert [pair.inside for pair in score.parameters] == [True]


def test_misfits_count_in_units_of_the_white_noise_where_both_are_known(tmp_path: Path) -> None:
    case = Case(seed=1, rate_hz=50).model_dump(mode="json")
    sigma = [noise.white * 5.0 for noise in channel_noise(case["grade"])]
    truth = {channel: np.zeros(10) for channel in GYRO + ACCEL}
    response = {}
    for channel, one in zip(GYRO + ACCEL, sigma, strict=True):
        response[f"{channel}_nominal"] = np.full(10, 2.0 * one)
        response[f"{channel}_found"] = np.r_[np.nan, np.full(9, 0.5 * one)]
    pq.write_table(pa.table(truth), tmp_path / "truth.parquet")
    pq.write_table(pa.table(response), tmp_path / "prediction.parquet")
    first, left = misfits(tmp_path / "truth.parquet", tmp_path / "prediction.parquet", case)
    assert first == pytest.approx(6 * 9 * 4.0)
    assert left == pytest.approx(6 * 9 * 0.25)


def test_gap_is_told_whole_and_of_what_noise_lets_be_closed() -> None:
    gap = Gap(first=1000.0, left=300.0, floor=200.0)
    assert gap.closed == pytest.approx(0.7)
    assert gap.of_closable == pytest.approx(0.875)
    assert Gap(first=100.0, left=100.0, floor=200.0).of_closable is None


def test_rows_are_by_effect_and_z_with_the_clean_ones_first() -> None:
    scores = [
        answered(CABLE, "unnamed", kind="outside"),
        answered(LEVER, "lever_arm", z=100.0),
        answered(LEVER, "lever_arm"),
        answered(LEVER | TILT, "lever_arm", kind="several", z=40.0),
        answered({}, kind="clean", z=None),
    ]
    names = [(each.name, each.z) for each in rows_of(scores)]
    assert names == [
        ("clean", None), ("lever_arm", 30.0), ("lever_arm", 100.0), ("x_cable_drag", 30.0),
        ("2 effects together", 40.0),
    ]  # fmt: skip
    assert row("", None, scores[3:4]).found == Rate(1, 2)


def test_right_is_asked_only_where_there_is_a_name() -> None:
    scores = [answered(LEVER, "lever_arm"), answered(CABLE, "unnamed"),
              answered({"gravity_value": {"difference": 1e-3}})]  # fmt: skip
    assert row("", None, scores).right == Rate(1, 1)


def test_certificate_that_is_off_by_more_than_its_uncertainty_is_counted() -> None:
    figures = row("", None, [answered(LEVER, "lever_arm")])
    assert (figures.before, figures.after, figures.before_most) == (3.0, 0.5, 3.0)
    assert (figures.beyond_before, figures.beyond_after) == (Rate(1, 1), Rate(0, 1))
    assert (figures.wrong_before, figures.wrong_after) == (Rate(1, 1), Rate(0, 1))
    assert figures.unnoticed == Rate(1, 1)


def test_rates_carry_wilsons_interval() -> None:
    low, high = Rate(0, 84).interval or (0.0, 0.0)
    assert low == 0.0
    assert high == pytest.approx(0.0437, abs=5e-4)
    assert Rate(0, 0).interval is None
