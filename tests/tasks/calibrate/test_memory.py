"""What a calibration takes of memory beside the readings hardly grows with their number."""

import tracemalloc
from functools import partial

from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf2003 import JJF2003
from tests.bench.recordings import recording

ROWS = (50_000, 300_000)


def taken(rows: int) -> int:
    work = partial(calibrate, JJF2003, recording(rows), run="", code_version="")
    work()  # imports and caches are not the readings'
    tracemalloc.start()
    work()
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return most


def test_more_rows_take_less_than_a_copy_of_one_more_column():
    short, long = map(taken, ROWS)
    assert long - short < 0.8 * 8 * (ROWS[1] - ROWS[0])
