"""A line that dominates a plain fit's residual goes before a search; the motion's own stay."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.explain.events.detect import events_in_readings, events_in_residual
from tasks.motion.pose import Tracking
from tasks.motion.whole import Motion

RATE, PERIOD = 100.0, 1.107  # Hz; s of one turn there and back
DELAY, HUM = 0.012, 9.5945  # s, Hz
SIGMA = np.array([1e-3] * 3 + [5e-3] * 3)


def _speed(t: np.ndarray) -> np.ndarray:
    """rad/s of a shaft that turns to and fro."""
    return 5.6 * np.tanh(12.0 * np.sin(2 * np.pi * t / PERIOD))


def _motion(t: np.ndarray) -> Motion:
    rate = np.zeros((len(t), 3))
    rate[:, 2] = _speed(t)
    up = np.tile([0.0, 0.0, 1.0], (len(t), 1))
    return Motion(t, up, np.zeros_like(rate), rate, np.gradient(rate, t, axis=0), 9.8)


def _readings(t: np.ndarray, hum: float) -> np.ndarray:
    """Of a unit whose clock is late, on a rig that hums at HUM with an amplitude in rad/s."""
    readings = SIGMA * np.random.default_rng(3).standard_normal((len(t), 6))
    readings[:, 2] += _speed(t - DELAY) + hum * np.cos(2 * np.pi * HUM * t + 0.4)
    readings[:, 5] += 9.8
    return readings


@pytest.mark.parametrize("jitter", [0.0, 4e-3])
def test_a_hum_that_dominates_is_found_beside_the_lines_of_a_late_clock(jitter: float) -> None:
    t = np.arange(12_000) / RATE
    t += jitter * (np.random.default_rng(8).random(len(t)) - 0.5)
    t = np.round(t, 3)  # s, as a logger writes it
    events = events_in_readings(_readings(t, 2.3), _motion(t))
    assert events.lines == pytest.approx((HUM,), abs=1e-4)
    (line,) = [each for each in events.events if each.effect == "unnamed"]
    sizes = {each.name: each.value for each in line.parameters}
    assert sizes["gyro_z"] == pytest.approx(2.3, rel=0.01)


def test_what_a_late_clock_leaves_of_a_periodic_motion_is_no_line() -> None:
    t = np.arange(12_000) / RATE
    assert events_in_readings(_readings(t, 0.0), _motion(t)).lines == ()


def test_what_a_lever_arm_makes_of_a_periodic_motion_is_no_line() -> None:
    t = np.arange(12_000) / RATE
    motion, readings = _motion(t), _readings(t, 0.0)
    readings[:, 3] -= 0.08 * motion.rate[:, 2] ** 2
    readings[:, 4] += 0.08 * motion.acceleration[:, 2]
    assert events_in_readings(readings, motion).lines == ()


def test_poses_do_not_show_how_a_body_hums() -> None:
    t = np.arange(12_000) / RATE
    tracked = replace(_motion(t), tracking=Tracking(8.0, 8.0, 0.01, 1e-8, 1e-8))
    assert events_in_readings(_readings(t, 2.3), tracked).lines == ()


def test_a_line_removed_before_is_found_again_beside_the_fit() -> None:
    t = np.arange(12_000) / RATE
    motion, readings = _motion(t), _readings(t, 2.3)
    late = np.column_stack([0 * t, 0 * t, _speed(t - DELAY)])
    predicted = np.hstack([late, 9.8 * motion.up])
    others = events_in_readings(readings, motion).without_added()
    after = events_in_residual(others, readings - others.applied(t, predicted), SIGMA, motion)
    assert others.lines == ()
    assert len(after.lines) == 1
    rest = readings - after.applied(t, predicted)
    assert rest[:, 2].std() < 1.1 * SIGMA[2]
