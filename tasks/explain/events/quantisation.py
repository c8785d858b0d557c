"""Coarse quantisation: the output step is visible above the noise.

A reading is the nearest code to x + noise. With Gaussian noise σ and step q its mean is
x + Σ_k (−1)^k·(q/πk)·exp(−2π²k²σ²/q²)·sin(2πkx/q)
(Widrow, Kollár: Quantization Noise, 2008). Above σ = 0.6 q nothing of it is left, and steps are of
no concern.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr
from scipy.stats import chi2

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import TRIADS
from tasks.explain.events.event import TRIAD_NAMES, UNITS, Event
from tasks.explain.events.noise import BLOCK
from tasks.explain.events.residual import peak_offset
from tasks.motion.samples import in_blocks
from tasks.readings.lattice import OFF_CODE, Quantiser
from tasks.words import Message, message

FINE = 0.6  # noise per step from which a step shifts no mean by more than 3e-4 of it
NOISES = np.geomspace(0.04, 1.5, 40)  # σ in steps that are tried
PHASES = np.linspace(-0.5, 0.5, 33)[:-1]  # where the mean may lie between two codes
MAX_OFF = 6  # codes beside the middle one that are counted
CODES = np.arange(-MAX_OFF, MAX_OFF + 1)[:, None]
EDGES = np.arange(-MAX_OFF, MAX_OFF + 2)[:, None] - 0.5
CELLS = 256  # between two codes
MIN_INFORMATION = 0.3  # of a reading's without steps: one with less is left out
QUIET = 0.5  # of the least noise of the others of a triad
SHORT = 0.9  # of what an ideal unit reads: no scale factor is that far off
LARGE = (0.1, 1.0)  # rad/s and m/s²: beside less a bias counts
MOSTLY = 0.5  # of the largest ideal reading, from which on readings are compared with it
STEADY = 0.15  # steps: how far the predicted reading may move within a block
MAX_BLOCKS = 400  # that are looked at
SIGNIFICANT = 1e-4 / 6


@dataclass(frozen=True)
class Quantisation(Event):
    """quantisers: of each channel with visible steps. noises: σ before rounding, of each."""

    linear = False

    quantisers: tuple[Quantiser, ...]
    noises: tuple[float, ...]

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        rounded = predicted.copy()
        for channel, quantiser, noise in self._channels():
            rounded[:, channel] += rounding_bias(predicted[:, channel], quantiser, noise)
        return rounded

    def corrected(self, readings: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        """Working readings of a fit by maximum likelihood (Fisher's scoring).

        Between two codes, far from the edge, a reading carries next to no information on the mean.
        """
        working = readings.copy()
        for channel, quantiser, noise in self._channels():
            slope, variance = _response(before[:, channel], quantiser, noise)
            informative = slope**2 * noise**2 > MIN_INFORMATION * variance
            step = (readings[:, channel] - after[:, channel]) / np.where(informative, slope, 1.0)
            step = np.clip(step, -quantiser.step, quantiser.step)
            working[:, channel] = np.where(informative, before[:, channel] + step, np.nan)
        return working

    def _channels(self) -> "zip[tuple[int, Quantiser, float]]":
        return zip(self.channels, self.quantisers, self.noises, strict=True)

    def noise_floor(self, noise: np.ndarray) -> np.ndarray:
        # Near a code nothing scatters.
        floored = noise.copy()
        for channel, quantiser, _ in self._channels():
            floored[:, channel] = np.fmax(floored[:, channel], quantiser.step / np.sqrt(12))
        return floored


@dataclass(frozen=True)
class NoiseEstimate:
    """The noise of one channel per step; p_value: that the steps do not show."""

    channel: int
    quantiser: Quantiser
    ratio: float
    p_value: float


def rounding_bias(mean: np.ndarray, quantiser: Quantiser, noise: float) -> np.ndarray:
    """How far rounding shifts the mean reading (n,), by the series above."""
    ratio = noise / quantiser.step
    phase = 2 * np.pi * (mean - quantiser.offset) / quantiser.step
    shift = np.zeros(len(mean))
    for k in range(1, int(np.clip(np.ceil(0.84 / ratio), 1, 60)) + 1):
        weight = (-1) ** k / (np.pi * k) * np.exp(-2 * (np.pi * k * ratio) ** 2)
        shift += weight * np.sin(k * phase)
    return quantiser.step * shift


def _response(
    mean: np.ndarray, quantiser: Quantiser, noise: float
) -> tuple[np.ndarray, np.ndarray]:
    """Derivative (n,) of the mean reading by the mean before rounding, and a reading's variance."""
    ratio = noise / quantiser.step
    phase = np.linspace(-0.5, 0.5, CELLS + 1)
    deviate = (EDGES - phase) / ratio
    probability = np.diff(ndtr(deviate), axis=0)
    middle = (CODES * probability).sum(axis=0)
    variance = (CODES**2 * probability).sum(axis=0) - middle**2
    density = np.exp(-0.5 * deviate**2) / (np.sqrt(2 * np.pi) * ratio)
    slope = -(CODES * np.diff(density, axis=0)).sum(axis=0)
    at = (mean - quantiser.offset) / quantiser.step
    within = np.nan_to_num(at - np.round(at))
    return (
        np.interp(within, phase, slope),
        np.interp(within, phase, np.maximum(variance, 1e-9)) * quantiser.step**2,
    )


def noise_estimates(
    readings: np.ndarray, predicted: np.ndarray, quantisers: Sequence[Quantiser | None]
) -> tuple[NoiseEstimate, ...]:
    """The noise per step of each channel with steps; predicted: (n, 6), NaN where not known."""
    every = (
        _noise_of(channel, quantiser, readings[:, channel], predicted[:, channel])
        for channel, quantiser in enumerate(quantisers) if quantiser is not None
    )  # fmt: skip
    return tuple(each for each in every if each is not None)


def cut_off(
    estimates: Sequence[NoiseEstimate],
    readings: np.ndarray,
    ideal: Callable[[int], np.ndarray],
) -> dict[int, float]:
    """The channels that lost noise and signal, as beyond a limit: what share of what an ideal unit
    would read they read. ideal: that, (n,), of a channel.

    Noise is missing where it is a small part of that of the others of the triad with the same step.
    """
    found = {}
    for one in estimates:
        alike = [
            other.ratio for other in estimates
            if other.channel // 3 == one.channel // 3 and other is not one
            and abs(other.quantiser.step / one.quantiser.step - 1.0) < OFF_CODE
        ]  # fmt: skip
        if alike and one.ratio < min(FINE, QUIET * min(alike)):
            least = LARGE[one.channel // 3]
            share = _share_read(readings[:, one.channel], ideal(one.channel), least)
            if 0.0 < share < SHORT:
                found[one.channel] = share
    return found


def _share_read(readings: np.ndarray, ideal: np.ndarray, least: float) -> float:
    """Median share that readings (n,) are of an ideal unit's where those are large, and larger than
    `least`; one without.
    """
    size = np.abs(ideal)
    large = np.isfinite(readings) & (size > max(least, MOSTLY * np.nanmax(size, initial=0.0)))
    return float(np.median(readings[large] / ideal[large])) if large.any() else 1.0


def find_quantisation(
    every: Sequence[NoiseEstimate], left_out: Collection[int] = ()
) -> Quantisation | None:
    """Steps that are visible above the noise, but for channels that are left out."""
    estimates = [
        each for each in every
        if each.ratio < FINE and each.p_value < SIGNIFICANT and each.channel not in left_out
    ]  # fmt: skip
    if not estimates:
        return None
    parameters, texts = zip(*_by_triad(estimates), strict=True)
    both = message("clause-sequence", first=texts[0], rest=texts[-1])
    return Quantisation(
        "coarse_quantisation", tuple(each.channel for each in estimates), parameters,
        min(1.0, 6 * min(each.p_value for each in estimates)),
        both if len(texts) > 1 else texts[0],
        tuple(each.quantiser for each in estimates),
        tuple(each.ratio * each.quantiser.step for each in estimates),
    )  # fmt: skip


def _noise_of(
    channel: int, quantiser: Quantiser, readings: np.ndarray, predicted: np.ndarray
) -> NoiseEstimate | None:
    """Maximum likelihood of the noise before rounding, each block with a mean of its own."""
    counts = _code_counts(quantiser, readings, predicted)
    if not len(counts):
        return None
    probability = np.diff(ndtr((EDGES - PHASES) / NOISES[:, None, None]), axis=1)
    log_odds = np.log(np.maximum(probability, 1e-12))  # (noises, codes, phases)
    likelihood = (counts @ log_odds).max(axis=2).sum(axis=1)
    best = int(likelihood.argmax())
    least = likelihood[NOISES >= FINE].max()
    p_value = float(chi2.sf(2 * (likelihood[best] - least), 1)) if NOISES[best] < FINE else 1.0
    ratio = NOISES[best] * (NOISES[1] / NOISES[0]) ** peak_offset(likelihood, best)
    return NoiseEstimate(channel, quantiser, float(ratio), p_value)


def _code_counts(quantiser: Quantiser, readings: np.ndarray, predicted: np.ndarray) -> np.ndarray:
    """How often each code (blocks, 2·MAX_OFF + 1) about the middle one, in steady blocks."""
    number = np.round((in_blocks(readings, BLOCK) - quantiser.offset) / quantiser.step)
    wander = np.ptp(in_blocks(predicted, BLOCK), axis=1) / quantiser.step
    number = number[np.isfinite(number).all(axis=1) & ~(wander > STEADY)]
    about = number - np.median(number, axis=1).round()[:, None]
    about = about[(np.abs(about) <= MAX_OFF).all(axis=1)].astype(int)
    about = about[:: len(about) // MAX_BLOCKS + 1]
    return np.asarray((about[:, :, None] == CODES[:, 0]).sum(axis=1))


def _by_triad(estimates: list[NoiseEstimate]) -> Iterator[tuple[FoundParameter, Message]]:
    """Each triad's step, which is exact but for the rounding of the codes, and in words."""
    for triad, name in enumerate(("gyro", "accel")):
        own = [each for each in estimates if each.channel in TRIADS[triad]]
        if not own:
            continue
        steps = [each.quantiser.step for each in own]
        step, u = float(np.mean(steps)), max(float(np.std(steps)), 1e-6 * steps[0])
        ratio = 1 / float(np.median([each.ratio for each in own]))
        yield (
            FoundParameter(name=name, value=step, unit=UNITS[triad], u=u),
            message(
                "events-quantisation", sensors=TRIAD_NAMES[triad],
                step=f"{step:.4g} {UNITS[triad]}", ratio=f"{ratio:.1f}",
            ),
        )  # fmt: skip
