"""A clean unit that is read a few times a second has no mismatch, beside encoders and labels."""

import numpy as np
import pytest
from logged import Unit, procedure, read, recorded

from tasks.explain.explain import explain
from tasks.words import say

CASES = [
    (0.5, 0.5, {"rest": 20.0, "hold": 16.0, "move": 6.0, "ramp": 2.0}, True),
    (1.0, 1.0, {"rest": 10.0, "hold": 12.0}, True),
    (1.0, 1.0, {"rest": 30.0, "hold": 20.0, "rates": (5.0, -5.0, 30.0, -30.0)}, True),
    (2.0, 2.0, {"rest": 12.0, "ramp": 0.5}, True),
    (2.5, 2.5, {"rest": 15.0, "rates": (20.0, -20.0, 60.0, -60.0)}, True),
    (3.0, 3.0, {}, True),
    (4.0, 4.0, {"hold": 6.0, "ramp": 2.0}, True),
    (5.0, 5.0, {}, True),
    (5.0, 50.0, {}, True),
    (1.0, 1.0, {"rest": 10.0, "hold": 10.0}, False),
    (2.0, 2.0, {"rest": 10.0, "hold": 10.0}, False),
    (5.0, 5.0, {}, False),
]


# Each is a whole search; the others stand in a rehearsal.
@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, marks=[] if case in (1, 8, 9) else pytest.mark.rehearsal)
        for case in range(len(CASES))
    ],
)
@pytest.mark.filterwarnings("default::RuntimeWarning")
def test_a_clean_unit_that_is_read_slowly_has_no_mismatch(case):
    rate, of_table, how, has_table = CASES[case]
    course, rng = procedure(**how), np.random.default_rng(100 + case)
    at = np.arange(0.0, course.until, 1.0 / rate)
    readings = read(course, at, Unit(turns_with_earth=False), rng)
    found = explain(recorded("slow", course, at, readings, table_rate=of_table, table=has_table))
    assert found.verdict == "no_mismatch"
    slow = has_table and of_table < 6.0
    assert any("too slowly" in say(each, "en") for each in found.remarks) is slow
