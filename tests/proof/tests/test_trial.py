"""Answers of `explain`, made up, and what they are worth, in the plain trial and the rough one."""

import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO
from storage.formats.folder import read_folder
from tests.proof.plant.case import Case, EffectCall, channel_noise
from tests.proof.plant.effects import CATALOGUE
from tests.proof.plant.effects.setup import RateRipple
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.world import Setting
from tests.proof.trial.parameters import CONVERSIONS, Truth, compared, known_parameters
from tests.proof.trial.rough import RoughScore, scored_rough
from tests.proof.trial.score import Cost, Rate, Score, cost_of, misfits, row, scored
from tests.proof.trial.seal import Drawn, check_seals, record_and_seal, set_seals


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
CABLE = {"x_cable_drag": {"gyro": [1e-4, 0.0, 0.0]}}


@pytest.mark.parametrize(("effects", "findings", "right", "or_twin", "wrong", "beyond_twins"), [
    (LEVER, ("unnamed", "lever_arm"), True, True, (), ()),
    (LEVER, ("lever_arm", "axis_tilt"), True, True, ("axis_tilt",), ("axis_tilt",)),
    (LEVER, (("size_effect", "lever_arm"),), False, True, ("size_effect",), ()),
    (LEVER, (("lever_arm", "size_effect"),), True, True, (), ()),
    (CABLE, ("axis_wobble",), False, False, ("axis_wobble",), ("axis_wobble",)),
    (CABLE, ("unnamed",), False, False, (), ()),
])  # fmt: skip
def test_a_name_is_right_wrong_or_the_twin_of_a_true_one(
    effects: dict[str, Any], findings: tuple[Any, ...], right: bool, or_twin: bool,
    wrong: tuple[str, ...], beyond_twins: tuple[str, ...],
) -> None:  # fmt: skip
    score = answered(effects, *findings)
    assert (score.right, score.right_or_twin) == (right, or_twin)
    assert (score.wrong, score.wrong_beyond_twins) == (wrong, beyond_twins)
    assert score.detected
    assert score.abstained == (findings == ("unnamed",))


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


def test_what_was_found_and_taken_off_brings_a_certificate_nearer() -> None:
    clean, read, less = (
        {"values": {"gyro_bias x": [value, 1.0]}, "scatter": scatter}
        for value, scatter in ((0.0, 0), (30.0, 1), (0.5, 0))
    )
    cost = cost_of(clean, read, less, seed=1)
    assert cost is not None
    assert (cost.before, cost.after, cost.worst) == (30.0, 0.5, "gyro_bias x")
    assert (cost.verdict_before, cost.verdict_after, cost.unnoticed) == ("fail", "pass", False)
    assert cost_of(None, read, less, seed=1) is None


def test_right_is_asked_only_where_there_is_a_name() -> None:
    scores = [answered(LEVER, "lever_arm"), answered(CABLE, "unnamed"),
              answered({"gravity_value": {"difference": 1e-3}})]  # fmt: skip
    assert row("", None, scores).right == Rate(1, 1)


def test_certificate_that_is_off_by_more_than_its_uncertainty_is_counted() -> None:
    figures = row("", None, [answered(LEVER, "lever_arm")])
    assert (figures.before, figures.after, figures.before_most) == (3.0, 0.5, 3.0)
    assert (figures.wrong_before, figures.wrong_after) == (Rate(1, 1), Rate(0, 1))
    assert figures.unnoticed == Rate(1, 1)


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
    before = set_seals(sealed)
    assert before == hashlib.sha256((sealed / "seals.txt").read_bytes()).hexdigest()
    (sealed / "sealed/0001/truth.json").write_text("{}")
    assert set_seals(sealed) != before


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


# Rough recordings: several effects in other forms, and what the reference brings along.


def scores(
    findings: list[dict[str, Any]], *hidden: tuple[str, str, float], left: float = 1.5,
    parameters: dict[str, Any] | None = None, **nuisances: dict[str, Any],
) -> RoughScore:  # fmt: skip
    """The score of findings for hidden effects, each (called, name, z), and nuisances."""
    declared = {
        "case": {
            "run": "hand",
            "case": Case(seed=1).model_dump(mode="json"),
            "tracking": {"turn": [0.0, 0.0, 0.1]},
        },
        "effects": [
            {"called": called, "name": name, "parameters": parameters or KNOWN_STEP}
            for called, name, _ in hidden
        ],
        "nuisances": nuisances,
        "parameters": {"Kg": [[1.0, 0, 0]] * 3, "Ka": [[1.0, 0, 0]] * 3},
    }
    trial = {"kind": "mixed", "z": {called: z for called, _, z in hidden}}
    answer = {"verdict": "explained", "findings": findings, "left_over": {"gyro_x": left}}
    return scored_rough("0001", declared, trial, answer, 3.0)


KNOWN_STEP = {"gyro": [0.0] * 3, "accel": [0.0] * 3, "time": 30.1}
STEP = ("bias_step_moving", "bias_step", 45.0)


