"""Biases that change by themselves."""

import numpy as np
import pytest

from tasks.model.terms.memory import BIAS_RANDOM_WALK, bias_step, candidates
from tests.tasks.model.table_run import T, motion, read, recording

RUN = motion()


@pytest.mark.parametrize(("first", "count"), [(0, 3), (3, 3), (0, 6)])
def test_a_triad_or_all_channels_jump_once(first, count):
    term = bias_step(first, 10.0, count).shaped((4.0,))
    jump = 1e-3 * np.arange(1.0, count + 1.0)
    change = read((term,), jump) - read((), [])
    expected = np.zeros((len(T), 6))
    expected[T >= 4.0, first : first + count] = jump
    assert change == pytest.approx(expected, abs=1e-12)


def test_jumps_are_told_half_way_and_a_walk_has_no_parameter():
    terms = candidates(recording(), RUN)
    assert [t.at for t in terms if t.name == "bias_step"] == 3 * [(0.5 * T[-1],)]
    assert BIAS_RANDOM_WALK in terms
    assert not BIAS_RANDOM_WALK.parameters
