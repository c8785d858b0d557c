"""Coarse quantisation: the step of the output is visible above the noise.

A reading is the nearest code to x + noise. With Gaussian noise σ and step q its mean is
x + Σ_k (−1)^k·(q/πk)·exp(−2π²k²σ²/q²)·sin(2πkx/q)
(Widrow, Kollár: Quantization Noise, 2008). Above σ = 0.6 q nothing of it is left, and steps are of
no concern.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr
from scipy.stats import chi2

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import GYROS, TRIADS
from tasks.explain.events.event import TRIAD_NAMES, UNITS, Event
from tasks.explain.events.plain import BLOCK
from tasks.explain.events.steps import Codes, codes_of
from tasks.model.term import Text

FINE = 0.6  # noise per step from which a step shifts no mean by more than 3e-4 of it
NOISES = np.geomspace(0.04, 1.5, 40)  # σ in steps that are tried
PHASES = np.linspace(-0.5, 0.5, 33)[:-1]  # where the mean may lie between two codes
WIDE = 6  # codes beside the middle one that are counted
CELLS = 256  # between two codes
TOLD = 0.3  # of what a reading without steps tells of its mean: less is left out
STEADY = 0.15  # steps: how far the predicted reading may move within a block
MOST = 400  # blocks that are looked at
SURE = 1e-4 / 6


@dataclass(frozen=True)
class Quantisation(Event):
    """codes: of each channel with visible steps. noises: σ before rounding, of each of them."""

    codes: tuple[Codes, ...]
    noises: tuple[float, ...]

    def applied(self, t: np.ndarray, predicted: np.ndarray, noise: np.ndarray) -> np.ndarray:
        rounded = predicted.copy()
        for channel, codes, before in zip(self.channels, self.codes, self.noises, strict=True):
            rounded[:, channel] += rounding(predicted[:, channel], codes, before)
        return rounded

    def freed(
        self, readings: np.ndarray, before: np.ndarray, after: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """Working readings of a fit by maximum likelihood (Fisher's scoring).

        Between two codes, far from the edge, a reading tells next to nothing of the mean.
        """
        freed, untold = readings.copy(), np.zeros(readings.shape, bool)
        for channel, codes, noise in zip(self.channels, self.codes, self.noises, strict=True):
            slope, variance = _response(before[:, channel], codes, noise)
            told = slope**2 * noise**2 > TOLD * variance
            step = (readings[:, channel] - after[:, channel]) / np.where(told, slope, 1.0)
            freed[:, channel] = before[:, channel] + np.clip(step, -codes.step, codes.step)
            untold[:, channel] = ~told
        return freed, untold


@dataclass(frozen=True)
class Seen:
    """The steps of one channel. ratio: noise per step; u: of it. p_value: that ratio is fine."""

    channel: int
    codes: Codes
    ratio: float
    u: float
    p_value: float


def rounding(mean: np.ndarray, codes: Codes, noise: float) -> np.ndarray:
    """How far rounding shifts the mean reading (n,), by the series above."""
    ratio = noise / codes.step
    phase = 2 * np.pi * (mean - codes.offset) / codes.step
    shift = np.zeros(len(mean))
    for k in range(1, int(np.clip(np.ceil(0.84 / ratio), 1, 60)) + 1):
        weight = (-1) ** k / (np.pi * k) * np.exp(-2 * (np.pi * k * ratio) ** 2)
        shift += weight * np.sin(k * phase)
    return codes.step * shift


def _response(mean: np.ndarray, codes: Codes, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Derivative (n,) of the mean reading by the mean before rounding, and a reading's variance."""
    ratio = noise / codes.step
    phase = np.linspace(-0.5, 0.5, CELLS + 1)
    code = np.arange(-WIDE, WIDE + 1)[:, None]
    edges = np.arange(-WIDE, WIDE + 2)[:, None] - 0.5
    chance = np.diff(ndtr((edges - phase) / ratio), axis=0)
    middle = (code * chance).sum(axis=0)
    variance = (code**2 * chance).sum(axis=0) - middle**2
    density = np.exp(-0.5 * ((edges - phase) / ratio) ** 2) / (np.sqrt(2 * np.pi) * ratio)
    slope = -(code * np.diff(density, axis=0)).sum(axis=0)
    at = (mean - codes.offset) / codes.step
    within = np.nan_to_num(at - np.round(at))
    return (
        np.interp(within, phase, slope),
        np.interp(within, phase, np.maximum(variance, 1e-9)) * codes.step**2,
    )


def find_quantisation(readings: np.ndarray, predicted: np.ndarray) -> Quantisation | None:
    """Steps that are visible above the noise; predicted: (n, 6), NaN where it is not known."""
    seen = []
    for channel in range(6):
        codes = codes_of(readings[:, channel])
        if codes is not None:
            one = _seen(channel, codes, readings[:, channel], predicted[:, channel])
            if one is not None and one.ratio < FINE and one.p_value < SURE:
                seen.append(one)
    if not seen:
        return None
    return Quantisation(
        "coarse_quantisation", tuple(each.channel for each in seen), _parameters(seen),
        min(1.0, 6 * min(each.p_value for each in seen)), _said(seen), None,
        tuple(each.codes for each in seen),
        tuple(each.ratio * each.codes.step for each in seen),
    )  # fmt: skip


def _seen(channel: int, codes: Codes, readings: np.ndarray, predicted: np.ndarray) -> Seen | None:
    """Maximum likelihood of the noise before rounding, each block with a mean of its own."""
    counted = _counts(codes, readings, predicted)
    if len(counted) == 0:
        return None
    likelihood = np.array([(counted @ _log_odds(ratio)).max(axis=1).sum() for ratio in NOISES])
    best = int(likelihood.argmax())
    least = likelihood[NOISES >= FINE].max()
    p_value = float(chi2.sf(2 * (likelihood[best] - least), 1)) if NOISES[best] < FINE else 1.0
    ratio, u = _peak(likelihood, best)
    return Seen(channel, codes, ratio, u, p_value)


def _counts(codes: Codes, readings: np.ndarray, predicted: np.ndarray) -> np.ndarray:
    """How often each code (blocks, 2·WIDE + 1) about the middle one, in blocks that are steady."""
    blocks = len(readings) // BLOCK
    cut = slice(0, blocks * BLOCK)
    number = np.round((readings[cut] - codes.offset) / codes.step).reshape(blocks, BLOCK)
    wander = np.ptp(predicted[cut].reshape(blocks, BLOCK), axis=1) / codes.step
    steady = np.isfinite(number).all(axis=1) & ~(wander > STEADY)
    number = number[steady]
    about = number - np.median(number, axis=1).round()[:, None]
    about = about[(np.abs(about) <= WIDE).all(axis=1)].astype(int)
    about = about[:: len(about) // MOST + 1] + WIDE
    wide = 2 * WIDE + 1
    cells = np.arange(len(about))[:, None] * wide + about
    return np.bincount(cells.ravel(), minlength=len(about) * wide).reshape(-1, wide)


def _log_odds(ratio: float) -> np.ndarray:
    """Log probability (2·WIDE + 1, phases) of each code, for noise in steps."""
    edges = np.arange(-WIDE, WIDE + 2)[:, None] - 0.5 - PHASES
    return np.log(np.maximum(np.diff(ndtr(edges / ratio), axis=0), 1e-12))


def _peak(likelihood: np.ndarray, best: int) -> tuple[float, float]:
    """Top of a parabola through the best three of the noises tried, and its width."""
    if best in (0, len(NOISES) - 1):
        return float(NOISES[best]), float(NOISES[best])
    at = np.log(NOISES[best - 1 : best + 2])
    square, slope, _ = np.polyfit(at - at[1], likelihood[best - 1 : best + 2], 2)
    ratio = float(np.exp(at[1] - slope / (2 * square)))
    return ratio, ratio / float(np.sqrt(-2 * square))


def _parameters(seen: list[Seen]) -> tuple[FoundParameter, ...]:
    """The step of each triad; it is read from the codes, exact but for their rounding."""
    found = []
    for triad, name in enumerate(("gyro", "accel")):
        steps = [each.codes.step for each in seen if each.channel in TRIADS[triad]]
        if steps:
            u = max(float(np.std(steps)), 1e-6 * steps[0])
            value = float(np.mean(steps))
            found.append(FoundParameter(name=name, value=value, unit=UNITS[triad], u=u))
    return tuple(found)


def _said(seen: list[Seen]) -> Text:
    english, chinese = [], []
    for triad in (0, 1):
        own = [each for each in seen if (each.channel in GYROS) == (triad == 0)]
        if own:
            step = float(np.mean([each.codes.step for each in own]))
            times = 1 / float(np.median([each.ratio for each in own]))
            en, zh = TRIAD_NAMES[triad]
            width = f"{step:.4g} {UNITS[triad]}"
            english.append(f"the {en} step by {width}, {times:.1f} times the noise")
            chinese.append(f"{zh}的步距为 {width}，是噪声的 {times:.1f} 倍")
    return "; ".join(english), "；".join(chinese)
