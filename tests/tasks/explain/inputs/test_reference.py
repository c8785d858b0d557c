"""A prediction from elsewhere in place of the standard's model."""

import numpy as np
import pytest
from short_run import short_run

from schemas.recording import Recording
from tasks.explain.evidence.assemble import OTHER
from tasks.explain.explain import explain
from tasks.explain.inputs.reference import ReferencePrediction
from tasks.model.simulate import predict
from tasks.model.term import nominal_values
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import whole_motion


@pytest.fixture(scope="module")
def clean() -> Recording:
    return short_run(3, dwell_s=5.0).recording


@pytest.fixture(scope="module")
def right(clean) -> ReferencePrediction:
    """What the standard's model fitted to the recording says, whatever else is looked for."""
    nominal = explain(clean, only=["bias_step"]).nominal
    return ReferencePrediction(nominal, "the test's prediction")


def with_scale_factor(right: ReferencePrediction, recording: Recording, change: float):
    """The prediction with its first scale factor changed."""
    ideal = nominal_values(STANDARD_TERMS)
    moved = ideal.copy()
    moved[0] += change
    motion = whole_motion(recording)
    more = predict(STANDARD_TERMS, motion, moved) - predict(STANDARD_TERMS, motion, ideal)
    return ReferencePrediction(right.readings + more, right.model)


def test_a_right_prediction_leaves_nothing_to_say(clean, right) -> None:
    answer = explain(clean, reference=right)
    assert answer.verdict == "no_mismatch"
    assert answer.model == right.model
    np.testing.assert_array_equal(answer.nominal, right.readings)


@pytest.mark.rehearsal
def test_a_wrong_scale_factor_of_the_prediction_is_found_as_what_it_is(clean, right) -> None:
    answer = explain(clean, reference=with_scale_factor(right, clean, 1e-3))
    (finding,) = answer.findings
    assert (finding.effect, finding.follows) == ("unnamed", OTHER)
    (parameter,) = [p for p in finding.parameters if p.name == "gyro_matrix_xx"]
    assert parameter.value == pytest.approx(-1e-3, abs=3.0 * parameter.u)
    left = np.nanstd(answer.found - answer.nominal - finding.contribution)
    assert left < 0.02 * np.nanstd(finding.contribution)
