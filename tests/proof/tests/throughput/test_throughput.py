"""Two seconds of a fast unit; the command has ten minutes of eight, and one ten times faster."""

import pytest

from tests.proof.throughput.run import run_all


@pytest.mark.rehearsal
@pytest.mark.real_time
def test_no_frame_of_a_fast_unit_is_lost():
    held = run_all(1, 5000.0, 2.0)
    assert held.holds
    assert held.most("rows") > 5000.0 * 2.0
    assert held.most("seconds") > 2.0