def test_a_form_of_an_effect_is_right_by_the_catalogue_s_name() -> None:
    score = scores([finding("bias_step")], STEP)
    assert score.wrong == score.in_group == ()
    assert score.listed[0].named


def test_a_name_that_is_neither_hidden_nor_of_the_reference_is_wrong() -> None:
    declared = [finding("hysteresis"), finding("unnamed"), finding("time_offset")]
    score = scores(declared, STEP, time_offset={"seconds": -4e-3})
    assert score.wrong == ("hysteresis",)
    assert not score.listed[0].named
    assert scores(declared, STEP).wrong == ("hysteresis", "time_offset")


def test_a_lever_arm_is_compared_along_the_unit_s_axes() -> None:
    stated = {"r_x": 0.1, "r_y": 0.0, "r_z": 0.0}
    declared = finding("lever_arm") | {
        "parameters": [
            {"name": name, "value": value, "unit": "m", "u": 1e-5} for name, value in stated.items()
        ]
    }
    score = scores([declared], lever_arm={"r": [0.1, 0.0, 0.0]})
    assert [each.inside for each in score.parameters] == [True, True, True]


def test_what_is_outside_the_catalogue_has_no_right_name() -> None:
    score = scores([finding("bandwidth")], ("x_rig_mode", "x_rig_mode", 400.0))
    assert score.wrong == ("bandwidth",)
    assert score.listed == ()


@pytest.mark.parametrize(("times", "wrong"), [([60.0], ()), ([60.0, 90.0], ("bias_step",))])
def test_a_telegraph_signal_of_one_jump_is_a_bias_step(
    times: list[float], wrong: tuple[str, ...]
) -> None:
    telegraph = ("x_telegraph", "x_telegraph", 275.0)
    score = scores([finding("bias_step")], telegraph, parameters={"times": times})
    assert score.wrong == wrong
    assert score.listed == ()


def test_a_group_that_holds_a_true_name_is_counted_apart() -> None:
    grouped = scores([finding("bandwidth", "time_offset")], ("time_offset", "time_offset", 50.0))
    assert grouped.wrong == ()
    assert grouped.in_group == ("bandwidth",)
    assert (grouped.listed[0].named, grouped.listed[0].in_group) == (False, True)
    older = finding("bandwidth") | {"indistinguishable_from": ["time_offset"]}
    del older["group"]
    assert scores([older], ("time_offset", "time_offset", 50.0)).in_group == ("bandwidth",)


def test_parameters_are_compared_where_they_mean_the_same() -> None:
    response = finding("time_offset", seconds=(-4.1e-3, 1e-4, "s"))
    inside = scores([response], time_offset={"seconds": -4e-3})
    assert [pair.inside for pair in inside.parameters] == [True]
    outside = scores([response], time_offset={"seconds": -3e-3})
    assert [pair.inside for pair in outside.parameters] == [False]
    leaning = finding("reference_frame", tilt_east=(4.1e-3, 2e-4, "rad"))
    tilted = scores([leaning], reference_frame={"tilt": (-4e-3, 0.0, 0.0), "turn": (0, 0, 0)})
    assert [pair.true for pair in tilted.parameters] == [4e-3]
    jittering = finding("timestamp_jitter", jitter=(1e-3, 1e-4, "s"))
    for of_table, count in ((0.0, 1), (1e-3, 0)):
        known = {"sigma": 1e-3, "of_table": of_table}
        assert len(scores([jittering], timestamp_jitter=known).parameters) == count
    stepped = finding("bias_step", time=(30.0, 0.1, "s"))
    assert len(scores([stepped], ("bias_step", "bias_step", 40.0)).parameters) == 1
    assert len(scores([stepped], STEP).parameters) == 1
    played = ("hysteresis_play", "hysteresis", 40.0)
    bent = finding("hysteresis", angle=(0.1, 0.01, "rad"))
    assert scores([bent], played, parameters={"amplitude": [1e-3] * 3}).parameters == ()


# What answers a trial knows nothing of what made it: in one process, which takes a while.

KNOWS = """
import json, sys

def loaded(*beginnings):
    return [name for name in sys.modules if name.startswith(beginnings)]

from tests.proof.real.hand import measured, rests, shaft
judged = ("tasks.explain", "tasks.model", "tasks.motion", "tasks.segments", "tasks.specifications")
hand = loaded(*judged)
import tasks.explain.explain, tasks.explain.report, tests.proof.trial.blind
explain = loaded("tests.proof.plant")
print(json.dumps({"hand": hand, "explain": explain}))
"""


def test_hand_shares_no_code_with_what_it_judges_and_what_answers_holds_none_of_the_plant() -> None:
    done = subprocess.run(
        [sys.executable, "-c", KNOWS], capture_output=True, text=True, timeout=600, check=True
    )
    assert json.loads(done.stdout) == {"hand": [], "explain": []}
