"""Damped swings that start at some times: what clicks and bursts make of the readings."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from tasks.explain.events.event import Event

REACH = 1.5  # beyond a grid that a shape may lie
OVER = 7.0  # decay times after which nothing is left of a swing


@dataclass(frozen=True)
class Ringing(Event):
    """starts: (m,) s, rising. waves: (m, 6) complex, adding Re(wave·exp((2πi·f − 1/decay)·age)).

    frequency: Hz. decay: s.
    """

    starts: np.ndarray
    waves: np.ndarray
    frequency: float
    decay: float

    def applied(self, t: np.ndarray, predicted: np.ndarray, noise: np.ndarray) -> np.ndarray:
        rung = predicted.copy()
        last = np.searchsorted(self.starts, t, side="right") - 1
        lasts = OVER * self.decay
        first = np.searchsorted(self.starts, t - lasts, side="right")
        for back in range(int((last - first).max(initial=-1)) + 1):
            rows = np.flatnonzero(last - back >= first)
            which = last[rows] - back
            swing = swings(t[rows] - self.starts[which], self.frequency, self.decay)
            rung[rows] += (self.waves[which] * swing[:, None]).real
        return rung


def swings(age: np.ndarray, frequency: float, decay: float) -> np.ndarray:
    """exp((2πi·f − 1/decay)·age), complex (n,)."""
    return np.asarray(np.exp((2j * np.pi * frequency - 1 / decay) * age))


def fitted_waves(
    age: np.ndarray, left: np.ndarray, weight: np.ndarray, frequency: float, decay: float
) -> tuple[np.ndarray, np.ndarray]:
    """Waves (6,) complex of swings of the same shape, and the chi-squared (6,) that they gain.

    age: (n,) s since the start. left: (n, 6), 0 where not known. weight: (n, 6) one over the
    noise, 0 where not known.
    """
    swing = swings(age, frequency, decay)
    columns = np.column_stack([swing.real, -swing.imag])
    squares = weight**2
    right = columns.T @ (left * squares)  # (2, 6)
    products = np.einsum("ni,nj->nij", columns, columns).reshape(len(age), 4)
    normal = (products.T @ squares).T.reshape(6, 2, 2)
    parts = np.einsum("cij,jc->ci", np.linalg.pinv(normal, hermitian=True), right)
    return parts[:, 0] + 1j * parts[:, 1], np.einsum("ci,ic->c", parts, right)


def shape_of(
    age: np.ndarray,
    left: np.ndarray,
    weight: np.ndarray,
    frequencies: np.ndarray,
    decays: np.ndarray,
) -> tuple[float, float]:
    """Frequency (Hz) and decay (s) that gain most, from a grid and then closely."""

    def cost(log: np.ndarray) -> float:
        frequency, decay = np.exp(log)
        return -float(fitted_waves(age, left, weight, frequency, decay)[1].sum())

    grid = [(cost(np.log([f, d])), f, d) for f in frequencies for d in decays]
    _, frequency, decay = min(grid)
    best = minimize(cost, np.log([frequency, decay]), method="Nelder-Mead",
                    bounds=bounds_of(frequencies, decays),
                    options={"xatol": 1e-3, "fatol": 0.01, "maxiter": 80})  # fmt: skip
    frequency, decay = np.exp(best.x)
    return float(frequency), float(decay)


def bounds_of(frequencies: np.ndarray, decays: np.ndarray) -> list[tuple[float, float]]:
    """Logarithms that a search from a grid may reach."""
    return [
        (float(np.log(grid.min() / REACH)), float(np.log(grid.max() * REACH)))
        for grid in (frequencies, decays)
    ]
