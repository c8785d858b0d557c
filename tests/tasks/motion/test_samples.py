"""Samples are near enough to say something, or what is between them is filled, or left out."""

import numpy as np
import pytest

from tasks.motion.samples import bridged, covered, first_order_lag, in_blocks


def test_lost_samples_and_slow_streams_are_no_gaps():
    slow = np.arange(0.0, 60.0, 1.0)
    slow = slow[(slow != 30.0) & (slow != 31.0)]
    assert covered(slow, np.array([0.0, 29.5, 30.4, 59.5])).all()
    even = np.arange(0.0, 20.0, 0.01)
    assert covered(even[::9], even).all()
    assert not covered(slow, np.array([-5.0, 65.0])).any()


def test_a_gap_is_bridged_by_a_straight_line_and_ends_go_on_level():
    gap = np.array([[np.nan, np.nan], [1.0, np.nan], [np.nan, np.nan], [3.0, np.nan]])
    np.testing.assert_array_equal(bridged(gap), [[1.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])


def test_blocks_leave_out_what_does_not_fill_one():
    assert in_blocks(np.arange(7), 3).tolist() == [[0, 1, 2], [3, 4, 5]]
    assert in_blocks(np.zeros((2, 6)), 3).shape == (0, 3, 6)


# A lag of first order, against its closed form.

STEP, TAU = 0.01, 0.5


def test_a_step_is_approached_with_the_time_constant():
    row = np.arange(1, 301)
    found = first_order_lag(np.ones(len(row)), STEP, TAU)
    assert found == pytest.approx(1.0 - np.exp(-row * STEP / TAU), abs=1e-12)


def test_what_was_in_balance_before_stays_so():
    assert first_order_lag(np.full(300, 7.0), STEP, TAU, start=7.0) == pytest.approx(7.0)
