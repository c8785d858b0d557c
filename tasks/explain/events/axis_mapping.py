"""Axes exchanged or inverted between sensor and file: a signed permutation of a triad.

A working unit reads each axis along itself, to within a few degrees. A matrix that does so only
after some axes are exchanged or inverted tells which.
"""

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from schemas.discrepancy import FoundParameter
from schemas.recording import AXES
from tasks.explain.channels import CHANNELS, TRIADS
from tasks.explain.events.event import TRIAD_NAMES, Event
from tasks.explain.events.triad_matrix import TriadMatrix
from tasks.words import message

ALIGNED = np.radians(20.0)  # from the axis it should be on: a working unit, roughly fixed
ASTRAY = np.radians(60.0)  # from there: another axis, or the other way round
MATRICES = tuple(
    np.eye(3)[list(order)] * np.array(signs)[:, None]
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
)


@dataclass(frozen=True)
class AxisMapping(Event):
    """triad: 0 gyros, 1 accelerometers. matrix: (3, 3) that readings are multiplied by."""

    triad: int
    matrix: np.ndarray

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return self._by(predicted, self.matrix)

    def undone(self, readings: np.ndarray) -> np.ndarray:
        """Readings (n, 6) with each axis in its place."""
        return self._by(readings, self.matrix.T)

    def _by(self, readings: np.ndarray, matrix: np.ndarray) -> np.ndarray:
        changed = readings.copy()
        own = list(TRIADS[self.triad])
        changed[:, own] = readings[:, own] @ matrix.T
        return changed


def fitting(found: TriadMatrix) -> list[np.ndarray]:
    """The signed permutations with which a triad reads along its axes, fewest changes first."""
    if _astray(found, np.eye(3)) < ASTRAY:
        return [np.eye(3)]
    good = [matrix for matrix in MATRICES if _astray(found, matrix) < ALIGNED]
    return sorted(good, key=_changes)


def axis_mapping(triad: int, matrix: np.ndarray, with_mount: bool) -> AxisMapping:
    """The event of a signed permutation; with_mount: a wrongly stated mount would look the same."""
    rows = [row for row in range(3) if matrix[row, row] != 1.0]
    texts = []
    for row in rows:
        source = int(np.abs(matrix[row]).argmax())
        channel = message(f"channel-{CHANNELS[TRIADS[triad][row]]}")
        sign = "+" if matrix[row, source] > 0 else "−"
        texts.append(message("events-axis-reads", channel=channel, sign=sign, axis=AXES[source]))
    parameters = tuple(
        FoundParameter(name=f"{AXES[row]}{AXES[k]}", value=float(matrix[row, k]), unit="1", u=0.0)
        for row in rows for k in range(3) if matrix[row, k]
    )  # fmt: skip
    return AxisMapping(
        "axis_mapping", tuple(TRIADS[triad][row] for row in rows), parameters, 1e-12,
        message("events-axis-mapping", sensors=TRIAD_NAMES[triad], axes=tuple(texts)),
        triad, matrix, indistinguishable=("reference_frame",) if with_mount else (),
    )  # fmt: skip


def _astray(found: TriadMatrix, matrix: np.ndarray) -> float:
    """The largest angle between the response to an input and that of a permutation."""
    expected = matrix @ found.directions
    size = np.linalg.norm(found.reads, axis=0)
    cosine = np.sum(expected * found.reads, axis=0) / np.where(size > 0, size, 1.0)
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)).max())


def _changes(matrix: np.ndarray) -> tuple[int, int]:
    """How many axes are not read as they should be, and how many of them are inverted."""
    return int(3 - np.sum(np.diag(matrix) == 1.0)), int(np.sum(matrix < 0))
