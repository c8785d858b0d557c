"""A clock that was set back while a logger wrote."""

import numpy as np
import pytest

from storage.formats.logger.units import running_on


@pytest.mark.parametrize("back", [0.5, 1.0, 3600.0])
@pytest.mark.parametrize("rate", [10.0, 100.0, 1000.0])
def test_a_clock_that_was_set_back_runs_on(back, rate):
    taken = np.arange(3000) / rate
    stamps = taken - back * (taken > 1.0) - 0.6 * back * (taken > 2.0)
    running, rows = running_on(stamps)
    assert running == pytest.approx(taken, abs=1e-9)
    assert rows.tolist() == (np.flatnonzero(np.diff(stamps) < 0.0) + 1).tolist()


def test_a_clock_that_runs_is_left_alone():
    t = np.arange(100) / 50.0
    running, rows = running_on(t)
    assert running is t
    assert not len(rows)


@pytest.mark.parametrize("misplaced", [[50], [50, 700, 1200], list(range(10, 2900, 7))])
def test_rows_out_of_their_order_are_no_clock_that_was_set_back(misplaced):
    t = np.arange(3000) / 50.0
    t[misplaced] -= 0.5
    running, rows = running_on(t)
    assert running is t
    assert not len(rows)
