"""Noise of accumulated angles, from their increments inside the rests.

Three parts: white noise of the rate, which makes the angle walk (N², rad²/s); white noise and
rounding of the angle itself (q², rad²); flicker of the rate. Their Allan variances are N²/τ,
3·q²/τ² and 2·ln 2·h (IEEE Std 952, annex C). What is slower than a rest, `tasks.uncertainty`
finds between them.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

FLICKER_ALLAN = 2.0 * np.log(2.0)
ROUNDS = 5  # of weighting by the model fitted before
FAINT = 0.1  # of the white part: less is what is left of a difference


@dataclass(frozen=True)
class AngleNoise:
    """walk: (3,) N², rad²/s; angle: (3,) q², rad², of one reading."""

    walk: np.ndarray
    angle: np.ndarray


def fit_angle_noise(rests: list[np.ndarray], interval: float, step: np.ndarray) -> AngleNoise:
    """Noise that all rests together show.

    rests: increments (3, n) rad each, `interval` s apart; step: (3,) rad, resolution. The noise
    of the angle is never less than that of rounding, step²/12.
    """
    rounding = step**2 / 12.0
    variance, count = pooled_allan(rests, interval)
    if not len(count):
        return AngleNoise(np.zeros(3), rounding)
    tau = interval * 2.0 ** np.arange(len(count))
    fitted = np.array([_fit(tau, variance[:, channel], count) for channel in range(3)])
    return AngleNoise(walk=fitted[:, 1], angle=np.maximum(fitted[:, 0], rounding))


def pooled_allan(rests: list[np.ndarray], interval: float) -> tuple[np.ndarray, np.ndarray]:
    """Allan variances (levels, 3) of the rate at 1, 2, 4 … intervals, and how many differences."""
    levels = max((rest.shape[1].bit_length() - 1 for rest in rests), default=0)
    total, count = np.zeros((levels, 3)), np.zeros(levels, int)
    for rest in rests:
        gain = rest
        for level in range(rest.shape[1].bit_length() - 1):
            square = np.diff(gain, axis=1) ** 2 / (interval * 2.0**level) ** 2
            total[level] += 0.5 * square.sum(axis=1)
            count[level] += square.shape[1]
            even = gain.shape[1] // 2 * 2
            gain = gain[:, 0:even:2] + gain[:, 1:even:2]
    return total / count[:, None], count


def _fit(tau: np.ndarray, variance: np.ndarray, count: np.ndarray) -> np.ndarray:
    """q², N² and h (3,), none negative: least squares, each level as it knows its own size."""
    if not variance.any():
        return np.zeros(3)
    design = np.column_stack([3.0 / tau**2, 1.0 / tau, np.full(len(tau), FLICKER_ALLAN)])
    expected, terms = variance.clip(min=1e-6 * variance.max() / len(tau)), np.zeros(3)
    for _ in range(ROUNDS):
        weight = np.sqrt(count) / expected
        terms = _not_negative(design * weight[:, None], variance * weight)
        expected = np.maximum(design @ terms, 1e-12 * variance.max())
    return terms


def _not_negative(design: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The best of the fits (p,) with some parameters zero and none below."""
    best, least = np.zeros(design.shape[1]), float(target @ target)
    for size in range(1, min(design.shape) + 1):
        for chosen in map(list, combinations(range(design.shape[1]), size)):
            scale = np.linalg.norm(design[:, chosen], axis=0)
            terms = np.linalg.lstsq(design[:, chosen] / scale, target, rcond=None)[0] / scale
            rest = target - design[:, chosen] @ terms
            if (terms >= 0).all() and rest @ rest < least:
                best, least = np.zeros(design.shape[1]), float(rest @ rest)
                best[chosen] = terms
    return best


def slow_allan(variances: list[np.ndarray], tau: np.ndarray, noise: AngleNoise) -> np.ndarray:
    """Mean Allan variance (levels, 3) of equally long rests, without the part of the angle.

    variances: (levels, 3) of each rest at block lengths tau (levels,). Never less than a part of
    what the white rate noise gives.
    """
    slow = np.mean(variances, axis=0) - 3.0 * noise.angle / tau[:, None] ** 2
    return np.maximum(slow, FAINT * noise.walk / tau[:, None])
