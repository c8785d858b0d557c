"""Answers of `explain`, made up, and what they are worth."""

import hashlib
import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO, Recording
from storage.formats.folder import read_folder
from tasks.explain.explain import explain
from tasks.explain.explanation import Explanation
from tests.proof.plant.case import Case, EffectCall, channel_noise
from tests.proof.plant.effects import CATALOGUE
from tests.proof.plant.effects.table import RateRipple
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.simulate import simulate
from tests.proof.plant.world import Setting
from tests.proof.trial.blind import certificate_less, certificate_of
from tests.proof.trial.parameters import CONVERSIONS, Truth, compared, known_parameters
from tests.proof.trial.score import (
    Cost,
    Gap,
    Rate,
    Score,
    cost_of,
    misfits,
    row,
    scored,
    totals_of,
)
from tests.proof.trial.seal import Drawn, check_seals, record_and_seal, set_seals, sized


def declared(effects: dict[str, dict[str, Any]], **case: Any) -> dict[str, Any]:
    """What truth.json says of effects, for a unit with scale factors of 1.01."""
    scale = [[1.01, 0.0, 0.0], [0.0, 1.01, 0.0], [0.0, 0.0, 1.01]]
    return {
        "case": Case(seed=1, **case).model_dump(mode="json"), "effects": effects,
        "parameters": {"Kg": scale, "Ka": scale},
    }  # fmt: skip


def answered(
    effects: dict[str, Any], *findings: str | tuple[str, ...], kind: str = "single",
    z: float | None = 30.0,
) -> Score:  # fmt: skip
    """The score of findings, each a name or a name with its twins, for a truth."""
    response = [
        {"effect": each[0], "indistinguishable_from": list(each[1:]), "parameters": []}
        for each in ((one,) if isinstance(one, str) else one for one in findings)
    ]
    trial = {
        "kind": kind, "asked_z": z, "z": dict.fromkeys(effects, 30.0),
        "concealment": dict.fromkeys(effects, 0.5),
    }  # fmt: skip
    answer = {"verdict": "explained", "findings": response, "seconds": 1.0}
    cost = Cost(3.0, 0.5, "accel_bias x", True, "fail", "pass", True)
    return scored("0001", declared(effects), trial, answer, None, cost)


def finding(effect: str, *group: str, **parameters: tuple[float, float, str]) -> dict[str, Any]:
    """A finding as the engine's JSON says it."""
    return {
        "effect": effect, "group": [effect, *group] if group else None,
        "indistinguishable_from": [],
        "parameters": [
            {"name": name, "value": value, "u": u, "unit": unit}
            for name, (value, u, unit) in parameters.items()
        ],
    }  # fmt: skip


# Two very short cases, one of them clean, recorded and sealed once.

SHORT: dict[str, Any] = {
    "seed": 11,
    "rate_hz": 50,
    "dwell_s": 5.0,
    "rates_deg_s": (200.0,),
    "procedure": "rests",
}


@pytest.fixture(scope="session")
def two_cases() -> list[Drawn]:
    """A clean one, and biases that follow the temperature, plain to see."""
    warm = EffectCall(name="temperature_bias")
    return [
        Drawn(number=1, kind="clean", case=Case(**SHORT)),
        Drawn(number=2, kind="single", z=60.0, case=Case(**SHORT, effects=(warm,))),
    ]


