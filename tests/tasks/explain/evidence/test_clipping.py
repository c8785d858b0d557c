"""Clipping that a run cannot tell from scale factors that bend."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from engine_run import motion

from tasks.explain.evidence.clipping import possibly_clipped, possibly_clipped_in_noise
from tasks.motion.whole import Motion

NONLINEAR = "gyro_scale_nonlinearity"
RUN = motion()
TOP = 2.0  # rad/s
SWINGING = replace(RUN, rate=np.outer(TOP * np.sin(0.7 * RUN.t), [0.0, 0.2, 1.0]))
STILL = np.zeros((len(RUN.t), 6))


def held_at(*rates: float) -> Motion:
    """Rates (rad/s) about z, each held for half a minute, with ramps of two seconds between."""
    corners = np.cumsum([0.0, *(each for _ in rates for each in (2.0, 30.0, 2.0, 5.0))])
    sizes = np.concatenate([[0.0], *([rate, rate, 0.0, 0.0] for rate in rates)])
    rate = np.zeros((len(RUN.t), 3))
    rate[:, 2] = np.interp(RUN.t, corners, sizes)
    return replace(RUN, rate=rate, acceleration=np.gradient(rate, RUN.t, axis=0))


@pytest.mark.parametrize(
    ("rates", "open_"),
    [((2.0, -2.0), True), ((2.0, -2.0, 0.3), True), ((2.0, -2.0, 1.2), False), ((2.0, 1.0), False)],
)
def test_clipping_is_possible_where_one_size_of_rate_was_held(
    rates: tuple[float, ...], open_: bool
) -> None:
    names = possibly_clipped(NONLINEAR, (2, 5), held_at(*rates))
    assert names == (("gyro_saturation",) if open_ else ())


def test_only_a_bent_scale_factor_may_be_clipping() -> None:
    assert possibly_clipped("gyro_g2_sensitivity", (2,), held_at(2.0, -2.0)) == ()
    assert possibly_clipped(NONLINEAR, (3, 4), held_at(2.0, -2.0)) == ()


def added(motion: Motion, channel: int, change: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    contribution = np.zeros((len(motion.t), 6))
    contribution[:, channel] = change(motion.rate[:, channel])
    return contribution


@pytest.mark.parametrize(
    ("change", "clipped"),
    [
        (lambda rate: -np.maximum(rate - 0.9 * TOP, 0.0), True),
        (lambda rate: np.maximum(-rate - 0.9 * TOP, 0.0) + 1e-3 * rate, True),
        (lambda rate: 1e-3 * rate**2, False),
        (lambda rate: 1e-3 * rate**3, False),
        (lambda rate: 1e-3 * np.abs(rate), False),
        (lambda rate: 1e-3 * np.sin(3.0 * rate), False),
    ],
)
def test_a_bend_at_one_end_alone_may_be_clipping(
    change: Callable[[np.ndarray], np.ndarray], clipped: bool
) -> None:
    names = possibly_clipped_in_noise(NONLINEAR, added(SWINGING, 2, change), STILL, SWINGING)
    assert names == (("gyro_saturation",) if clipped else ())


@pytest.mark.parametrize(("limit", "clipped"), [(9.80, True), (9.95, False)])
def test_noise_that_is_cut_off_at_an_end_may_be_clipping(limit: float, clipped: bool) -> None:
    """Six positions: at one g, none and minus one g any bend is a parabola."""
    count = len(RUN.t)
    up = np.zeros((count, 3))
    up[:, 0] = np.sign(np.sin(6.0 * np.pi * np.arange(count) / count)).round()
    up[np.arange(count) % 900 < 300] = [0.0, 0.0, 1.0]
    resting = replace(RUN, rate=np.zeros((count, 3)), acceleration=np.zeros((count, 3)), up=up)
    force = resting.force[:, 0]
    readings = np.zeros((count, 6))
    readings[:, 3] = force + 0.02 * np.random.default_rng(3).standard_normal(count)
    readings[:, 3] = np.minimum(readings[:, 3], limit)
    bend = np.zeros((count, 6))
    bend[:, 3] = 1e-5 * force**2
    names = possibly_clipped_in_noise("accel_nonlinearity", bend, readings, resting)
    assert names == (("accel_saturation",) if clipped else ())


def test_what_bends_no_scale_factor_is_no_clipping() -> None:
    clipped = added(SWINGING, 2, lambda rate: -np.maximum(rate - 0.9 * TOP, 0.0))
    assert possibly_clipped_in_noise("temperature_scale", clipped, STILL, SWINGING) == ()
    assert possibly_clipped_in_noise(NONLINEAR, STILL, STILL, SWINGING) == ()
