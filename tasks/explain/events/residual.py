"""The residual of a regression, weighted by its noise."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from tasks.explain.events.event import Event
from tasks.motion.whole import Motion


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