@pytest.fixture(scope="session")
def sealed_once(two_cases: list[Drawn], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sealed")
    for drawn in two_cases:
        record_and_seal(drawn, folder)
    set_seals(folder)
    return folder


@pytest.fixture
def sealed(sealed_once: Path, tmp_path: Path) -> Path:
    """The folder of a trial that waits to be explained; of each test its own."""
    return shutil.copytree(sealed_once, tmp_path, dirs_exist_ok=True)


# Certificates as the blind process writes them: as read, and less what was found.

CASE: dict[str, Any] = {"seed": 5, "rate_hz": 25, "dwell_s": 6.0, "rates_deg_s": (50.0, 200.0)}


@pytest.fixture(scope="module")
def turned_by_earth() -> tuple[Recording, Recording, Explanation]:
    """A run as read, the same without Earth's rotation, and what explain says of the first."""
    case = Case(**CASE, grade="tactical", effects=(EffectCall(name="earth_rotation"),))
    read, clean = simulate(case).recording, simulate(case.only()).recording
    return read, clean, explain(read)


def test_what_was_named_is_taken_off_and_the_certificate_comes_nearer(
    turned_by_earth: tuple[Recording, Recording, Explanation],
) -> None:
    read, clean, explanation = turned_by_earth
    less = certificate_less(read, explanation)
    cost = cost_of(certificate_of(clean), certificate_of(read), less, seed=1)
    assert cost is not None
    assert cost.worst.startswith("gyro_g_sensitivity")
    assert cost.after < 0.2 * cost.before


@pytest.mark.rehearsal
def test_what_is_unnamed_stays_on_the_readings(
    turned_by_earth: tuple[Recording, Recording, Explanation],
) -> None:
    read, _, explanation = turned_by_earth
    unnamed = tuple(replace(each, effect="unnamed") for each in explanation.findings)
    assert certificate_less(read, replace(explanation, findings=unnamed)) is None


def test_an_ahrs_gets_the_items_of_its_own_specification() -> None:
    ahrs = simulate(Case(seed=5, dwell_s=5.0, rates_deg_s=(200.0,), procedure="ahrs"))
    stated = certificate_of(ahrs.recording)
    assert stated is not None
    assert {name.split()[0] for name in stated["values"]} == {
        "ahrs_scale_factor", "ahrs_zero_offset", "ahrs_misalignment"
    }  # fmt: skip


# The truth in the definitions of what is stated.


def truth_of(declared: dict[str, Any]) -> Truth:
    return Truth(declared["effects"], declared["parameters"], declared["case"])


def stated(name: str, value: float, unit: str, u: float = 0.1) -> dict[str, Any]:
    return {"name": name, "value": value, "unit": unit, "u": u}


def test_every_effect_of_the_catalogue_is_compared_but_two() -> None:
    assert set(CATALOGUE) - set(CONVERSIONS) == {"bias_random_walk", "vibration_rectification"}


def test_ripple_of_a_phase_moves_the_shaft_as_its_sine_and_cosine_do() -> None:
    ripple = {"depth": 2e-4, "per_turn": 6, "phase": 0.8}
    truth = truth_of(declared({"rate_ripple": ripple}))
    known = known_parameters(truth, "rate_ripple")
    case = Case(seed=1)
    setting = Setting(case, plan_of(case))
    motor = np.linspace(0.0, 7.0, 50)[None]
    moved = RateRipple(ripple, setting).shaft(motor) - motor
    s, c = known["depth_sin"][0] / 6, known["depth_cos"][0] / 6
    wave = s * np.sin(6 * motor) + c * np.cos(6 * motor)
    np.testing.assert_allclose(moved, wave - wave[0, 0], atol=1e-12)


def test_wobble_turns_with_the_heading() -> None:
    wobble = {"amplitude": 1e-4, "order": 2, "phases": [np.pi / 2, 0.0]}
    straight = known_parameters(truth_of(declared({"axis_wobble": wobble})), "axis_wobble")
    assert straight["east_cos"][0] == pytest.approx(1e-4)
    assert straight["north_sin"][0] == pytest.approx(1e-4)
    # The table's own north now points East.
    turned = known_parameters(
        truth_of(declared({"axis_wobble": wobble}, heading_deg=90.0)), "axis_wobble"
    )
    assert turned["north_cos"][0] == pytest.approx(-1e-4)
    assert turned["east_sin"][0] == pytest.approx(1e-4)


def test_sensor_effects_are_told_for_the_input_and_not_for_what_the_element_answers() -> None:
    effects = {
        "gyro_scale_nonlinearity": {"coefficient": [1e-4, 0.0, 0.0], "order": 3, "top_rate": 5.2},
        "temperature_scale": {"gyro": [0.0, 2e-5, 0.0], "accel": [0.0, 0.0, 0.0]},
    }
    truth = truth_of(declared(effects))
    cubic = known_parameters(truth, "gyro_scale_nonlinearity")["coefficient_x"]
    assert cubic == (pytest.approx(1e-4 * 1.01**3), "1")
    assert known_parameters(truth, "temperature_scale")["gyro_y"][0] == pytest.approx(2e-5 * 1.01)


def test_interval_of_95_percent_decides() -> None:
    truth = truth_of(declared({"lever_arm": {"r": [0.001, 0.002, 0.003]}}))
    response = [stated("r_x", 0.00119, "m", 1e-4), stated("r_y", 0.0018, "m", 1e-4)]
    pairs, alone = compared(truth, "lever_arm", response)
    assert [pair.inside for pair in pairs] == [True, False]
    assert not alone


def test_what_has_another_unit_or_form_is_left_out_and_said() -> None:
    truth = truth_of(
        declared({
            "lever_arm": {"r": [0.001, 0.002, 0.003]},
            "accel_nonlinearity": {"coefficient": [1e-4, 0.0, 0.0], "order": 3},
        })
    )  # fmt: skip
    pairs, alone = compared(truth, "lever_arm", [stated("r_x", 1.0, "mm")])
    assert (pairs, alone) == ([], ["r_x"])
    square = [stated("coefficient_x", 1e-4, "1"), stated("order", 2.0, "1", 0.0)]
    cube = [stated("coefficient_x", 1e-4, "1"), stated("order", 3.0, "1", 0.0)]
    pairs, alone = compared(truth, "accel_nonlinearity", square + cube)
    assert len(pairs) == 1
    assert alone == ["coefficient_x"]


def test_lost_runs_are_compared_only_where_as_many_were_found() -> None:
    truth = truth_of(declared({"dropped_samples": {"times": [10.0, 20.0], "lost": [2, 2]}}))
    one = [stated("lost_1", 2.0, "1"), stated("time_1", 20.0, "s")]
    assert compared(truth, "dropped_samples", one) == ([], ["lost_1", "time_1"])
    other = [stated("lost_2", 2.0, "1"), stated("time_2", 20.0, "s")]
    pairs, _ = compared(truth, "dropped_samples", [*one, *other])
    assert [pair.true for pair in pairs] == [2.0, 10.0, 2.0, 20.0]


# Answers made by hand, and what they are worth.

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


# What is handed out tells nothing, and what is sealed stays as it was.


def test_recording_is_handed_out_without_its_truth(sealed: Path) -> None:
    handed = sorted(path.name for path in (sealed / "recordings" / "0002").iterdir())
    assert handed == ["environment.parquet", "imu.parquet", "manifest.json", "table.parquet"]
    assert "temperature_bias" not in (sealed / "recordings/0002/manifest.json").read_text()
    assert read_folder(sealed / "recordings" / "0002").imu.columns.keys() >= {"gyro_x", "accel_z"}


def test_truth_is_sealed_with_the_visibility_that_was_asked(sealed: Path) -> None:
    trial = json.loads((sealed / "sealed/0002/trial.json").read_text())
    assert trial["z"]["temperature_bias"] == pytest.approx(60.0, rel=0.03)
    assert trial["floor"] > 6.0  # a parameter of each channel at the least
    value, U = trial["certificate"]["values"]["accel_bias x"]
    assert 0.0 < U < abs(value)
    truth = json.loads((sealed / "sealed/0002/truth.json").read_text())
    assert list(truth["effects"]) == ["temperature_bias"]


def test_seals_are_the_sha256_of_every_sealed_file(sealed: Path) -> None:
    lines = (sealed / "seals.txt").read_text().splitlines()
    assert len(lines) == 6  # three files of each case
    for digest, name in (line.split("  ") for line in lines):
        assert hashlib.sha256((sealed / name).read_bytes()).hexdigest() == digest
    check_seals(sealed)


def test_a_changed_a_lost_and_a_new_file_break_the_seal(sealed: Path) -> None:
    truth = sealed / "sealed/0001/truth.json"
    text = truth.read_text()
    truth.write_text(text + " ")
    with pytest.raises(Unusable, match=r"0001/truth\.json is not what was sealed"):
        check_seals(sealed)
    truth.unlink()
    with pytest.raises(Unusable, match=r"0001/truth\.json"):
        check_seals(sealed)
    truth.write_text(text)
    check_seals(sealed)
    (sealed / "sealed/0003").mkdir()
    (sealed / "sealed/0003/truth.json").write_text("{}")
    with pytest.raises(Unusable, match="0003"):
        check_seals(sealed)


def test_seals_have_a_seal_of_their_own(sealed: Path) -> None:
    before = set_seals(sealed)
    assert before == hashlib.sha256((sealed / "seals.txt").read_bytes()).hexdigest()
    (sealed / "sealed/0001/truth.json").write_text("{}")
    assert set_seals(sealed) != before


@pytest.mark.rehearsal
def test_effect_that_the_procedure_cannot_have_is_played_on_three_axes() -> None:
    square = EffectCall(name="axis_nonorthogonality")
    case = Case(seed=3, procedure="single_axis", dwell_s=5.0, effects=(square,))
    played = sized(Drawn(number=1, kind="single", case=case, z=30.0))
    assert played.procedure == "three_axis"
    assert [call.name for call in played.effects] == ["axis_nonorthogonality"]
