"""What the scatter between the cells of a recording means for each finding of a fit.

How much the cells of a recording disagree on some parameters, relative to their noise.

The covariance of a fit in a wrong model is the sandwich: the scatter between independent cells of
what each cell asks of the parameters. With few cells a plain sandwich is too small by what each
cell took part in the fit; that is made up for (Bell and McCaffrey 2002, bias-reduced
linearisation). The other columns are projected out first (Frisch, Waugh, Lovell).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import chi2

from tasks.explain.evidence.cells import CellEquations
from tasks.model.fit import inverse

MOST_PRIOR = 0.5  # of what is known of a parameter: with more of it the data do not determine it
CHANCE = 1e-3  # that cells scatter so far by noise alone: from there on they are believed
WITHIN = 1.3  # of the variance of noise: nearer to it a model of the noise is right
MOST_LEVERAGE = 0.98  # of one cell: what it alone determines cannot be held against others


@dataclass(frozen=True)
class CellInfluence:
    """What each cell asks of k parameters beside all the others of a fit.

    information: (k, k) of all cells and what is known beforehand. by_cell: (cells, k, k) of each.
    scores: (cells, k) by which a cell pulls the parameters off their common values.
    """

    information: np.ndarray
    by_cell: np.ndarray
    scores: np.ndarray

    @cached_property
    def covariance(self) -> np.ndarray:
        """(k, k) as the noise of the model has it."""
        return inverse(self.information)

    @cached_property
    def effective_cells(self) -> np.ndarray:
        """(k,) number of equal cells that would carry as much information on each parameter."""
        shares = np.diagonal(self.by_cell, axis1=1, axis2=2)
        squares = (shares**2).sum(axis=0)
        return np.divide(
            shares.sum(axis=0) ** 2, squares, out=np.zeros(len(squares)), where=squares > 0
        )

    @cached_property
    def _root(self) -> np.ndarray:
        """(k, k) root of the covariance as the noise of the model has it."""
        values, vectors = np.linalg.eigh(self.covariance)
        return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T)

    @cached_property
    def scatter(self) -> np.ndarray:
        """(k, k) covariance by the scatter of the cells, in units in which `covariance` is one."""
        root = self._root
        leverage = root @ self.by_cell @ root
        own, turned = np.linalg.eigh(leverage)
        stretched = 1.0 / np.sqrt(1.0 - np.clip(own, 0.0, MOST_LEVERAGE))
        asked = np.einsum("cji,cj->ci", turned, self.scores @ root) * stretched
        pulls = np.einsum("cij,cj->ci", turned, asked)
        return np.asarray(pulls.T @ pulls)

    @cached_property
    def robust_covariance(self) -> np.ndarray:
        """(k, k) by the scatter of the cells."""
        return np.asarray(self._root @ self.scatter @ self._root)

    @property
    def dispersion(self) -> float:
        """φ: the mean of the scatter beside the model's; 1 where chance might have made it."""
        return self._dispersion[0]

    @property
    def degrees(self) -> float:
        """Of freedom with which φ is known; infinite where it is one."""
        return self._dispersion[1]

    @cached_property
    def _dispersion(self) -> tuple[float, float]:
        count = int((np.diag(self.covariance) > 0).sum())
        if not count:
            return 1.0, np.inf
        ratio = float(np.trace(self.scatter)) / count
        degrees = max(float(self.effective_cells.sum()), 1.0)
        believed = ratio > WITHIN and chi2.sf(ratio * degrees, degrees) < CHANCE
        return (ratio, degrees) if believed else (1.0, np.inf)


def cell_influence(
    normal: np.ndarray,
    right: np.ndarray,
    own: Sequence[int] | np.ndarray,
    prior: np.ndarray,
    values: np.ndarray,
) -> tuple[CellInfluence, np.ndarray]:
    """What each cell asks of some parameters, and their change (k,) to the common optimum.

    normal, right: (cells, q, q) and (cells, q) of a model linearised at `values` (q,); prior: (q,)
    precision beforehand, of values about zero.
    """
    whole = normal.sum(axis=0) + np.diag(prior)
    mine = np.asarray(own, int)
    others = np.setdiff1d(np.arange(len(prior)), mine)
    change = inverse(whole) @ (right.sum(axis=0) - prior * values)
    left = right - normal @ change
    project = np.zeros((len(mine), len(prior)))
    project[np.arange(len(mine)), mine] = 1.0
    if len(others):
        rest = inverse(whole[np.ix_(others, others)])
        project[:, others] = -whole[np.ix_(mine, others)] @ rest
    influence = CellInfluence(
        information=project @ whole @ project.T,
        by_cell=project @ normal @ project.T,
        scores=left @ project.T,
    )
    return influence, change[mine]


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
