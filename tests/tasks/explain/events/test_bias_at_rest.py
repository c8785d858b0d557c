"""A bias that the firmware follows at rest is found with its constants; a warm-up is not."""

import numpy as np
import pytest
from made_up import mean_readings, motion, noisy

from tasks.explain.events.bias_at_rest import find_bias_at_rest

MADE = motion(minutes=2.0)
INTERVAL = float(np.median(np.diff(MADE.t)))


def followed(readings: np.ndarray, quiet: float, wait: float, tau: float) -> np.ndarray:
    """What a firmware writes that follows the gyros' bias while no rate exceeds `quiet`."""
    written, bias, quiet_for = readings.copy(), np.zeros(3), 0.0
    for row, rates in enumerate(readings[:, :3]):
        quiet_for = quiet_for + INTERVAL if np.all(np.abs(rates - bias) < quiet) else 0.0
        if quiet_for > wait:
            bias = bias + (rates - bias) * INTERVAL / (tau + INTERVAL)
        written[row, :3] = rates - bias
    return written


@pytest.mark.parametrize(("quiet", "wait", "tau"), [(0.05, 1.0, 0.8), (0.03, 0.6, 2.0)])
def test_a_bias_followed_at_rest_is_found_and_put_back(
    quiet: float, wait: float, tau: float
) -> None:
    readings = noisy(mean_readings(MADE), 1)
    written = followed(readings, quiet, wait, tau)
    event = find_bias_at_rest(written, MADE)
    assert event is not None
    assert {one.name: one.value for one in event.parameters}["tau"] == pytest.approx(tau, rel=0.2)
    put_back = written - event.applied(MADE.t, np.zeros(written.shape))
    lost = np.abs(readings - written)[:, :3].max()
    assert np.abs(put_back - readings)[:, :3].max() < 0.2 * lost


@pytest.mark.parametrize("tau", [2.0, 20.0, 60.0])
def test_a_bias_that_warms_up_is_not_one_followed_at_rest(tau: float) -> None:
    readings = noisy(mean_readings(MADE), 3)
    readings[:, :3] += np.array([6e-3, -4e-3, 2e-3]) * np.exp(-MADE.t / tau)[:, None]
    assert find_bias_at_rest(readings, MADE) is None


def test_a_step_after_one_quiet_moment_is_no_firmware() -> None:
    """All gyros read little for 0.4 s by chance, and their bias steps there: no estimate follows
    a bias within the little that is left of that beyond the wait.
    """
    rng = np.random.default_rng(5)
    readings = mean_readings(MADE) + rng.standard_normal((len(MADE.t), 6)) * 0.02
    moment = (MADE.t >= 62.0) & (MADE.t < 62.4)
    readings[moment, :3] = 0.003 + 1e-4 * rng.standard_normal((np.count_nonzero(moment), 3))
    readings[MADE.t >= 62.4, :3] -= 0.01
    assert find_bias_at_rest(readings, MADE) is None
