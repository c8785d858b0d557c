"""What the scatter between the cells of a recording means for each finding of a fit."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tasks.explain.evidence.cells import CellEquations
from tasks.explain.evidence.dispersion import CellInfluence, cell_influence

MOST_PRIOR = 0.5  # of what is known of a parameter: with more of it the data do not determine it


@dataclass(frozen=True)
class Scatter:
    """A fit's findings and the equations of its cells.

    own: for each finding the columns (k,) that are its own; drifting: whether each is a random
    drift. prior: (q,) precision beforehand; values: (q,) that the columns are multiplied by.
    """

    cells: CellEquations
    own: tuple[np.ndarray, ...]
    drifting: tuple[bool, ...]
    prior: np.ndarray
    values: np.ndarray

    def dispersion(self, number: int) -> float:
        """φ ≥ 1: how much more the cells disagree on a finding than the fit's noise makes them."""
        return self._influences[number][1].dispersion

    def degrees(self, number: int) -> float:
        """Of freedom with which φ is known; infinite where it is one."""
        return self._influences[number][1].degrees

    def determined(self, number: int) -> np.ndarray:
        """Which of a finding's own columns (m,) the data determine, by their place among them."""
        return self._influences[number][0]

    def effective_cells(self, number: int) -> np.ndarray:
        """(m,) number of equal cells that would be as informative about each determined column."""
        return self._influences[number][1].effective_cells

    def information_by_cell(self, number: int) -> np.ndarray:
        """(cells,) share of the information on a finding's parameters that comes from each cell."""
        influence = self._influences[number][1]
        return np.einsum("ij,cji->c", influence.covariance, influence.by_cell)

    def u(self, number: int) -> np.ndarray:
        """(k,) standard uncertainties of its columns, by the cells' equations, with φ."""
        normal, right = self._equations
        influence = cell_influence(normal, right, self.own[number], self.prior, self.values)[0]
        return np.sqrt(np.maximum(np.diag(influence.covariance), 0.0) * self.dispersion(number))

    def change(self, number: int) -> np.ndarray:
        """(k,) by which the cells' optimum differs from the fit's values."""
        normal, right = self._equations
        return cell_influence(normal, right, self.own[number], self.prior, self.values)[1]

    def channel_dispersion(self, number: int, channel: int) -> float:
        """φ of a finding in one channel alone; where it does not touch it, of all its columns."""
        used = np.zeros((self.cells.cells, len(self.cells.grams)), bool)
        used[:, channel] = True
        read = self.cells.which[channel]
        own = np.intersect1d(self.own[number], read)
        own = own if len(own) else read
        return self._among(own, *self.cells.normal(used))[1].dispersion

    @cached_property
    def _equations(self) -> tuple[np.ndarray, np.ndarray]:
        return self.cells.normal()

    @cached_property
    def _influences(self) -> list[tuple[np.ndarray, CellInfluence]]:
        """For each finding its determined columns, and the influence of each cell on them.

        A random drift follows whatever the cells require: the influence of its channels' other
        columns shows how far the residual may be counted as noise.
        """
        random = [own for own, drifts in zip(self.own, self.drifting, strict=True) if drifts]
        steady = np.setdiff1d(np.arange(len(self.prior)), np.concatenate([*random, []]))
        return [
            self._among(self._beside(own, steady) if drifts else own, *self._equations)
            for own, drifts in zip(self.own, self.drifting, strict=True)
        ]

    def _beside(self, own: np.ndarray, steady: np.ndarray) -> np.ndarray:
        """The steady columns in the channels of some others."""
        read = [which for which in self.cells.which if np.isin(own, which).any()]
        return np.intersect1d(steady, np.concatenate([*read, []])).astype(int)

    def _among(
        self, own: Sequence[int] | np.ndarray, normal: np.ndarray, right: np.ndarray
    ) -> tuple[np.ndarray, CellInfluence]:
        own = np.asarray(own, int)
        influence = cell_influence(normal, right, own, self.prior, self.values)[0]
        variance = np.diag(influence.covariance)
        determined = np.flatnonzero((variance > 0) & (variance * self.prior[own] < MOST_PRIOR))
        if len(determined) < len(own):
            influence = cell_influence(normal, right, own[determined], self.prior, self.values)[0]
        return determined, influence
