"""Blocks: the same edges for those who predict and those who score."""

import numpy as np
import pytest

from schemas.recording import Recording
from tasks.explain.inputs import blocks
from tasks.explain.inputs.full_rate import full_rate
from tests.proof.peers.blocks import BLOCK_RATE, block_means, block_numbers


@pytest.mark.parametrize("lost", [slice(0, 0), slice(400, 407)])
def test_blocks_are_those_that_explain_makes(clean: Recording, lost: slice) -> None:
    full = full_rate(clean)
    observed = blocks.block_means(full, BLOCK_RATE)
    numbers = block_numbers(clean.imu.t)
    assert len(observed.t) == numbers[-1] + 1
    readings = block_means(full.readings, numbers, len(observed.t))
    used = observed.weight[:, 0] > 0
    np.testing.assert_allclose(readings[used], observed.readings[used], rtol=1e-12)
    kept = np.delete(clean.imu.t, lost)
    np.testing.assert_array_equal(block_numbers(kept), np.delete(numbers, lost))


def test_block_with_an_unknown_row_or_none_is_unknown() -> None:
    means = block_means(np.array([[1.0], [3.0], [np.nan]]), np.array([0, 0, 2]), 4)
    assert means[0, 0] == 2.0
    assert np.isnan(means[1:]).all()
