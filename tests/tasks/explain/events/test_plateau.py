"""Limits of a calibrated output: spread over many values, of one axis and side, and none else."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.motion.whole import Motion
from tests.tasks.explain.events.made_up import (
    GRAVITY,
    counted,
    found_in,
    mean_readings,
    motion,
    noisy,
    sizes,
)

MADE = motion(minutes=2.0)


def calibrated(clipped: np.ndarray, seed: int) -> np.ndarray:
    """What a calibration that follows the temperature makes of clipped codes: no two are alike."""
    t = MADE.t
    drift = 1.0 + 1e-3 * np.sin(t / 60.0) + 2e-4 * np.random.default_rng(seed).normal(size=len(t))
    return np.asarray(clipped * drift + 0.002)


def test_a_calibrated_limit_is_a_plateau_of_its_axis_and_side():
    readings = noisy(mean_readings(MADE), 1)
    readings[:, 2] = calibrated(np.clip(readings[:, 2], -4.4, 4.7), 2)
    events = found_in(readings, MADE)
    assert [event.effect for event in events.events] == ["gyro_saturation"]
    assert events.events[0].channels == (2,)
    assert sizes(events) == pytest.approx({"upper_limit_z": 4.7, "lower_limit_z": -4.4}, abs=0.02)


def test_a_plateau_is_masked_and_its_mean_predicted():
    made = MADE
    mean = mean_readings(made)
    readings = noisy(mean, 3)
    readings[:, 2] = calibrated(np.minimum(readings[:, 2], 4.5), 4)
    events = found_in(readings, MADE)
    beyond = mean[:, 2] > 4.6
    assert events.masked[beyond, 2].all()
    assert not events.masked[:, [0, 1, 3, 4, 5]].any()
    assert not events.masked[np.abs(mean[:, 2]) < 4.0].any()
    applied = events.applied(made.t, mean)
    assert (readings - applied)[beyond, 2] == pytest.approx(0.0, abs=0.02)
    assert np.array_equal(applied[mean[:, 2] < -4.0], mean[mean[:, 2] < -4.0])


def at_rest_in_six_positions() -> Motion:
    """Tipped from each position to the next in 2 s, at rest in it for 13 s."""
    made = MADE
    corners = np.array([[0, 0, 1], [0, 1, 0], [1, 0, 0], [0, 0, -1], [0, -1, 0], [-1, 0, 0]])
    turn, share = np.divmod(made.t / 15.0, 1.0)
    angle = 0.5 * np.pi * np.minimum(1.0, share * 15.0 / 2.0)[:, None]
    before, after = corners[turn.astype(int) % 6], corners[(turn.astype(int) + 1) % 6]
    up = np.cos(angle) * before + np.sin(angle) * after
    return replace(made, up=up, rate=np.zeros_like(made.rate))


def read_in_six_positions(seed: int) -> tuple[Motion, np.ndarray]:
    still = at_rest_in_six_positions()
    return still, noisy(np.hstack([still.rate, GRAVITY * still.up * 0.999]), seed)


def test_a_limit_just_below_gravity_is_told_by_one_position_alone():
    still, readings = read_in_six_positions(11)
    limit = 9.72 + 4e-3 * np.random.default_rng(12).standard_normal(len(still.t))
    readings[:, 4] = np.minimum(readings[:, 4], limit)
    (event,) = found_in(readings, still).events
    assert event.effect == "accel_saturation"
    assert {p.name: p.value for p in event.parameters} == pytest.approx(
        {"upper_limit_y": 9.72}, abs=0.01
    )


@pytest.mark.parametrize("order", [2, 3])
def test_accelerometers_that_bend_towards_gravity_have_no_plateau(order):
    still, readings = read_in_six_positions(13)
    readings[:, 4] -= 0.1 * np.maximum(still.up[:, 1], 0.0) ** order
    assert found_in(readings, still).events == ()


@pytest.mark.parametrize(("seed", "bend"), [(0, 0.0), (1, -0.03), (2, 0.03)])
def test_a_scale_factor_that_bends_is_no_plateau(seed, bend):
    mean = mean_readings(MADE)
    mean[:, :3] *= 1.0 + bend * (mean[:, :3] / 5.0) ** 2
    assert found_in(counted(noisy(mean, seed)), MADE).events == ()


def test_rests_in_gravity_are_no_plateau():
    made = MADE
    up = np.zeros_like(made.up)
    up[np.arange(len(up)), (np.arange(len(up)) // 2000) % 3] = 1.0
    still = replace(made, up=up, rate=np.zeros_like(made.rate))
    mean = np.hstack([still.rate, GRAVITY * still.up * 0.99 + 0.05])
    assert found_in(noisy(mean, 8), still).events == ()


def test_a_motion_that_dwells_at_its_highest_rate_before_a_noisy_encoder_is_no_plateau():
    made = motion(top=4.5)
    readings = noisy(mean_readings(made), 9)
    error = np.random.default_rng(10).normal(0.0, 0.05, len(made.t))
    dwelling = np.where(np.abs(made.rate[:, 2]) > 4.4, error, 0.1 * error)
    assert found_in(readings, with_rate_error(made, dwelling)).events == ()


def with_rate_error(made: Motion, error: np.ndarray) -> Motion:
    return replace(made, rate=made.rate + np.outer(error, [0.0, 0.0, 1.0]))
