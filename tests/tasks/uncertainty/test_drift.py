"""Drift that is slower than a segment: stated uncertainties against simulated recordings."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest

from schemas.recording import Segment
from tasks.segments.summarise import BLOCKS, SegmentMean, allan_variances
from tasks.uncertainty.drift import WALK, drift_shapes
from tasks.uncertainty.type_a import covariance_of_means, fit_noise

DWELL = 30.0
TAU = DWELL / BLOCKS  # s between the simulated block means
GAP = 4  # blocks between two segments
WHITE = 4e-8  # unit²·s
RUNS = 30  # of six channels each

Process = Callable[[np.random.Generator, int], np.ndarray]


def labels() -> list[Segment]:
    """Twelve positions, and ten rates between two rests about each axis."""
    fields: list[dict] = []
    for axis, sign, turn in product("xyz", "+-", (0, 180)):
        fields.append({"kind": "static", "up": sign + axis, "turn_deg": turn})
    for axis in "xyz":
        rest = {"kind": "static", "up": f"+{axis}", "item": "rate_sensitivity"}
        rates = [
            {"kind": "rate", "axis": axis, "up": f"+{axis}", "rate_deg_s": rate}
            for rate in (-300, -200, -100, -50, -10, 10, 50, 100, 200, 300)
        ]
        fields += [rest, *rates, rest]
    period = DWELL + GAP * TAU
    return [
        Segment(name=f"s{i}", t_start=i * period, t_end=i * period + DWELL, **label)
        for i, label in enumerate(fields)
    ]


def segments_of(blocks: np.ndarray, held: list[Segment]) -> tuple[SegmentMean, ...]:
    """Summaries from block means (6, n), TAU apart."""
    summaries = []
    for i, label in enumerate(held):
        values = blocks[:, i * (BLOCKS + GAP) :][:, :BLOCKS]
        allan, tau = allan_variances(values, DWELL)
        summaries.append(SegmentMean(
            segment=label, origin="label", rows=3000, t_start=label.t_start, t_end=label.t_end,
            mean=values.mean(axis=1), blocks=values, allan=allan, tau=tau, left_out=0,
            far_rows=np.zeros(6), longest_burst=0, step=np.zeros(6), deviation=values.std(axis=1),
            intervals=(0.01, 0.01), place=slice(0, 3000),
        ))  # fmt: skip
    return tuple(summaries)


def nothing(rng: np.random.Generator, count: int) -> np.ndarray:
    return np.zeros((6, count))


def weak_flicker(rng: np.random.Generator, count: int) -> np.ndarray:
    """1/f noise, h a fourteenth of the variance that white noise gives one segment mean.

    Eight times as long as asked, so that it also wanders slower than what is used of it.
    """
    long = 8 * count
    frequency = np.fft.rfftfreq(long, TAU)
    frequency[0] = np.inf
    amplitude = np.sqrt(1e-10 / frequency / TAU * long / 4)
    phases = rng.normal(size=(2, 6, len(frequency)))
    return np.fft.irfft(amplitude * (phases[0] + 1j * phases[1]), long)[:, :count]


def random_walk(rng: np.random.Generator, count: int) -> np.ndarray:
    walk = np.cumsum(rng.normal(0.0, 3e-6 * np.sqrt(TAU), (6, count)), axis=1)
    return walk - walk.mean(axis=1, keepdims=True)


def trend(rng: np.random.Generator, count: int) -> np.ndarray:
    return np.tile(2e-4 * (np.arange(count) / count - 0.5), (6, 1))


def warming_up(rng: np.random.Generator, count: int) -> np.ndarray:
    decay = np.exp(-np.arange(count) * TAU / 300.0)
    return np.tile(2e-4 * (decay - decay.mean()), (6, 1))


@cache
def scores(process: Process, runs: int = RUNS) -> tuple[np.ndarray, np.ndarray]:
    """Errors over stated standard uncertainties, of the bias and of a slope over rate points."""
    held = labels()
    bias = np.array([label.turn_deg is not None for label in held]) / 12.0
    slope = np.array([label.rate_deg_s or 0.0 if label.axis == "y" else 0.0 for label in held])
    count = len(held) * (BLOCKS + GAP)
    found = []
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        blocks = rng.normal(0.0, np.sqrt(WHITE / TAU), (6, count)) + process(rng, count)
        segments = segments_of(blocks, held)
        noise, means = fit_noise(segments), np.array([s.mean for s in segments])
        for channel in range(6):
            covariance = covariance_of_means(noise, channel)
            found.append([
                w @ means[:, channel] / np.sqrt(w @ covariance @ w) for w in (bias, slope)
            ])  # fmt: skip
    return np.array(found)[:, 0], np.array(found)[:, 1]


@pytest.mark.parametrize("process", [nothing, weak_flicker, random_walk, trend, warming_up])
def test_a_bias_lies_within_its_stated_uncertainty(process):
    bias, _ = scores(process)
    if process in (trend, warming_up):
        # What so quiet an accelerometer gains while it lies flat hides under the tilt of each face,
        # which its bias has a line of its own for.
        bias = bias.reshape(-1, 6)[:, :3].ravel()
    # One who always walks is met as often as one who never does: see the next test.
    assert np.mean(np.abs(bias) < 2.0) >= (0.88 if process is random_walk else 0.93)
    assert np.sqrt(np.mean(bias**2)) > 0.4  # nor is it stated at random


def test_biases_of_units_of_which_half_walk_lie_within_their_stated_uncertainty():
    bias = np.concatenate([scores(process)[0] for process in (nothing, random_walk)])
    assert 0.93 <= np.mean(np.abs(bias) < 2.0) <= 0.98


def test_what_each_rate_point_is_tilted_for_itself_is_not_taken_for_drift():
    held, rng = labels(), np.random.default_rng(5)
    blocks = rng.normal(0.0, np.sqrt(WHITE / TAU), (6, len(held) * (BLOCKS + GAP)))
    tilted = blocks.copy()
    for i, label in enumerate(held):
        if label.kind == "rate":
            across = [c for c in range(3) if "xyz"[c] != label.axis]
            seconds_of_arc = rng.uniform(-5.0, 5.0, 2)
            rate = np.radians(label.rate_deg_s or 0.0)
            at = slice(i * (BLOCKS + GAP), (i + 1) * (BLOCKS + GAP))
            tilted[across, at] += rate * np.radians(seconds_of_arc / 3600.0)[:, None]
    bias = np.array([label.turn_deg is not None for label in held]) / 12.0
    u = [
        np.sqrt([bias @ covariance_of_means(noise, c) @ bias for c in range(3)])
        for noise in (fit_noise(segments_of(b, held)) for b in (blocks, tilted))
    ]
    assert np.all(u[1] < 1.5 * u[0])


@pytest.mark.parametrize("process", [nothing, weak_flicker, random_walk, trend])
def test_a_slope_over_rate_points_scatters_as_stated(process):
    _, slope = scores(process)
    # A strong walk between few points is not quite seen: nine in ten.
    assert np.mean(np.abs(slope) < 2.0) >= (0.88 if process is random_walk else 0.92)
    assert 0.6 < np.sqrt(np.mean(slope**2)) < 1.25


def test_what_the_inputs_give_is_not_drift():
    """Rates, gravity, tilt and an uneven line about the own axis are far above the noise."""
    held = labels()
    rng = np.random.default_rng(1)
    blocks = rng.normal(0.0, np.sqrt(WHITE / TAU), (6, len(held) * (BLOCKS + GAP)))
    plain = fit_noise(segments_of(blocks, held)).drift
    for i, label in enumerate(held):
        reads = np.zeros(6)
        up, sign = "xyz".index(label.up[1]), 1.0 if label.up[0] == "+" else -1.0
        reads[3 + up] += 9.8 * sign
        reads[:3] += 1e-3 * sign * (up + 1)
        flat = [channel for channel in range(6) if channel % 3 != up]
        reads[flat] += 1e-3 * np.cos(np.radians(label.turn_deg or 0.0)) * (label.kind == "static")
        rate = np.radians(label.rate_deg_s or 0.0)
        reads[:3] += 1e-3 * rate
        reads[3:] += 1e-2 * rate**2
        if label.axis is not None:
            reads["xyz".index(label.axis)] += rate + 1e-3 * rate**3
        blocks[:, i * (BLOCKS + GAP) :][:, :BLOCKS] += reads[:, None]
    assert np.allclose(fit_noise(segments_of(blocks, held)).drift, plain, rtol=1e-3, atol=1e-20)


def test_a_wrong_label_is_no_drift_where_the_rate_is_known():
    held = labels()
    rng = np.random.default_rng(2)
    blocks = rng.normal(0.0, np.sqrt(WHITE / TAU), (6, len(held) * (BLOCKS + GAP)))
    segments = segments_of(blocks, held)
    up = tuple(label.up for label in held)
    rate = np.array([np.radians(label.rate_deg_s or np.nan) for label in held])
    wrong = [
        label.model_copy(update={"rate_deg_s": 77.0}) if label.kind == "rate" else label
        for label in held
    ]
    known = fit_noise(segments_of(blocks, wrong), up, rate)
    assert np.allclose(known.drift, fit_noise(segments).drift)


def test_a_random_walk_is_counted_about_the_mean_of_the_run():
    segments = segments_of(np.zeros((6, 48 * (BLOCKS + GAP))), labels())
    rng = np.random.default_rng(0)
    walk = np.cumsum(rng.normal(0.0, np.sqrt(TAU), (4000, 48 * (BLOCKS + GAP) - GAP)), axis=1)
    walk -= walk.mean(axis=1, keepdims=True)
    first, last = walk[:, :BLOCKS].mean(axis=1), walk[:, -BLOCKS:].mean(axis=1)
    covariance = drift_shapes(segments)[WALK]
    assert covariance[0, 0] == pytest.approx(np.mean(first**2), rel=0.1)
    assert covariance[0, -1] == pytest.approx(np.mean(first * last), rel=0.15)


def test_a_segment_of_one_row_spoils_no_other():
    held = labels()
    rng = np.random.default_rng(3)
    segments = segments_of(rng.normal(0.0, 1e-3, (6, len(held) * (BLOCKS + GAP))), held)
    short = replace(
        segments[20], rows=1, t_end=segments[20].t_start, allan=np.zeros((0, 6)), tau=np.zeros(0)
    )
    segments = (*segments[:20], short, *segments[21:])
    covariance = covariance_of_means(fit_noise(segments), 4)
    others = np.delete(np.delete(covariance, 20, axis=0), 20, axis=1)
    assert np.linalg.eigvalsh(others).min() > 0
