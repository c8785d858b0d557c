"""Degrees of freedom of a type A uncertainty, against the scatter of repeated runs."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tasks.specifications.evidence import ClauseEvidence, gather
from tasks.uncertainty.drift import DRIFTS
from tasks.uncertainty.type_a import type_a_dof


@pytest.fixture(scope="module")
def evidence(ideal_run) -> ClauseEvidence:
    """A run with white noise, of which no drift is left to tell."""
    recording = ideal_run()
    rng = np.random.default_rng(1)
    columns = {n: v + rng.normal(0.0, 1e-3, len(v)) for n, v in recording.imu.columns.items()}
    stream = type(recording.imu)(recording.imu.t, columns)
    found = gather(type(recording)(recording.manifest, stream, digest="0"))
    return replace(found, noise=replace(found.noise, drift=np.zeros((DRIFTS, 6))))


def dof_of(evidence: ClauseEvidence, weights: np.ndarray) -> float:
    variance = float(weights @ evidence.noise_covariances[0] @ weights)
    return type_a_dof(weights, evidence.noise, 0, variance)


def only(evidence: ClauseEvidence, count: int) -> np.ndarray:
    weights = np.zeros(len(evidence.segments))
    weights[:count] = 1.0 / count
    return weights


def test_one_segment_knows_its_white_noise_as_well_as_simulated_ones_do(ideal_run):
    rng = np.random.default_rng(2)
    recording = ideal_run()
    columns = {n: v + rng.normal(0.0, 1e-3, len(v)) for n, v in recording.imu.columns.items()}
    stream = type(recording.imu)(recording.imu.t, columns)
    found = gather(type(recording)(recording.manifest, stream, digest="0"))
    # The rests of three channels, each its own estimate; rate points may be tilted besides.
    white = found.noise.white[found.of_kind("static"), :3]
    observed = 2.0 * white.mean() ** 2 / white.var()
    evidence = replace(found, noise=replace(found.noise, drift=np.zeros((DRIFTS, 6))))
    assert dof_of(evidence, only(evidence, 1)) == pytest.approx(observed, rel=0.3)


def test_equal_segments_add_their_degrees_of_freedom(evidence):
    one, four = dof_of(evidence, only(evidence, 1)), dof_of(evidence, only(evidence, 4))
    assert four == pytest.approx(4.0 * one, rel=0.3)
    assert four < 4.0 * one + 1e-9


def test_drift_is_known_by_the_contrasts_that_told_it(evidence):
    drift = np.zeros((DRIFTS, 6))
    drift[0] = 1.0  # nothing else counts beside it
    contrasts = np.full(6, 17.0)
    drifting = replace(evidence, noise=replace(evidence.noise, drift=drift, contrasts=contrasts))
    assert dof_of(drifting, only(drifting, 3)) == pytest.approx(17.0, rel=0.01)


def test_drift_that_no_contrast_told_is_known_by_the_longest_blocks(evidence):
    drift = np.zeros((DRIFTS, 6))
    drift[0] = 1.0
    noise = replace(evidence.noise, drift=drift, contrasts=np.zeros(6))
    alone = replace(evidence, noise=noise)
    expected = 4.0 * len(evidence.segments)
    assert dof_of(alone, only(alone, 3)) == pytest.approx(expected, rel=0.01)


def test_what_does_not_scatter_is_known(evidence):
    assert type_a_dof(only(evidence, 2), evidence.noise, 0, 0.0) == math.inf
