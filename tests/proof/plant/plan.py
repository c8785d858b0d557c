"""A whole run: segments in order, the table that runs them and how the unit is fixed on it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tests.proof.plant.segments import Segment, follow


@dataclass(frozen=True)
class TableShape:
    """Names and directions of the table's axes, from the base to the payload."""

    names: tuple[str, ...]
    directions: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Plan:
    """segments: what is done. mounts: quaternion (w, x, y, z) of each fixing, by its number."""

    standard: str
    table: TableShape
    segments: tuple[Segment, ...]
    mounts: tuple[tuple[float, float, float, float], ...]

    @cached_property
    def bounds(self) -> np.ndarray:
        """Times in s between the segments, from 0 to the end of the run."""
        return np.round(
            np.concatenate([[0.0], np.cumsum([segment.duration for segment in self.segments])]), 6
        )

    @property
    def duration(self) -> float:
        return float(self.bounds[-1])

    @cached_property
    def fixings(self) -> np.ndarray:
        """The number of the fixing in each segment."""
        return np.array([segment.fixing for segment in self.segments])

    def fixing_times(self) -> np.ndarray:
        """When each fixing begins, s."""
        changes = np.flatnonzero(np.diff(self.fixings)) + 1
        return self.bounds[np.concatenate([[0], changes])]

    def ends_of_moves(self) -> np.ndarray:
        """When each move to another position ends, s; changes of rate are not moves."""
        moved = [segment.goto is not None for segment in self.segments]
        return self.bounds[1:][np.array(moved)]

    def angles(self, t: np.ndarray) -> np.ndarray:
        """Demanded angles (axes, n) in rad at rising times; at rest before and after the run."""
        demanded = np.empty((len(self.table.names), len(t)))
        here = np.zeros(len(self.table.names))
        edges = np.searchsorted(t, self.bounds)
        demanded[:, : edges[0]] = here[:, None]
        for segment, begin, low, high in zip(
            self.segments, self.bounds, edges, edges[1:], strict=False
        ):
            demanded[:, low:high] = follow(segment, here, t[low:high] - begin)
            here = follow(segment, here, np.array([segment.duration]))[:, 0]
        demanded[:, edges[-1] :] = here[:, None]
        return demanded
