"""Extremes taken piece by piece are those of the whole."""

import numpy as np
import pytest

from tasks.segments.summarise import ROWS, extreme_steps


@pytest.mark.parametrize("count", [2, ROWS - 1, ROWS, ROWS + 1, ROWS + 2, 3 * ROWS + 7])
def test_extremes_are_those_of_the_whole_wherever_they_lie(count):
    values = np.random.default_rng(count).normal(size=count)
    steps = np.diff(values)
    assert extreme_steps(values) == (steps.min(), steps.max())


def test_a_step_between_two_pieces_is_seen():
    t = np.arange(3.0 * ROWS)
    t[2 * ROWS :] += 5.0
    assert extreme_steps(t) == (1.0, 6.0)


@pytest.mark.parametrize("place", [0, ROWS, 2 * ROWS - 1])
def test_nan_anywhere_leaves_no_extremes(place):
    values = np.ones(2 * ROWS)
    values[place] = np.nan
    assert np.isnan(extreme_steps(values)).all()
