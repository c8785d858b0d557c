"""Where a lot happens and no logger erred, not one reading and not one stamp is moved."""

import numpy as np
import pytest
from eventful import eventful

from tasks.readings.codes import codes_put_right
from tasks.readings.stamps import with_instants

FEW, MANY = range(120), range(120, 1500)


def moved(seed: int) -> str:
    """What was moved in a recording; empty if nothing was."""
    recording, happens = eventful(seed)
    right = codes_put_right(with_instants(recording))
    wrong = [f"{one.channel} {one.bug} {one.share:.2g}" for one in right.wrong_codes]
    wrong += [] if np.array_equal(right.imu.t, recording.imu.t) else ["stamps"]
    same = all(
        np.array_equal(right.imu.columns[name], column, equal_nan=True)
        for name, column in recording.imu.columns.items()
    )
    return "" if same and not wrong else f"{seed}: {wrong} {happens}"


def test_nothing_is_moved_where_no_logger_erred():
    assert [each for each in map(moved, FEW) if each] == []


@pytest.mark.rehearsal
def test_nothing_is_moved_in_many_more():
    assert [each for each in map(moved, MANY) if each] == []
