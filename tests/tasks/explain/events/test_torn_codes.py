"""A high byte of the row before is put right; noise, held rows and a lag are no such fault."""

import numpy as np
import pytest
from made_up import SIGMA, mean_readings, motion, noisy

from tasks.explain.events.code_fault import CodeFault, find_torn_codes
from tasks.explain.events.torn_codes import torn_codes
from tasks.words import texts

STEP = np.repeat([1.0 / 131.0 * np.pi / 180.0, 9.8 / 16384.0], 3)


MADE = motion(minutes=2.0, top=4.0)  # 30,000 codes either way


def codes(seed: int) -> np.ndarray:
    """Whole codes of a run with noise of some codes."""
    return np.round(noisy(mean_readings(MADE), seed) / STEP).astype(int)


def fault(faulty: np.ndarray) -> CodeFault | None:
    return find_torn_codes(faulty * STEP, MADE)


@pytest.mark.parametrize("seed", range(3))
def test_right_codes_have_no_fault(seed: int) -> None:
    assert fault(codes(seed)) is None


def test_a_high_byte_of_the_row_before_is_put_right() -> None:
    right = codes(9)
    faulty, late = right.copy(), np.random.default_rng(9).random(len(right)) < 0.4
    late[0] = False
    mixed = (np.roll(right[:, 4], 1) >> 8 << 8) + (right[:, 4] & 0xFF)
    faulty[:, 4] = np.where(late, mixed, right[:, 4])
    found = fault(faulty)
    assert found is not None
    assert found.channels == (4,)
    assert all("high byte" in text or "高字节" in text for text in texts(found.title).values())
    wrong = (found.undone(faulty * STEP) - right * STEP)[:, 4] / STEP[4]
    assert np.mean(np.abs(wrong) > 0.5) < 1e-3


def wide_noise(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Whole codes of a step so fine that noise is a fourth of a byte, and the step (6,)."""
    step = SIGMA / 64.0
    return np.round(noisy(mean_readings(MADE), seed) / step).astype(int), step


def test_a_high_byte_of_the_row_before_is_told_where_noise_hides_each_one() -> None:
    right, step = wide_noise(11)
    faulty, late = right.copy(), np.random.default_rng(11).random(len(right)) < 0.7
    late[0] = False
    mixed = (np.roll(right, 1, axis=0) >> 8 << 8) + (right & 0xFF)
    faulty[:, :3] = np.where(late[:, None], mixed, right)[:, :3]
    found = find_torn_codes(faulty * step, MADE)
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
