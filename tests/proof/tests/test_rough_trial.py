"""Answers against the truth: wrong names, names in groups, intervals."""

from typing import Any

import pytest

from tests.proof.plant.case import Case
from tests.proof.tests.test_trial import finding
from tests.proof.trial.rough import (
    RoughScore,
    scored_rough,
)


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
    for of_table, compared in ((0.0, 1), (1e-3, 0)):
        known = {"sigma": 1e-3, "of_table": of_table}
        assert len(scores([jittering], timestamp_jitter=known).parameters) == compared
    stepped = finding("bias_step", time=(30.0, 0.1, "s"))
    assert len(scores([stepped], ("bias_step", "bias_step", 40.0)).parameters) == 1
    assert len(scores([stepped], STEP).parameters) == 1
    played = ("hysteresis_play", "hysteresis", 40.0)
    bent = finding("hysteresis", angle=(0.1, 0.01, "rad"))
    assert scores([bent], played, parameters={"amplitude": [1e-3] * 3}).parameters == ()
