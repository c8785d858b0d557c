"""An error as a term with a prior, what it does to the segment means, and all those of a run."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tasks.uncertainty.budget import Contribution, InputQuantity
from tasks.uncertainty.equipment import NOBODY

LEAST_SHARE = 1e-6  # of the largest line of a budget: rounding, not a line of its own

Scope = Literal["run", "mounting", "face", "angle", "setting", "point"]


@dataclass(frozen=True)
class ErrorSource:
    """One error of the equipment: its prior, its scope, and what it does to the means.

    effects: (m, n, 6), of each of its m independent draws on the n segment means of six channels,
    rad/s and m/s² per unit. followed: by parameters of the unit, as the rate is by a scale factor:
    nothing of it is left of a fit. of_latitude: it acts only where Earth's rotation is taken off.
    """

    quantity: InputQuantity
    scope: Scope
    effects: np.ndarray
    followed: bool = False
    of_latitude: bool = False

    def line(self, weights: np.ndarray, channels: np.ndarray, segments: np.ndarray) -> Contribution:
        """The line in the budget of Σ o·U: independent draws count as root of the sum of their
        squares.

        weights: o of some channels (c,) in some segments (k,), (c, k); of all others it is zero.
        """
        felt = np.einsum("mnc,cn->m", self.effects[:, segments[:, None], channels], weights)
        if len(felt) == 1 or not felt.any():
            return Contribution(self.quantity, float(felt[0]))
        squares = felt**2
        draws = squares.sum() ** 2 / (squares**2).sum()  # Kish's effective number
        return Contribution(self.quantity, float(np.sqrt(squares.sum())), float(draws))


@dataclass(frozen=True)
class EquipmentErrors:
    """Every error of the equipment of a run with so many segments."""

    sources: tuple[ErrorSource, ...]
    segments: int

    def lines(self, operator: np.ndarray, without_earth: bool) -> tuple[Contribution, ...]:
        """The lines of Σ o·U, o (6, n), but rounding; without_earth: Earth's rate was taken off."""
        channels, segments = (np.flatnonzero(operator.any(axis=axis)) for axis in (1, 0))
        weights = operator[np.ix_(channels, segments)]
        every = [
            each.line(weights, channels, segments)
            for each in self.sources
            if without_earth or not each.of_latitude
        ]
        sizes = [abs(line.sensitivity) * line.quantity.u for line in every]
        least = LEAST_SHARE * max(sizes, default=0.0)
        return tuple(line for line, size in zip(every, sizes, strict=True) if size > least)

    def covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means by what no parameter of the unit follows."""
        total = np.zeros((self.segments, self.segments))
        for each in self.sources:
            if not each.followed and each.quantity.source != NOBODY:
                effects = each.effects[:, :, channel]
                total += each.quantity.u**2 * (effects.T @ effects)
        return total
