"""Codes that were joined wrongly are put right; noise, steps and jumps of a bias are no fault."""

import numpy as np
import pytest
from made_up import SIGMA, mean_readings, motion, noisy
from tasks.explain.events.broken_codes import torn_codes

from tasks.explain.events.code_fault import CodeFault, find_code_fault
from tasks.words import texts

STEP = np.repeat([1.0 / 131.0 * np.pi / 180.0, 9.8 / 16384.0], 3)


MADE = motion(minutes=2.0, top=4.0)  # 30,000 codes either way


def codes(seed: int) -> np.ndarray:
    """Whole codes of a run with noise of some codes."""
    return np.round(noisy(mean_readings(MADE), seed) / STEP).astype(int)


def signed_low_byte(code: np.ndarray) -> np.ndarray:
    low = code & 0xFF
    return np.asarray((code - low) + np.where(low >= 128, low - 256, low))


def stuck(code: np.ndarray, bit: int) -> np.ndarray:
    return np.asarray(code & ~(1 << bit))


def sign_lost(code: np.ndarray) -> np.ndarray:
    return np.asarray(code & 0x7FFF)


def fault(faulty: np.ndarray) -> CodeFault | None:
    return find_code_fault(faulty * STEP, MADE)


@pytest.mark.parametrize("seed", range(3))
def test_right_codes_have_no_fault(seed: int) -> None:
    assert fault(codes(seed)) is None


@pytest.mark.parametrize("channel", [0, 2, 4])
def test_a_low_byte_taken_as_signed_is_put_right(channel: int) -> None:
    right = codes(1)
    faulty = right.copy()
    faulty[:, channel] = signed_low_byte(right[:, channel])
    found = fault(faulty)
    assert found is not None
    assert found.channels == (channel,)
    assert all(texts(found.description).values())
    (jump,) = found.parameters
    assert jump.value == pytest.approx(256 * STEP[channel], rel=1e-3)
    wrong = (found.undone(faulty * STEP) - right * STEP)[:, channel] / STEP[channel]
    assert np.mean(np.abs(wrong - np.median(wrong)) > 0.5) < 1e-3


def test_a_bit_that_sticks_is_told_with_the_codes_that_it_hits() -> None:
    right = codes(2)
    faulty = right.copy()
    faulty[:, 1] = stuck(right[:, 1], 9)
    found = fault(faulty)
    assert found is not None
    (jump,) = found.parameters
    assert jump.value == pytest.approx(512 * STEP[1], rel=1e-3)


def test_a_bit_that_sticks_below_the_noise_is_told_and_the_mean_put_right() -> None:
    right = codes(2)
    faulty = right.copy()
    faulty[:, 1] = stuck(right[:, 1], 3)
    found = fault(faulty)
    assert found is not None
    assert found.channels == (1,)
    (jump,) = found.parameters
    assert jump.value == pytest.approx(8 * STEP[1], rel=1e-3)
    wrong = (found.undone(faulty * STEP) - right * STEP)[:, 1] / STEP[1]
    assert abs(wrong.mean()) < 0.2


def test_a_high_byte_of_the_row_before_is_put_right() -> None:
    right = codes(9)
    faulty, late = right.copy(), np.random.default_rng(9).random(len(right)) < 0.4
    late[0] = False
    mixed = (np.roll(right[:, 4], 1) >> 8 << 8) + (right[:, 4] & 0xFF)
    faulty[:, 4] = np.where(late, mixed, right[:, 4])
    found = fault(faulty)
    assert found is not None
    assert found.channels == (4,)
    wrong = (found.undone(faulty * STEP) - right * STEP)[:, 4] / STEP[4]
    assert np.mean(np.abs(wrong) > 0.5) < 1e-3


