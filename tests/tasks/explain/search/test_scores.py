"""Scores of candidates: what a gain is worth."""

import numpy as np
import pytest

from tasks.explain.channels import GYROS
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.design import NormalEquations
from tasks.explain.search.empirical_terms import sinusoid
from tasks.explain.search.scores import rank
from tasks.model.terms.geometry import LEVER_ARM

ARM = Candidate(LEVER_ARM, (0,), (0,), 1)
FREE = Candidate(sinusoid(GYROS).shaped((60.0,)), (1,), (0,), 1)


@pytest.mark.parametrize(("more", "first"), [(0.001, "lever_arm"), (0.003, "unnamed")])
def test_a_free_form_must_gain_more_than_the_reference_errs_by(more: float, first: str) -> None:
    """Of a chi-squared of a million, in which a thousandth is certain and means nothing."""
    gains = 1e6 * np.array([1.0, 1.0 + more])
    equations = NormalEquations(np.eye(2), np.sqrt(gains), np.ones(2), 2e6)
    ranked = rank(equations, [ARM, FREE], ())
    assert ranked[0].candidate.name == first
    assert {one.candidate.name: one.gain for one in ranked} == pytest.approx(
        dict(zip(("lever_arm", "unnamed"), gains, strict=True)), rel=1e-5
    )
