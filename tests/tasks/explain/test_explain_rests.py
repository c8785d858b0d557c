"""Labelled rests with nothing known between them, and the noise that every unit has."""

import numpy as np
import pytest
from labelled_rests import SIGMA, labelled_rests, one_over_f, recording_of

from tasks.explain.explain import explain
from tasks.explain.noise import flicker_over_gaps


@pytest.mark.rehearsal
@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(more, marks=pytest.mark.rehearsal) for more in (2, 3))]
)
@pytest.mark.parametrize("gap", [0.0, pytest.param(14.0, marks=pytest.mark.rehearsal), 40.0])
def test_an_unstable_bias_is_noise_however_far_the_rests_lie_apart(seed, gap):
    made = recording_of(*labelled_rests(seed, 20.0, gap, turns=3, flicker=0.2))
    explanation = explain(made)
    assert (explanation.verdict, explanation.findings) == ("no_mismatch", ())


def test_a_drift_between_rests_is_still_seen():
    """Far beyond what flicker does, and named by nothing that was recorded."""
    t, readings, segments = labelled_rests(4, 20.0, 14.0, turns=2, flicker=0.2)
    readings[:, 1] += SIGMA[1] * np.sin(2.0 * np.pi * t / 330.0)
    explanation = explain(recording_of(t, readings, segments))
    assert explanation.findings
    assert {one.channels for one in explanation.findings} == {(1,)}


@pytest.mark.parametrize("gap_ratio", [1.0, 2.0, 4.0])
def test_means_of_flicker_differ_as_much_more_over_a_gap(gap_ratio):
    rng = np.random.default_rng(8)
    length, drifts = 256, 400
    distance = round(gap_ratio * length)
    near, far = [], []
    for _ in range(drifts):
        total = np.append(0.0, one_over_f(8 * length, rng).cumsum())
        mean = total[length:] - total[:-length]
        near.append(np.mean((mean[length:] - mean[:-length]) ** 2))
        far.append(np.mean((mean[distance:] - mean[:-distance]) ** 2))
    assert flicker_over_gaps(gap_ratio) == pytest.approx(np.mean(far) / np.mean(near), rel=0.1)
