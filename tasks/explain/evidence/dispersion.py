"""How much the cells of a recording disagree on some parameters, relative to their noise.

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

from tasks.model.regression import inverse

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
