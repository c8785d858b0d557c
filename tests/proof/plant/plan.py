"""A whole run: legs in order, the table that runs them and how the unit is fixed on it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tests.proof.plant.legs import Leg, follow


@dataclass(frozen=True)
class TableShape:
    """Names and directions of the table's axes, from the base to the payload."""

    names: tuple[str, ...]
    directions: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Plan:
    """legs: what is done. mounts: quaternion (w, x, y, z) of each fixing, by its number."""

    standard: str
    table: TableShape
    legs: tuple[Leg, ...]
    mounts: tuple[tuple[float, float, float, float], ...]

    @cached_property
    def bounds(self) -> np.ndarray:
        """Times in s between the legs, from 0 to the end of the run."""
        return np.round(np.concatenate([[0.0], np.cumsum([leg.duration for leg in self.legs])]), 6)

    @property
    def duration(self) -> float:
        return float(self.bounds[-1])

    @cached_property
    def fixings(self) -> np.ndarray:
        """The number of the fixing in each leg."""
        return np.array([leg.fixing for leg in self.legs])

    def fixing_times(self) -> np.ndarray:
        """When each fixing begins, s."""
        changes = np.flatnonzero(np.diff(self.fixings)) + 1
        return self.bounds[np.concatenate([[0], changes])]

    def ends_of_moves(self) -> np.ndarray:
        """When each move to another position ends, s; changes of rate are not moves."""
        moved = [leg.goto is not None for leg in self.legs]
        return self.bounds[1:][np.array(moved)]

    def angles(self, t: np.ndarray) -> np.ndarray:
        """Demanded angles (axes, n) in rad at rising times; at rest before and after the run."""
        demanded = np.empty((len(self.table.names), len(t)))
        here = np.zeros(len(self.table.names))
        edges = np.searchsorted(t, self.bounds)
        demanded[:, : edges[0]] = here[:, None]
        for leg, begin, low, high in zip(self.legs, self.bounds, edges, edges[1:], strict=False):
            demanded[:, low:high] = follow(leg, here, t[low:high] - begin)
            here = follow(leg, here, np.array([leg.duration]))[:, 0]
        demanded[:, edges[-1] :] = here[:, None]
        return demanded
