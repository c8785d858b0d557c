"""Noise of the rows in a fit: white noise of each row, and drift that correlates them.

A weighted sum Σ cⱼ·eⱼ of the noise has the variance cᵀ·Σ·c. The white part is diagonal. Flicker
of S(f) = h/f above 1/(2πL) has the autocovariance h·E₁(|τ|/L), a random walk −q·|τ|/2
(`tasks.uncertainty.drift`): products with such a matrix are convolutions, done by Fourier
transform on an even grid, so that the cost grows with n·log n.
"""

from dataclasses import dataclass

import numpy as np

from tasks.uncertainty.drift import LEVELS, flicker_integral

CELLS = 2**14  # grid cells at most; drift does not change within one


@dataclass(frozen=True)
class RowNoise:
    """Noise of the readings of six channels at n times.

    t: (n,) s, rising. white: (n, 6) variance of each row. drift: (DRIFTS, 6) flickers h
    (unit²), random walk q (unit²/s), trend squared (unit²/s²), as in `ChannelNoise`.
    """

    t: np.ndarray
    white: np.ndarray
    drift: np.ndarray

    def gram(self, channel: int, columns: np.ndarray) -> np.ndarray:
        """Covariance (k, k) of the k sums columnsᵀ·noise; columns: (n, k)."""
        gram = columns.T @ (self.white[:, channel, None] * columns)
        if self.drift[:, channel].any():
            gram += self._drifting(channel, columns)
        return gram

    def _drifting(self, channel: int, columns: np.ndarray) -> np.ndarray:
        *flickers, walk, trend = self.drift[:, channel]
        cells, width = _on_grid(self.t, columns)
        count = len(cells)
        lags = width * np.arange(count)
        kernels = [h * _mean_flicker(lags, width, L) for h, L in zip(flickers, LEVELS, strict=True)]
        gram = _toeplitz_gram(cells, np.sum(kernels, axis=0))
        total = cells.sum(axis=0)
        # A walk and a trend are counted about the mean of this run, as the drift shapes do.
        about_mean = cells - total / count
        gram += walk * _toeplitz_gram(about_mean, -0.5 * lags)
        moment = lags @ about_mean
        return gram + trend * np.outer(moment, moment)


def _on_grid(t: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, float]:
    """Sums (cells, k) of the columns over even cells of time, and a cell's width in s."""
    span = max(float(t[-1] - t[0]), 1e-9)
    count = min(CELLS, len(t))
    width = span / count
    cell = np.minimum((t - t[0]) / width, count - 1).astype(int)
    sums = [np.bincount(cell, column, count) for column in columns.T]
    return np.column_stack(sums), width


def _mean_flicker(lags: np.ndarray, width: float, level: float) -> np.ndarray:
    """Covariance of flicker of unit strength, up to relaxations of `level` s, between two cells."""
    from scipy.special import exp1  # late: a tenth of a start

    near = flicker_integral(np.abs(lags - width) / level) + flicker_integral((lags + width) / level)
    exact = (near - 2.0 * flicker_integral(lags / level)) * (level / width) ** 2
    # Far apart the second difference loses its digits, and the plain covariance is exact enough.
    return np.where(lags > 50 * width, exp1(np.maximum(lags, width) / level), exact)


def _toeplitz_gram(cells: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """cellsᵀ·T·cells of the symmetric Toeplitz matrix with the kernel (count,) as first row."""
    count = len(kernel)
    size = 1 << (2 * count - 1).bit_length()
    ring = np.zeros(size)
    ring[:count] = kernel
    ring[size - count + 1 :] = kernel[:0:-1]
    spectrum = np.fft.rfft(ring).real
    product = np.fft.irfft(spectrum[:, None] * np.fft.rfft(cells, size, axis=0), size, axis=0)
    return cells.T @ product[:count]
