"""Ends that settle or are torn are not used; drifts, ramps and single spikes are none of them."""

import numpy as np
import pytest
from made_up import mean_readings, motion, noisy

from tasks.explain.events.detect import events_in_readings
from tasks.explain.events.settling import find_settling
from tasks.words import texts

MADE = motion()
ROWS = len(MADE.t)


def readings() -> np.ndarray:
    return noisy(mean_readings(MADE), 1)


def test_ends_like_the_rest_are_used() -> None:
    masked, remarks = find_settling(readings(), MADE)
    assert not masked.any()
    assert remarks == ()


@pytest.mark.parametrize("tau", [0.01, 0.05, 0.1])
def test_a_filter_that_begins_empty_is_left_out_until_it_has_settled(tau: float) -> None:
    made = readings()
    made *= -np.expm1(-MADE.t / tau)[:, None]
    masked, (remark,) = find_settling(made, MADE)
    left = np.exp(-MADE.t / tau)[~masked.all(axis=1)]
    assert left.max() < 1e-3
    assert masked[:, 0].sum() * MADE.interval < 20.0 * tau
    assert not masked[ROWS // 2 :].any()
    assert all(texts(remark).values())


@pytest.mark.parametrize("row", [0, -1])
def test_one_torn_row_at_an_end_is_left_out(row: int) -> None:
    made = readings()
    made[row] = 0.0
    events = events_in_readings(made, MADE)
    assert events.masked[row].all()
    assert events.masked.sum() < 30
    assert len(events.remarks) == 1


def test_a_drift_that_is_fastest_at_the_start_is_used() -> None:
    made = readings()
    made += 0.05 * np.exp(-MADE.t / 20.0)[:, None]
    assert not find_settling(made, MADE)[0].any()


def test_readings_that_are_late_at_every_ramp_are_used() -> None:
    made = np.roll(readings(), 8, axis=0)
    made[:8] = made[8]
    assert not find_settling(made, MADE)[0].any()
