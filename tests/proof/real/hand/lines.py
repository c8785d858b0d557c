"""Spectral lines by hand: a windowed Fourier sum at one frequency, beside its surroundings."""

import numpy as np
from scipy.signal import detrend

AROUND, CLEAR = 1.5, 0.15  # Hz: how far the surroundings reach, and where they begin
PLACES = 60  # frequencies that the surroundings are read at


def amplitude(t: np.ndarray, y: np.ndarray, frequency: float) -> float:
    """Amplitude of a line at a frequency, Hz, in a course (n,); Hann window, trend off."""
    window = np.hanning(len(t))
    turning = np.exp(-2j * np.pi * frequency * t)
    return float(2.0 * abs((detrend(y) * window * turning).sum()) / window.sum())


def surroundings(t: np.ndarray, y: np.ndarray, frequency: float) -> float:
    """Median amplitude near a frequency, Hz: what noise alone shows there."""
    offsets = np.linspace(CLEAR, AROUND, PLACES // 2)
    near = (amplitude(t, y, frequency + d) for d in (*offsets, *-offsets))
    return float(np.median(list(near)))


def prominence(t: np.ndarray, y: np.ndarray, frequency: float, width: float = 0.0) -> float:
    """Amplitude over that of the surroundings; width: Hz on each side where the line may lie.

    Noise alone exceeds 3.3 in one place of 2000 (a Rayleigh amplitude).
    """
    places = np.linspace(-width, width, 1 + 2 * round(width * (t[-1] - t[0])))
    most = max(amplitude(t, y, frequency + d) for d in places)
    return most / surroundings(t, y, frequency)


def strongest(t: np.ndarray, y: np.ndarray, low: float, high: float) -> float:
    """Frequency, Hz, of the strongest line between two bounds."""
    interval = float(np.median(np.diff(t)))
    count = 4 * len(t)
    spectrum = np.abs(np.fft.rfft(detrend(y) * np.hanning(len(t)), count))
    frequency = np.fft.rfftfreq(count, interval)
    inside = (frequency >= low) & (frequency <= high)
    return float(frequency[inside][spectrum[inside].argmax()])
