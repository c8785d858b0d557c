"""A quantity that was measured by hand, with its standard uncertainty."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import detrend
from scipy.stats import norm

from schemas.recording import Recording


@dataclass(frozen=True)
class Measured:
    """value ± u (standard uncertainty) in `unit`."""

    value: float
    u: float
    unit: str

    def agrees(self, other: "Measured") -> bool:
        """Whether both hold the same within 95 % of what they state (k = 2)."""
        return abs(self.value - other.value) <= 2.0 * float(np.hypot(self.u, other.u))

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.value:.4g} ± {self.u:.2g}{unit}"


def batch_mean(values: np.ndarray, batches: int) -> tuple[float, float]:
    """Mean of a course (n,), and its u by the scatter of the means of consecutive batches."""
    means = np.array([batch.mean() for batch in np.array_split(values, batches)])
    return float(values.mean()), float(means.std(ddof=1) / np.sqrt(batches))


# Spectral lines by hand: a windowed Fourier sum at one frequency, beside its surroundings.

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


# Readings that were kept in coarse steps: their step, and which way they were rounded.

CELLS = 64
LEVELS = np.arange(-8, 10)


def step_of(readings: np.ndarray) -> float:
    """The step of which all readings are whole multiples."""
    levels = np.unique(readings)
    return float(np.diff(levels).min())


def dead_zone_misfit(recording: Recording, *, towards_zero: bool) -> float:
    """What a + b·sin θ + c·cos θ, noisy and kept in steps, leaves of accelerometer y, m/s².

    Root mean square over cells of the shaft's angle θ. Rounded to the nearest step, or cut off
    towards zero, which makes the step at zero twice as wide.
    """
    angle, y = _over_angle(recording)
    step = step_of(recording.imu.columns["accel_y"])
    A = np.column_stack([np.ones(len(angle)), np.sin(angle), np.cos(angle)])
    first = np.append(np.linalg.lstsq(A, y, rcond=None)[0], 0.3 * step)

    def left(values: np.ndarray) -> np.ndarray:
        return _kept(A @ values[:3], abs(values[3]) + 1e-3, step, towards_zero) - y

    return float(np.std(least_squares(left, first).fun))


def _over_angle(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    assert recording.table is not None
    angle, y = recording.table.columns["shaft_angle"], recording.imu.columns["accel_y"]
    cell = np.digitize(angle, np.linspace(angle.min(), angle.max(), CELLS))
    full = [k for k in np.unique(cell) if (cell == k).sum() > 50]
    return (np.array([angle[cell == k].mean() for k in full]),
            np.array([y[cell == k].mean() for k in full]))  # fmt: skip


def _kept(mean: np.ndarray, noise: float, step: float, towards_zero: bool) -> np.ndarray:
    """The mean of what is kept of noisy readings (n,)."""
    if towards_zero:
        low = np.where(LEVELS > 0, LEVELS, LEVELS - 1.0)
        high = np.where(LEVELS < 0, LEVELS, LEVELS + 1.0)
    else:
        low, high = LEVELS - 0.5, LEVELS + 0.5
    below, above = ((edge[:, None] * step - mean) / noise for edge in (low, high))
    return np.asarray(((norm.cdf(above) - norm.cdf(below)) * LEVELS[:, None] * step).sum(axis=0))
