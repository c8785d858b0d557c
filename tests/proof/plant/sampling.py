"""The unit's electronics: filter, clock, converter. From the fine grid to its samples."""

from collections.abc import Sequence

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.stats import norm

from tests.proof.plant.effects.base import Effect


def filtered(signal: np.ndarray, step: float, effects: Sequence[Effect]) -> np.ndarray:
    """Six channels (6, n) after the analogue path; unchanged where nothing filters.

    The transfer function is applied in the frequency domain, so it is that of the analogue
    circuit, not of a discrete likeness; the ends are held to keep the wrap-around away.
    """
    length = next_fast_len(signal.shape[1] + int(2.0 / step), real=True)
    frequency = rfftfreq(length, step)
    passed = [answer for effect in effects if (answer := effect.response(frequency)) is not None]
    if not passed:
        return signal
    transfer = np.prod(passed, axis=0)
    after = (length - signal.shape[1]) // 2
    held = np.empty(length)
    result = np.empty_like(signal)
    for channel, series in enumerate(signal):
        held[: len(series)] = series
        held[len(series) : len(series) + after] = series[-1]
        held[len(series) + after :] = series[0]
        result[channel] = irfft(rfft(held) * transfer, length)[: len(series)]
    return result


def at_times(signal: np.ndarray, start: float, step: float, times: np.ndarray) -> np.ndarray:
    """Channels (c, n) on the grid start, start + step, … at other times, cubic between points.

    Beyond the ends, which lie at rest, the signal stays what it was.
    """
    place = np.clip((times - start) / step, 0.0, signal.shape[1] - 1.0)
    whole = np.rint(place)
    if np.abs(place - whole).max(initial=0.0) < 1e-6:
        return np.asarray(signal[:, whole.astype(int)])
    before = np.clip(np.floor(place).astype(int), 1, signal.shape[1] - 3)
    u = place - before
    return np.asarray(
        signal[:, before - 1] * (-u * (u - 1.0) * (u - 2.0) / 6.0)
        + signal[:, before] * ((u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0)
        + signal[:, before + 1] * (-(u + 1.0) * u * (u - 2.0) / 2.0)
        + signal[:, before + 2] * ((u + 1.0) * u * (u - 1.0) / 6.0)
    )


def mean_reading(signal: np.ndarray, steps: np.ndarray, deviations: np.ndarray) -> np.ndarray:
    """What channels (6, n) read on average when noise of these deviations meets these steps.

    The mean of a rounded Gaussian variable, as a Fourier series of the rounding error (Widrow and
    Kollár, Quantization Noise, 2008); with steps smaller than the noise it is the signal itself.
    """
    mean = signal.copy()
    for channel, (step, deviation) in enumerate(zip(steps, deviations, strict=True)):
        turns = 2.0 * np.pi * signal[channel] / step
        for order in range(1, 200):
            left = np.exp(-2.0 * (np.pi * order * deviation / step) ** 2)
            if left < 1e-6:
                break
            mean[channel] += step / np.pi * (-1.0) ** order / order * left * np.sin(order * turns)
    return mean


def mean_limited(signal: np.ndarray, limits: np.ndarray, deviations: np.ndarray) -> np.ndarray:
    """What channels (6, n) read on average when noise of these deviations meets ± limits (6,).

    E[min(s + noise, L)] = s − σ·(φ(d) − d·Φ(−d)) with d = (L − s)/σ, and the same from below.
    """
    mean = signal.copy()
    for channel, (limit, deviation) in enumerate(zip(limits, deviations, strict=True)):
        for side in (1.0, -1.0):
            room = (limit - side * signal[channel]) / deviation
            near = room < 6.0
            lost = norm.pdf(room[near]) - room[near] * norm.cdf(-room[near])
            mean[channel, near] -= side * deviation * lost
    return mean
