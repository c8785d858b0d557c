"""Faults of a unit: changes to its counts and to its clock."""

from collections.abc import Callable

import numpy as np

# (numbers (n,), counts (n, 6)) -> counts; (numbers (n,), stamps (n,) us, first) -> both
Counts = Callable[[np.ndarray, np.ndarray], np.ndarray]
Stamps = Callable[[np.ndarray, np.ndarray, int], tuple[np.ndarray, np.ndarray]]

SPIKE_COUNTS = 100_000
SPIKE_EVERY = 1500  # samples
OUTLIER_COUNTS = 3000
CEILING_COUNTS = 2**19 // 10
SCATTER_COUNTS = 1000
DRIFT_COUNTS = 5  # per sample


def _hold(column: int, value: int) -> Counts:
    def change(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
        held = counts.copy()
        held[:, column] = value
        return held

    return change


stick = _hold(1, 12345)
stick_accel = _hold(5, 12345)


def zero(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    return np.zeros_like(counts)


def saturate(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    clipped = counts.copy()
    clipped[:, 0] = np.clip(clipped[:, 0], -CEILING_COUNTS, CEILING_COUNTS)
    return clipped


def spike(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    spiked = counts.copy()
    spiked[numbers % SPIKE_EVERY == SPIKE_EVERY - 1, :] += SPIKE_COUNTS
    return spiked


def outliers(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    off = counts.copy()
    off[numbers % 10 == 0, :3] += OUTLIER_COUNTS
    return off


def turn_sign(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    turned = counts.copy()
    turned[:, 0] *= -1
    return turned


def swap_axes(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    return counts[:, [1, 0, 2, 3, 4, 5]]


def scatter(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    noisy = counts.copy()
    hashed = (numbers.astype(np.int64) * 2_654_435_761) % 2**32 / 2**32 - 0.5
    noisy[:, 2] += np.rint(hashed * 2 * SCATTER_COUNTS).astype(counts.dtype)
    return noisy


def drift(numbers: np.ndarray, counts: np.ndarray) -> np.ndarray:
    drifted = counts.copy()
    drifted[:, 0] += (numbers * DRIFT_COUNTS).astype(counts.dtype)
    return drifted


def restart(numbers: np.ndarray, stamps: np.ndarray, first: int) -> tuple[np.ndarray, np.ndarray]:
    since = numbers - first
    period = stamps[0] / max(int(numbers[0]), 1)
    return since, np.rint(since * period).astype(np.uint64)


def drift_clock(
    numbers: np.ndarray, stamps: np.ndarray, first: int
) -> tuple[np.ndarray, np.ndarray]:
    period = stamps[0] / max(int(numbers[0]), 1)
    return numbers, np.rint(stamps + 0.01 * period * (numbers - first)).astype(np.uint64)


def jump_clock(
    numbers: np.ndarray, stamps: np.ndarray, first: int
) -> tuple[np.ndarray, np.ndarray]:
    return numbers, stamps + np.uint64(1_000_000)


def stop_clock(
    numbers: np.ndarray, stamps: np.ndarray, first: int
) -> tuple[np.ndarray, np.ndarray]:
    period = stamps[0] / max(int(numbers[0]), 1)
    return numbers, np.full(len(stamps), round(first * period), np.uint64)
