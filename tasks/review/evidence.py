"""Each run's evidence for an effect, in coordinates of the mean information."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

DETERMINED = 1e-4  # of a parameter's information that is left beside the effect's others


@dataclass(frozen=True)
class Evidence:
    """Score (runs, m) and information (runs, m, m) in coordinates in which the mean information of
    the runs is one. back: (parameters, m) from these coordinates to SI. unit: (runs,) number of the
    unit, from 0.
    """

    score: np.ndarray
    information: np.ndarray
    back: np.ndarray
    unit: np.ndarray

    @property
    def size(self) -> int:
        return int(self.score.shape[1])

    def of(self, rows: np.ndarray) -> "Evidence":
        """Of some runs (runs,) bool alone, in the same coordinates."""
        information = self.information * rows[:, None, None]
        return Evidence(self.score * rows[:, None], information, self.back, self.unit)

    @cached_property
    def units(self) -> int:
        """How many units have runs."""
        return int(self.unit.max()) + 1

    @cached_property
    def of_each_unit(self) -> csr_array:
        """(units, runs) 1 where a run is of a unit."""
        return self.of_units(np.ones((1, len(self.unit)), bool))

    def of_units(self, rows: np.ndarray) -> csr_array:
        """(w · units, runs) 1 where a run of a unit is in a window; rows: (w, runs) bool."""
        window, run = np.nonzero(rows)
        place = window * self.units + self.unit[run]
        size = (len(rows) * self.units, len(self.unit))
        return csr_array((np.ones(len(run)), (place, run)), size)


def at_unit_information(score: np.ndarray, information: np.ndarray, unit: np.ndarray) -> Evidence:
    """Evidence without what no run determines."""
    seen = int(information.any(axis=(1, 2)).sum())
    back = back_from_unit_information(information.sum(axis=0) / max(1, seen))
    turned = information.reshape(len(score), -1) @ np.kron(back, back)  # of all runs at once
    return Evidence(score @ back, turned.reshape(len(score), *[back.shape[1]] * 2), back, unit)


def back_from_unit_information(mean: np.ndarray) -> np.ndarray:
    """(parameters, m) from coordinates in which a mean information is one to SI."""
    size = np.sqrt(np.diag(mean))
    scale = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0)
    values, vectors = np.linalg.eigh(mean * scale[:, None] * scale)
    kept = values > DETERMINED
    return np.asarray(scale[:, None] * vectors[:, kept] / np.sqrt(values[kept]))


def solved(information: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solutions of symmetric systems (…, m, m), (…, m); what nothing determines is zero."""
    return np.asarray(np.linalg.solve(ridged(information), right[..., None])[..., 0])


def ridged(information: np.ndarray) -> np.ndarray:
    """Information (…, m, m) with a little of its own size on the diagonal."""
    ridge = 1e-9 + 1e-6 * np.einsum("...ii->...", information)[..., None, None]
    return np.asarray(information + ridge * np.eye(information.shape[-1]))