def wide_noise(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Whole codes of a step so fine that noise is a fourth of a byte, and the step (6,)."""
    step = SIGMA / 64.0
    return np.round(noisy(mean_readings(MADE), seed) / step).astype(int), step


@pytest.mark.parametrize("seed", range(3))
def test_codes_whose_noise_is_a_fourth_of_a_byte_have_no_fault(seed: int) -> None:
    right, step = wide_noise(seed)
    assert find_code_fault(right * step, MADE) is None


def test_a_high_byte_of_the_row_before_is_told_where_noise_hides_each_one() -> None:
    right, step = wide_noise(11)
    faulty, late = right.copy(), np.random.default_rng(11).random(len(right)) < 0.7
    late[0] = False
    mixed = (np.roll(right, 1, axis=0) >> 8 << 8) + (right & 0xFF)
    faulty[:, :3] = np.where(late[:, None], mixed, right)[:, :3]
    found = find_code_fault(faulty * step, MADE)
    assert found is not None
    assert found.channels == (0, 1, 2)
    was, wrong = faulty - right, found.undone(faulty * step) / step - right
    assert np.mean(was[:, :3] != 0) > 0.1
    assert np.mean(np.abs(wrong[:, :3]) > 0.5) < 0.2 * np.mean(was[:, :3] != 0)


def test_a_high_byte_of_the_row_after_is_not_called_that_of_the_row_before() -> None:
    right, step = wide_noise(12)
    faulty, early = right.copy(), np.random.default_rng(12).random(len(right)) < 0.7
    early[-1] = False
    mixed = (np.roll(right, -1, axis=0) >> 8 << 8) + (right & 0xFF)
    faulty[:, 0] = np.where(early, mixed[:, 0], right[:, 0])
    assert torn_codes(faulty[:, 0], mean_readings(MADE)[:, 0] / step[0]) is None


@pytest.mark.parametrize("share", [0.25, 0.5])
def test_held_rows_have_no_high_byte_of_their_own(share: float) -> None:
    """What a logger of three rows in four lost looks late, as a high byte does."""
    right = codes(13)
    fresh = np.random.default_rng(13).random(len(right)) < share
    fresh[0] = True
    held = right[np.maximum.accumulate(np.where(fresh, np.arange(len(right)), 0))]
    assert fault(held) is None


@pytest.mark.parametrize("seed", [2, 6, 7])
def test_a_unit_that_lags_has_the_high_byte_of_an_earlier_row_and_the_low_one_as_well(
    seed: int,
) -> None:
    """It is off by a byte wherever the prediction is well ahead, but smoothly."""
    rng = np.random.default_rng(seed)
    t = np.arange(12_000) / 200.0
    waves = [(rng.uniform(500, 2500), rng.uniform(0.1, 2.5), rng.uniform(0, 6)) for _ in range(5)]
    early, late = (
        sum(size * np.sin(2.0 * np.pi * f * at + phase) for size, f, phase in waves)
        for at in (t, t - 0.033)
    )
    assert torn_codes(np.round(late + 8.0 * rng.standard_normal(len(t))), np.asarray(early)) is None


def test_a_sign_that_was_not_extended_is_a_fault_of_the_whole_word() -> None:
    right = codes(3)
    right[:, 0] -= np.round(np.mean(right[:, 0])).astype(int)  # rests near zero, of either sign
    faulty = right.copy()
    faulty[:, 0] = sign_lost(right[:, 0])
    found = fault(faulty)
    assert found is not None
    wrong = (found.undone(faulty * STEP) - right * STEP)[:, 0] / STEP[0]
    assert np.mean(np.abs(wrong - np.median(wrong)) > 0.5) < 1e-3


def test_a_bias_that_jumps_to_and_fro_by_a_byte_is_no_fault_of_the_codes() -> None:
    right = codes(4)
    flips = np.cumsum(np.random.default_rng(5).random(len(right)) < 0.1) % 2
    right[:, 2] += 256 * flips
    assert fault(right) is None


def test_a_single_step_and_spikes_of_a_byte_are_no_fault_of_the_codes() -> None:
    right = codes(6)
    right[10_000:, 0] += 256
    right[np.random.default_rng(7).integers(0, len(right), 40), 1] += 256
    assert fault(right) is None


def test_coarse_codes_have_no_fault() -> None:
    coarse = np.repeat([3e-3, 0.1], 3)
    assert find_code_fault(np.round(noisy(mean_readings(MADE), 8) / coarse) * coarse,
                           MADE) is None  # fmt: skip
    assert SIGMA[0] < coarse[0]
