"""Noise as engineers state it: angle random walk and bias instability by the Allan variance.

Taken inside the segments only, so that what differs between them is not taken for noise, and as a
median over them, so that a few bad ones do not count (IEEE Std 952-1997, annex C: white noise of
density w has σ²(τ) = w/2τ, flicker b/f has σ²(τ) = 2·ln 2·b).
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import dct, idct, next_fast_len
from scipy.optimize import nnls

from tasks.explain.inputs.blocks import Blocks

FLICKER = 2.0 * np.log(2.0)
FEWEST = 2  # differences of neighbouring means in a segment
LONGEST = 12  # doublings of a block
EFFICIENCY = 0.64  # of a median beside a mean, 2/π
TRIADS = (slice(0, 3), slice(3, 6))


@dataclass(frozen=True)
class Noise:
    """One-sided density S(f) = white + flicker/f of one channel."""

    white: float
    flicker: float

    def of_mean(self, seconds: np.ndarray, whole: float) -> np.ndarray:
        """Variance of means over some seconds against the level of the whole run (s)."""
        beyond = 1.0 + np.log(np.maximum(whole / seconds, 1.0))
        return np.asarray(self.white / (2.0 * seconds) + self.flicker * beyond)


def noises_of(observed: Blocks, left: np.ndarray) -> tuple[Noise, ...]:
    """Noise of the six channels from what the standard's model leaves, (n, 6).

    The corner between white and flicker noise is common to a triad.
    """
    noises: list[Noise] = []
    for triad in TRIADS:
        ladders = [_ladder(observed, left[:, c], c) for c in range(6)[triad]]
        relative = np.array([variance / max(variance[0], 1e-300) for variance, _ in ladders])
        freedom = np.sum([freedom for _, freedom in ladders], axis=0)
        known = np.isfinite(relative).all(axis=0)
        corner = _corner(relative[:, known].mean(axis=0), freedom[known], observed.rate)
        for variance, _ in ladders:
            level = max(variance[0] * 2.0 / observed.rate, 1e-30)
            level /= 1.0 + corner * FLICKER * 2.0 / observed.rate
            noises.append(Noise(level, corner * level))
    return tuple(noises)


def _ladder(observed: Blocks, left: np.ndarray, channel: int) -> tuple[np.ndarray, np.ndarray]:
    """Allan variance at 1, 2, 4 … blocks and its degrees of freedom: medians over the segments;
    NaN where too few are so long."""
    lengths = 2 ** np.arange(LONGEST)
    found: list[list[float]] = [[] for _ in lengths]
    freedoms = np.zeros(LONGEST)
    for number in range(len(observed.segments)):
        rows = np.flatnonzero((observed.segment == number) & (observed.weight[:, channel] > 0))
        series = left[rows]
        for k, length in enumerate(lengths):
            count = len(series) // length
            if count < FEWEST + 1:
                break
            means = series[: count * length].reshape(count, length).mean(axis=1)
            freedom = max(1.0, 0.67 * (count - 1))  # neighbouring differences share a mean
            typical = (1.0 - 2.0 / (9.0 * freedom)) ** 3  # median of chi-squared over its mean
            found[k].append(float(np.mean(np.diff(means) ** 2) / 2.0 / typical))
            freedoms[k] += freedom
    variance = [np.median(each) if len(each) > FEWEST else np.nan for each in found]
    return np.array(variance), freedoms


def _corner(relative: np.ndarray, freedom: np.ndarray, rate: float) -> float:
    """Frequency (Hz) at which flicker is as dense as white noise, plus its standard error: a
    lucky run must not pass for a unit without flicker."""
    if len(relative) < 3 or not (relative > 0).all():
        return 0.0
    seconds = 2 ** np.arange(len(relative)) / rate
    root = np.sqrt(EFFICIENCY * freedom / 2.0) / relative
    columns = np.column_stack([0.5 / seconds, np.full(len(seconds), FLICKER)]) * root[:, None]
    (white, flicker), _ = nnls(columns, relative * root)
    spread = np.sqrt(np.linalg.inv(columns.T @ columns)[1, 1])
    return float((flicker + spread) / white) if white > 0 else rate


def whitened(courses: np.ndarray, noise: Noise, rate: float) -> np.ndarray:
    """Courses (k, n) whose noise has this density, divided by its root: unit variance."""
    count = courses.shape[1]
    length = int(next_fast_len(count, real=True))
    padded = np.pad(courses, ((0, 0), (0, length - count)), mode="symmetric")
    frequency = np.maximum(np.arange(length), 0.5) * rate / (2.0 * length)
    gain = 1.0 / np.sqrt((noise.white + noise.flicker / frequency) * rate / 2.0)
    flat = dct(padded, type=2, norm="ortho", overwrite_x=True) * gain
    return np.asarray(idct(flat, type=2, norm="ortho", overwrite_x=True)[:, :count])
