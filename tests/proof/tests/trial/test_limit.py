"""The limit that nobody can beat."""

import pytest
from scipy.stats import norm

from tasks.explain.search.stepwise import FALSE_ALARMS
from tests.proof.tests.trial.answers import declared
from tests.proof.trial.limit import freedom_of, power
from tests.proof.trial.parameters import Truth


def test_with_one_parameter_it_is_a_two_sided_test_of_a_normal_variable() -> None:
    bound = norm.isf(FALSE_ALARMS / 2.0)
    for z in (2.0, 3.0, 5.0):
        expected = norm.sf(bound - z) + norm.cdf(-bound - z)
        assert power(z, 1) == pytest.approx(expected, abs=1e-9)


def test_without_a_signal_it_is_the_rate_of_false_alarms() -> None:
    assert power(0.0, 6) == pytest.approx(FALSE_ALARMS)


def test_who_knows_less_of_the_form_finds_less() -> None:
    shares = [power(4.0, k) for k in (1, 3, 9)]
    assert shares == sorted(shares, reverse=True)


def test_open_numbers_are_those_of_the_form() -> None:
    effects = {
        "lever_arm": {"r": [0.001, 0.002, 0.003]},
        "rate_ripple": {"depth": 2e-4, "per_turn": 6, "phase": 0.8},
        "bias_random_walk": {"gyro": [1e-5, 0.0, 0.0], "accel": [0.0, 0.0, 1e-4]},
    }
    response = declared(effects)
    truth = Truth(response["effects"], response["parameters"], response["case"])
    freedoms = [freedom_of(truth, effect) for effect in effects]
    assert freedoms == [3, 2, 6]
