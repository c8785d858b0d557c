"""What of a search stands, and known physics that stands though it is absorbed."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import GRAVITY, NOISY, motion, noise, read, selected

from tasks.explain.evidence.evidence import absorbed, pruned
from tasks.explain.explanation import CERTAIN
from tasks.explain.inputs.blocks import Blocks
from tasks.explain.noise import Noise
from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.stepwise import Selected
from tasks.model.terms.environment import TEMPERATURE_BIAS
from tasks.model.terms.geometry import LEVER_ARM, STRUCTURAL_COMPLIANCE
from tasks.model.terms.site import earth_rotation
from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import Motion

# Earth's rotation on a unit in two positions, where g-sensitivity leaves no residual of it.

RATE, SECONDS = 25.0, 120.0
EARTH = earth_rotation(np.radians(51.0))
KNOWN = Candidate(EARTH, (0,), (0,), 1)
VERTICAL = EARTH_RATE * np.sin(np.radians(51.0))  # rad/s
FINE, COARSE = 1e-5, 2e-2  # standard deviation of a block: a ring laser, a poor unit; rad/s


def two_positions() -> Motion:
    """x upwards for half of the time, then downwards; north is not known."""
    t = np.arange(0.0, SECONDS, 1.0 / RATE)
    up = np.outer(np.where(t < SECONDS / 2, 1.0, -1.0), [1.0, 0.0, 0.0])
    zero = np.zeros_like(up)
    return Motion(t, up, np.full_like(up, np.nan), zero, zero, GRAVITY)


def unit(sigma: float, sensitivity: float, seed: int = 0) -> tuple[Blocks, tuple[Noise, ...]]:
    """A unit at rest whose x gyro follows gravity: sensitivity, rad/s and g, all of it."""
    run = two_positions()
    rng = np.random.default_rng(seed)
    readings = np.hstack([np.zeros((len(run.t), 3)), run.force])
    readings[:, 0] += 1e-4 + sensitivity * run.up[:, 0]
    readings += sigma * rng.standard_normal(readings.shape)
    noises = (Noise(sigma**2, 0.0),) * 6
    blocks = Blocks(
        run.t, readings, np.ones_like(readings), run, RATE,
        (run.t >= SECONDS / 2).astype(int), (), np.zeros(6),
    )  # fmt: skip
    return blocks, noises


def claimed(sigma: float, sensitivity: float, seed: int = 0) -> Selected | None:
    blocks, noises = unit(sigma, sensitivity, seed)
    return absorbed(KNOWN, blocks, noises)


def test_the_effect_is_that_of_the_vertical_part_where_north_is_not_known() -> None:
    (effect,) = columns_of(EARTH, two_positions())
    np.testing.assert_allclose(np.abs(effect[0]), VERTICAL, rtol=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_earth_is_claimed_where_the_reading_is_as_large_as_earths_rate(seed: int) -> None:
    one = claimed(FINE, VERTICAL, seed)
    assert one is not None
    assert one.candidate is KNOWN
    assert one.absorbed_by == "gyro_g_sensitivity"
    assert one.score >= CERTAIN
    assert one.gain > one.score


@pytest.mark.parametrize("seed", range(4))
def test_earth_is_not_claimed_where_noise_hides_it(seed: int) -> None:
    assert claimed(COARSE, VERTICAL, seed) is None


@pytest.mark.parametrize("share", [0.0, -1.0, 0.5, 0.95, 1.05, 2.0, 10.0])
def test_earth_is_not_claimed_where_the_sensitivity_is_another(share: float) -> None:
    assert claimed(FINE, share * VERTICAL) is None


def test_without_a_change_of_attitude_nothing_is_claimed() -> None:
    blocks, noises = unit(FINE, VERTICAL)
    first = blocks.motion.t < SECONDS / 2
    rested = replace(
        blocks, t=blocks.t[first], motion=blocks.motion.taken(first),
        readings=blocks.readings[first], weight=blocks.weight[first], segment=blocks.segment[first],
    )  # fmt: skip
    assert absorbed(KNOWN, rested, noises) is None


def test_findings_of_nothing_but_noise_are_removed_one_after_another() -> None:
    run = motion()
    made = read(run) + noise(len(run.t), 73, NOISY)
    fit = selected(made, LEVER_ARM, TEMPERATURE_BIAS, STRUCTURAL_COMPLIANCE)
    assert pruned(fit, 300).groups == ()
    assert [one.name for one in pruned(fit, 300, ["lever_arm"]).groups] == ["lever_arm"]
