"""Damped oscillations from given starting times: the contribution of impacts and bursts."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.optimize import minimize

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import AddedSignal, amplitude_parameters, significant_channels
from tasks.explain.events.residual import Residual
from tasks.words import Message

BEYOND_GRID = 1.5  # times that a shape may lie beyond a grid
LIFETIME = 7.0  # decay times after which nothing is left of an oscillation
SIGNIFICANT = 4.0  # standard uncertainties from which a channel has the oscillation


@dataclass(frozen=True)
class Ringing:
    """Oscillations of one shape: starts (m,) s, rising, one complex amplitude (6,) of them all,
    and the chi-squared (6,) that it gains.

    Each adds Re(amplitude·exp((2πi·f − 1/decay)·age)). frequency: Hz. decay: s.
    """

    starts: np.ndarray
    amplitude: np.ndarray
    gain: np.ndarray
    frequency: float
    decay: float

    @property
    def channels(self) -> tuple[int, ...]:
        """The channels in which it is significant; at least the strongest."""
        return significant_channels(self.gain, SIGNIFICANT**2)

    def signal(self, t: np.ndarray) -> np.ndarray:
        """What the oscillations add to the readings (n, 6), in the channels that have them."""
        rung = np.zeros((len(t), 6))
        amplitude = np.where(np.isin(np.arange(6), self.channels), self.amplitude, 0.0)
        last = np.searchsorted(self.starts, t, side="right") - 1
        first = np.searchsorted(self.starts, t - LIFETIME * self.decay, side="right")
        for back in range(int((last - first).max(initial=-1)) + 1):
            rows = np.flatnonzero(last - back >= first)
            age = t[rows] - self.starts[last[rows] - back]
            rung[rows] += (amplitude * damped_wave(age, self.frequency, self.decay)[:, None]).real
        return rung

    def event(
        self, number: FoundParameter, relative_u: float, p_value: float, description: Message
    ) -> AddedSignal:
        """The event; number: of the oscillations. relative_u: of the decay time."""
        u = np.abs(self.amplitude) / np.sqrt(np.maximum(self.gain, 1e-300))
        u_frequency = relative_u / (2 * np.pi * self.decay)
        parameters = (
            number,
            FoundParameter(name="frequency", value=self.frequency, unit="Hz", u=u_frequency),
            FoundParameter(name="decay", value=self.decay, unit="s", u=relative_u * self.decay),
            *amplitude_parameters(self.channels, self.amplitude, u),
        )
        return AddedSignal(
            "unnamed", self.channels, parameters, p_value, description, (self.signal,)
        )


def damped_wave(age: np.ndarray, frequency: float, decay: float) -> np.ndarray:
    """exp((2πi·f − 1/decay)·age), complex (n,)."""
    return np.asarray(np.exp((2j * np.pi * frequency - 1 / decay) * age))


@dataclass(frozen=True)
class Aligned:
    """Rows after one of some starts: which (n,) of them, age (n,) s since then, and the values
    (n, 6) and weight (n, 6) of a residual."""

    start: np.ndarray
    age: np.ndarray
    values: np.ndarray
    weight: np.ndarray

    @classmethod
    def after(cls, starts: np.ndarray, residual: Residual, longest: float) -> Self:
        """The rows of a residual less than so long (s) after the last of the starts (m,) s."""
        last = np.searchsorted(starts, residual.t, side="right") - 1
        age = np.where(last >= 0, residual.t - starts[np.maximum(last, 0)], np.inf)
        rows = np.flatnonzero(age < longest)
        return cls(last[rows], age[rows], residual.values[rows], residual.weight[rows])

    def aged(self, age: np.ndarray) -> Self:
        """The same rows with other ages (n,), without those before their start."""
        begun = age >= 0
        return type(self)(self.start[begun], age[begun], self.values[begun], self.weight[begun])

    def amplitude(self, frequency: float, decay: float) -> tuple[np.ndarray, np.ndarray]:
        """Complex amplitude (6,) of oscillations of one shape, and the chi-squared it gains."""
        wave = damped_wave(self.age, frequency, decay)
        columns = np.column_stack([wave.real, -wave.imag])
        squares = self.weight**2
        right = columns.T @ (self.values * squares)  # (2, 6)
        products = np.einsum("ni,nj->nij", columns, columns).reshape(len(wave), 4)
        normal = (products.T @ squares).T.reshape(6, 2, 2)
        parts = np.einsum("cij,jc->ci", np.linalg.pinv(normal, hermitian=True), right)
        return parts[:, 0] + 1j * parts[:, 1], np.einsum("ci,ic->c", parts, right)

    def cost(self, log_shape: np.ndarray) -> float:
        """Chi-squared less what oscillations of a shape, log (frequency, decay), gain."""
        return -float(self.amplitude(*np.exp(log_shape))[1].sum())

    def shape(self, frequencies: np.ndarray, decays: np.ndarray) -> tuple[float, float]:
        """Frequency (Hz) and decay (s) that gain most, on a grid and then by a simplex search."""
        grid = [(self.cost(np.log([f, d])), f, d) for f in frequencies for d in decays]
        best = minimize(self.cost, np.log(min(grid)[1:]), method="Nelder-Mead",
                        bounds=log_bounds(frequencies, decays),
                        options={"xatol": 1e-3, "fatol": 0.01, "maxiter": 80})  # fmt: skip
        frequency, decay = np.exp(best.x)
        return float(frequency), float(decay)


def log_bounds(frequencies: np.ndarray, decays: np.ndarray) -> list[tuple[float, float]]:
    """Logarithms that a search from a grid may reach."""
    return [
        (float(np.log(grid.min() / BEYOND_GRID)), float(np.log(grid.max() * BEYOND_GRID)))
        for grid in (frequencies, decays)
    ]
