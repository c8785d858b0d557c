"""The truth in the definitions of what is stated."""

from typing import Any

import numpy as np
import pytest

from tests.proof.plant.case import Case
from tests.proof.plant.effects import CATALOGUE
from tests.proof.plant.effects.table import RateRipple
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.world import Setting
from tests.proof.tests.trial.answers import declared
from tests.proof.trial.parameters import CONVERSIONS, Truth, compared, known_parameters


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
