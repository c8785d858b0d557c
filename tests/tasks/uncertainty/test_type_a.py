"""Type A uncertainty of means of correlated samples, and its degrees of freedom."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from schemas.recording import ACCEL, GYRO, Segment, Stream
from tasks.readings.plausibility import steps
from tasks.segments.summarise import SegmentMean, summarise
from tasks.specifications.evidence import ClauseEvidence, gather
from tasks.uncertainty.drift import DRIFTS
from tasks.uncertainty.type_a import covariance_of_means, fit_noise, type_a_dof

# Type A uncertainty of means of correlated samples, against simulated noise.

RATE = 20.0
DWELL = 30.0


def flicker(rng: np.random.Generator, rows: int, strength: float) -> np.ndarray:
    """1/f noise (rows, 6) with S(f) = strength/f (one-sided), made in the frequency domain.

    Four times as long as asked, so that it also wanders slower than what is used of it.
    """
    long = 4 * rows
    frequency = np.fft.rfftfreq(long, 1 / RATE)
    frequency[0] = np.inf
    amplitude = np.sqrt(strength / frequency * RATE * long / 2)
    phases = rng.normal(size=(len(frequency), 6)) + 1j * rng.normal(size=(len(frequency), 6))
    return np.fft.irfft(amplitude[:, None] * phases / np.sqrt(2), long, axis=0)[:rows]


def segments_of(values: np.ndarray) -> tuple[SegmentMean, ...]:
    t = np.round(np.arange(len(values)) / RATE, 9)
    imu = Stream(t, dict(zip(GYRO + ACCEL, values.T, strict=True)))
    starts = np.arange(0.0, t[-1] - DWELL + 1, DWELL)
    labels = (
        Segment(name=f"s{i}", kind="static", t_start=s, t_end=s + DWELL)
        for i, s in enumerate(starts)
    )
    step = steps(imu)
    return tuple(s for s in (summarise(imu, label, "label", step) for label in labels) if s)


@cache
def means_and_covariances(drift: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """Of 30 runs × 6 channels: the means of the segments (n,) and what is stated of them (n, n)."""
    found, rows = [], round(24 * DWELL * RATE)
    for seed in range(30):
        rng = np.random.default_rng(seed)
        white = rng.normal(0.0, 0.05, (rows, 6))
        segments = segments_of(white + (flicker(rng, rows, drift) if drift else 0.0))
        noise, means = fit_noise(segments), np.array([s.mean for s in segments])
        found += [(means[:, c], covariance_of_means(noise, c)) for c in range(6)]
    return found


def first_against_second_half(count: int) -> np.ndarray:
    sign = np.where(np.arange(count) < count // 2, 1.0, -1.0)
    return sign / count


def neighbours(count: int) -> np.ndarray:
    return (-1.0) ** np.arange(count) / count


@pytest.mark.parametrize("weights", [first_against_second_half, neighbours])
@pytest.mark.parametrize("drift", [0.0, 1e-4])
def test_differences_of_means_scatter_as_stated(weights, drift):
    squares = []
    for means, covariance in means_and_covariances(drift):
        of = weights(len(means))
        squares.append((of @ means) ** 2 / (of @ covariance @ of))
    # Labels that name no axis up leave no contrast to show that there is no drift.
    assert (0.75 if drift else 0.45) < np.sqrt(np.mean(squares)) < 1.25


def test_correlated_samples_are_not_counted_as_independent():
    rng = np.random.default_rng(0)
    rows = round(24 * DWELL * RATE)
    correlated = np.zeros((rows, 6))
    for i in range(1, rows):
        correlated[i] = 0.95 * correlated[i - 1] + rng.normal(0.0, 0.05, 6)
    segments = segments_of(correlated)
    stated = np.sqrt(covariance_of_means(fit_noise(segments), 0)[0, 0])
    naive = correlated[:, 0].std() / np.sqrt(DWELL * RATE)
    assert stated > 4 * naive  # the truth is sqrt(1.95/0.05) = 6.2 times the naive value
    observed = np.array([s.mean for s in segments])[:, 0].std()
    # White plus flicker is not this noise's shape: it may be overstated, never understated.
    assert 0.8 * observed < stated < 5 * observed


def test_white_noise_alone_gives_sigma_over_root_n():
    rows = round(24 * DWELL * RATE)
    segments = segments_of(np.random.default_rng(1).normal(0.0, 0.05, (rows, 6)))
    noise, weights = fit_noise(segments), neighbours(len(segments))
    covariances = [covariance_of_means(noise, channel) for channel in range(6)]
    stated = np.sqrt(np.median([weights @ each @ weights for each in covariances]))
    assert stated == pytest.approx(0.05 / np.sqrt(rows), rel=0.25)


def test_a_common_drift_cancels_in_a_difference_of_neighbours():
    rng = np.random.default_rng(2)
    rows = round(24 * DWELL * RATE)
    segments = segments_of(flicker(rng, rows, 1e-4) + rng.normal(0, 1e-3, (rows, 6)))
    covariance = covariance_of_means(fit_noise(segments), 0)
    difference = covariance[3, 3] + covariance[4, 4] - 2 * covariance[3, 4]
    far = covariance[0, 0] + covariance[-1, -1] - 2 * covariance[0, -1]
    assert difference < 0.6 * far
    assert np.linalg.eigvalsh(covariance).min() > -1e-12


def test_a_channel_rounded_to_one_code_has_an_uncertainty():
    rng = np.random.default_rng(3)
    rows = round(24 * DWELL * RATE)
    values = np.repeat(rng.normal(0.0, 1.0, (24, 6)), rows // 24, axis=0)
    segments = segments_of(np.round((values + rng.normal(0.0, 1e-3, (rows, 6))) / 0.1) * 0.1)
    noise = fit_noise(segments)
    least = 0.1 / np.sqrt(12.0 * DWELL * RATE)
    for channel in range(6):
        stated = np.sqrt(np.diag(covariance_of_means(noise, channel)))
        assert (stated >= 0.99 * least).all()


# Degrees of freedom of a type A uncertainty, against the scatter of repeated runs.


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
