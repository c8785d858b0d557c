"""Means that transmission errors do not spoil, and what one pass over a segment finds."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from schemas.recording import ACCEL, GYRO, Segment, Stream
from tasks.segments.summarise import (
    BLOCKS,
    ROWS,
    allan_variances,
    coarsely_quantised,
    extreme_steps,
    one_pass,
    steps,
    summarise,
)

# Means that transmission errors do not spoil.

HELD = Segment(name="held", kind="static", t_start=0.0, t_end=30.0, up="+z")


def stream(values: np.ndarray) -> Stream:
    columns = dict(zip(GYRO + ACCEL, values.T, strict=True))
    return Stream(np.round(np.arange(len(values)) * 0.01, 9), columns)


def noise(rows: int = 3000) -> np.ndarray:
    return np.random.default_rng(5).normal(0.0, 0.01, (rows, 6))


def test_a_clean_segment_loses_no_row():
    summary = summarise(stream(noise()), HELD, "label")
    assert (summary.rows, summary.left_out) == (3000, 0)
    assert np.allclose(summary.mean, noise().mean(axis=0))


def test_spikes_of_any_size_are_left_out_and_counted():
    spoiled = noise()
    spoiled[[10, 500, 2000], 4] = (1.06e5, -9.68, 0.3)
    summary = summarise(stream(spoiled), HELD, "label")
    assert summary.left_out == 3
    assert summary.far_rows.tolist() == [0, 0, 0, 0, 3, 0]
    assert np.abs(summary.mean).max() < 0.001


@settings(max_examples=30)
@given(
    st.lists(st.integers(0, 2999), min_size=1, max_size=55, unique=True),
    st.floats(1.0, 1e6),
)
@example([0, 165, 195, 285, 2085], 2.0)  # every one a row of the first glance
@example(list(range(0, 3000, 60)), 1.0)
@example(list(range(1000, 1050)), 1.0)
def test_even_a_fiftieth_of_corrupted_rows_does_not_move_the_mean(rows, size):
    spoiled = noise()
    spoiled[rows, 1] += size
    summary = summarise(stream(spoiled), HELD, "label")
    assert np.abs(summary.mean).max() < 0.002


def test_rare_codes_are_kept_where_a_correction_hides_the_step():
    """A twentieth of the rows reads the next code; what was taken off follows the time."""
    values = np.where(np.random.default_rng(8).random((3000, 6)) < 0.05, 0.02, 0.0)
    values += 1e-7 * np.linspace(0.0, 1.0, 3000)[:, None]
    assert summarise(stream(values), HELD, "label").left_out == 0


def test_what_lies_beside_many_spikes_is_kept():
    """One burst of 36 rows, and 22 spikes: with as much on both sides of each, more than half."""
    spoiled = noise()
    spoiled[1050:1086, 0] += 5.0
    spoiled[range(20, 3000, 140), 0] += 5.0
    summary = summarise(stream(spoiled), HELD, "label")
    assert summary.left_out == 36 + 22
    assert np.abs(summary.mean).max() < 0.002


def test_a_long_disturbance_is_told_from_a_corrupted_row():
    spoiled = noise()
    spoiled[2900:2940, 3] += np.linspace(0.5, 2.0, 40)
    summary = summarise(stream(spoiled), HELD, "label")
    assert summary.longest_burst >= 40
    assert summary.left_out >= 40


def test_a_triad_that_was_not_recorded_is_not_a_number_and_spoils_nothing():
    values = noise()
    values[:, :3] = np.nan
    summary = summarise(stream(values), HELD, "label")
    assert not summary.has_gyro
    assert summary.has_accel
    assert summary.left_out == 0


def test_a_segment_without_rows_has_no_summary():
    late = HELD.model_copy(update={"t_start": 100.0, "t_end": 130.0})
    assert summarise(stream(noise()), late, "label") is None


def test_allan_variance_of_white_noise_falls_with_the_block_length():
    values = np.random.default_rng(1).normal(0.0, 1.0, (320_000, 6))
    variances, tau = allan_variances(one_pass(list(values.T)).blocks, 3200.0)
    expected = 0.01 / tau  # unit variance at 100 Hz
    assert np.allclose(variances[:3].mean(axis=1), expected[:3], rtol=0.3)


def rounded(sigma: float, level: float = 0.0) -> np.ndarray:
    """Noise of `sigma` steps about a level, rounded to steps of 0.01."""
    noise = np.random.default_rng(5).normal(level, sigma, (3000, 6))
    return np.round(noise) * 0.01


def test_rare_neighbouring_codes_are_no_corrupted_rows():
    values = rounded(0.2)
    summary = summarise(stream(values), HELD, "label")
    assert 0 < np.count_nonzero(values[:, 0]) < 0.02 * len(values)
    assert summary.left_out == 0
    assert np.allclose(summary.step, 0.01)


def test_a_spike_on_a_rounded_channel_is_left_out():
    values = rounded(0.2)
    values[1000, 2] = 0.07
    assert summarise(stream(values), HELD, "label").far_rows.tolist() == [0, 0, 1, 0, 0, 0]


@settings(max_examples=30)
@given(st.floats(0.0, 1.0), st.floats(0.05, 1.5))
def test_a_step_of_more_than_two_standard_deviations_is_coarse(level, sigma):
    summary = summarise(stream(rounded(sigma, level)), HELD, "label", np.full(6, 0.01))
    if not 0.45 < sigma < 0.55:
        assert (coarsely_quantised(summary) == (sigma < 0.5)).all()


def test_a_channel_without_steps_is_not_coarse():
    values = noise()
    values[:, :3] = np.nan
    values[:, 3] = 1.0
    assert steps(stream(values))[:4].tolist() == [0.0] * 4
    assert not coarsely_quantised(summarise(stream(values), HELD, "label")).any()


# Extremes taken piece by piece are those of the whole.


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


# Channels read once say what numpy says of the whole.

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
