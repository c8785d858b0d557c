"""The residual of a regression, weighted by its noise."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from scipy.fft import next_fast_len, rfft

from tasks.explain.events.event import Event
from tasks.motion.whole import Motion

SLOWEST = 1.0  # Hz; what is slower is left to the regression
LEVEL_BINS = 1024  # that the level of the noise about a line is estimated from
NEAREST = 1.0  # waves per recording, below half the sample rate: the mains of 50 Hz at 100 Hz
TAPER = 0.02  # of the recording, at either end
MAX_STRETCH = 4  # times its rows that a recording may last, gaps included


@dataclass(frozen=True)
class Residual:
    """Residuals at n rows, in rad/s and m/s².

    t: (n,) s, when the readings were taken. values: (n, 6), 0 where not known. weight: (n, 6) one
    over the noise, 0 where not known. motion: of the recording.
    """

    t: np.ndarray
    values: np.ndarray
    weight: np.ndarray
    motion: Motion

    @classmethod
    def of(cls, t: np.ndarray, values: np.ndarray, noise: np.ndarray, motion: Motion) -> Self:
        """From values (n, 6) and their noise (n, 6), NaN where either is not known."""
        known = np.isfinite(values) & (noise > 0)
        weight = np.divide(1.0, noise, out=np.zeros(noise.shape), where=known)
        return cls(t, np.where(known, values, 0.0), weight, motion)

    @cached_property
    def white(self) -> np.ndarray:
        """(n, 6) the values over their noise, 0 where not known."""
        return self.values * self.weight

    @cached_property
    def interval(self) -> float:
        """Time between rows, s."""
        return float(np.median(np.diff(self.t)))

    @property
    def span(self) -> float:
        """Time that the rows cover, s."""
        return float(self.t[-1] - self.t[0]) + self.interval

    def minus(self, signal: np.ndarray) -> Self:
        """The residual minus a signal (n, 6)."""
        return replace(self, values=np.where(self.weight > 0, self.values - signal, 0.0))

    def without(self, *events: Event) -> Self:
        """The residual with events removed as well."""
        left = self
        for event in events:
            left = left.minus(event.applied(self.t, np.zeros(self.values.shape)))
        return left

    def without_channels(self, channels: tuple[int, ...]) -> Self:
        """The same, with some channels not known."""
        kept = ~np.isin(np.arange(self.values.shape[1]), channels)
        return replace(self, values=self.values * kept, weight=self.weight * kept)


@dataclass(frozen=True)
class Spectrum:
    """power: (bins,) over that of the noise about it, summed over channels: of noise alone it is
    gamma distributed, with a shape of their number. level: (bins, channels) of the noise, over
    white noise. frequency: (bins,) Hz. channels: (k,) those that were recorded. nyquist: half the
    sample rate that its bins stand for, Hz."""

    power: np.ndarray
    level: np.ndarray
    frequency: np.ndarray
    channels: np.ndarray
    nyquist: float

    def level_at(self, frequency: float) -> np.ndarray:
        """Level (channels,) of the noise at a frequency in Hz."""
        return np.asarray(self.level[int(np.abs(self.frequency - frequency).argmin())])


def spectrum_of(residual: Residual) -> Spectrum:
    """The spectrum of the whitened residual, tapered at both ends."""
    t, white, interval = residual.t, residual.white, residual.interval
    channels = np.flatnonzero(white.any(axis=0))
    place = np.round((t - t[0]) / interval).astype(int)
    if place[-1] > MAX_STRETCH * len(t) or (np.diff(place) < 1).any():
        place = np.arange(len(t))
        interval = float(t[-1] - t[0]) / (len(t) - 1)  # rows count, not the usual step of stamps
    count = int(place[-1]) + 1
    edge = np.minimum(1.0, np.arange(1, count + 1) / max(TAPER * count, 1.0))
    taper = np.sin(0.5 * np.pi * np.minimum(edge, edge[::-1])).astype(np.float32) ** 2
    size = next_fast_len(2 * count, real=True)
    frequency = np.arange(size // 2 + 1) / (size * interval)
    inside = (frequency > SLOWEST) & (frequency < 0.5 / interval - NEAREST / (count * interval))
    total, level = np.zeros(int(inside.sum())), np.zeros((int(inside.sum()), len(channels)))
    for k, channel in enumerate(channels):
        even = np.zeros(count, np.float32)  # half the work, and exact enough
        even[place] = white[:, channel]
        transform = rfft((even - even.mean()) * taper, size)[inside]
        power = transform.real**2 + transform.imag**2
        noise = noise_level(power)
        total += np.divide(power, noise, out=np.zeros_like(power), where=noise > 0)
        level[:, k] = noise / max(float((taper[place] ** 2)[white[:, channel] != 0].sum()), 1.0)
    return Spectrum(total, level, frequency[inside], channels, 0.5 / interval)


def noise_level(power: np.ndarray) -> np.ndarray:
    """The mean power (bins,) of the noise about each bin: its neighbours' median over ln 2.

    0 where there are too few bins.
    """
    pieces = len(power) // LEVEL_BINS
    if pieces == 0:
        return np.zeros(len(power))
    level = np.median(power[: pieces * LEVEL_BINS].reshape(pieces, LEVEL_BINS), axis=1)
    middle = (np.arange(pieces) + 0.5) * LEVEL_BINS
    return np.asarray(np.interp(np.arange(len(power)), middle, level) / np.log(2))


def peak_offset(values: np.ndarray, peak: int) -> float:
    """Where the parabola through a peak and its neighbours has its top, in steps from it."""
    if not 0 < peak < len(values) - 1:
        return 0.0
    before, middle, after = values[peak - 1 : peak + 2]
    bend = before - 2 * middle + after
    return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend < 0 else 0.0
