"""Channels read once say what numpy says of the whole."""

import numpy as np
import pytest

from tasks.segments.summarise import BLOCKS, ROWS, one_pass

LENGTHS = [1, 2, 31, 33, 3000, ROWS + 1, BLOCKS * ROWS + 40, 2 * BLOCKS * ROWS + BLOCKS - 1]


def channels(rows: int) -> list[np.ndarray]:
    return list(np.random.default_rng(rows).normal(3.0, 1.0, (2, rows)))


@pytest.mark.parametrize("rows", LENGTHS)
def test_extremes_and_means_are_those_of_the_whole(rows):
    values = channels(rows)
    read = one_pass(values)
    assert read.low.tolist() == [channel.min() for channel in values]
    assert read.high.tolist() == [channel.max() for channel in values]
    assert read.mean == pytest.approx([channel.mean() for channel in values], rel=1e-12)


@pytest.mark.parametrize("rows", LENGTHS)
def test_blocks_are_of_one_length_and_leave_the_last_rows_to_the_mean(rows):
    values = channels(rows)
    blocks = one_pass(values).blocks
    count = blocks.shape[1]
    assert count == min(BLOCKS, 2 ** int(np.log2(rows)))
    size = rows // count
    expected = [c[: size * count].reshape(count, size).mean(axis=1) for c in values]
    assert blocks == pytest.approx(np.array(expected), rel=1e-12)


@pytest.mark.parametrize("rows", [3000, BLOCKS * ROWS + 40])
def test_what_comes_back_once_a_turn_is_told_from_the_noise(rows):
    turned = np.linspace(0.0, 17.0, rows)
    values = [2.0 + 0.5 * np.cos(turned) - 0.2 * np.sin(turned), np.full(rows, 7.0)]
    read = one_pass(values, lambda part: turned[part])
    assert read.blocks - read.periodic == pytest.approx(
        np.array([[2.0], [7.0]]).repeat(BLOCKS, axis=1), abs=1e-9
    )


def test_without_a_turn_nothing_is_periodic():
    assert not one_pass(channels(3000)).periodic.any()


def test_a_channel_that_was_not_recorded_has_no_extremes_and_spoils_no_other():
    values = [np.full(3000, np.nan), np.ones(3000)]
    read = one_pass(values, lambda part: np.linspace(0.0, 20.0, 3000)[part])
    assert np.isnan([read.low[0], read.high[0], read.mean[0]]).all()
    assert (read.low[1], read.high[1], read.mean[1]) == (1.0, 1.0, 1.0)
    assert read.periodic[1] == pytest.approx(0.0, abs=1e-12)
