"""A prediction from elsewhere in place of the standard's model."""

import numpy as np
import pytest

from tasks.explain.evidence.reference_deviation import OTHER
from tasks.explain.explain import explain
from tasks.explain.inputs.reference import ReferencePrediction
from tasks.model.simulate import predict
from tasks.model.term import nominal_values
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import whole_motion


def reference_of(recording, change: float = 0.0) -> ReferencePrediction:
    """What the standard's model fitted to the recording says, its first scale factor changed."""
    fitted = explain(recording)
    more = np.zeros_like(fitted.nominal)
    ideal = nominal_values(STANDARD_TERMS)
    moved = ideal.copy()
    moved[0] += change
    motion = whole_motion(recording)
    more = predict(STANDARD_TERMS, motion, moved) - predict(STANDARD_TERMS, motion, ideal)
    return ReferencePrediction(fitted.nominal + more, "the test's prediction")


@pytest.fixture(scope="module")
def clean(plant):
    return plant("plant_clean")


def test_a_right_prediction_leaves_nothing_to_say(clean) -> None:
    said = reference_of(clean)
    answer = explain(clean, reference=said)
    assert answer.verdict == "no_mismatch"
    assert answer.model == said.model
    np.testing.assert_array_equal(answer.nominal, said.readings)


def test_a_wrong_scale_factor_of_the_prediction_is_found_as_what_it_is(clean) -> None:
    answer = explain(clean, reference=reference_of(clean, change=1e-3))
    (finding,) = answer.findings
    assert (finding.effect, finding.follows) == ("unnamed", OTHER)
    (parameter,) = [p for p in finding.parameters if p.name == "gyro_matrix_xx"]
    assert parameter.value == pytest.approx(-1e-3, abs=3.0 * parameter.u)
    left = np.nanstd(answer.found - answer.nominal - finding.contribution)
    assert left < 0.02 * np.nanstd(finding.contribution)
