"""Small probabilities to their last digits, and the standard uncertainty of a k that is not 2."""

import math

import pytest
from sample_results import bias_limit, calibration, item, tolerance

from tasks.conformity import decide
from tasks.conformity.rules import probability_of_conformity, probability_of_nonconformity

TWELVE_SIGMA = 1.7764821120776789e-33  # ½·erfc(12/√2)


def test_a_risk_of_twelve_sigma_has_its_digits() -> None:
    assert 0.5 * math.erfc(12.0 / math.sqrt(2.0)) == pytest.approx(TWELVE_SIGMA, rel=1e-9, abs=0.0)
    above, below = (12.0, math.inf), (-math.inf, -12.0)
    for limits in (above, below, (12.0, 40.0), (-40.0, -12.0)):
        conforms = probability_of_conformity(0.0, 1.0, limits)
        assert conforms == pytest.approx(TWELVE_SIGMA, rel=1e-6, abs=0.0)
    for limits in ((-math.inf, 12.0), (-12.0, math.inf)):
        outside = probability_of_nonconformity(0.0, 1.0, limits)
        assert outside == pytest.approx(TWELVE_SIGMA, rel=1e-6, abs=0.0)


def test_the_risk_of_a_value_counts_with_u_and_not_with_half_of_the_expanded_one() -> None:
    uncertain = item({"x": 0.04}, k=4.0).model_copy(update={"U": {"x": 0.04}, "u": {"x": 0.01}})
    made = decide(calibration({"gyro_bias": uncertain}), tolerance(bias_limit())).limits[0]
    one_sigma = 0.5 * math.erfc(1.0 / math.sqrt(2.0))
    assert 1.0 - made.probability_of_conformity == pytest.approx(one_sigma, rel=1e-6)
