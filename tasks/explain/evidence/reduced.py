"""The evidence of a smaller model by the equations of a larger one, without fitting it.

What a finding adds is put back into the misfit, its columns are left out, and the others change to
where the normal equations of the rest have their optimum: all of it linear in the columns and the
misfit, so that their products change by a congruence. A term that is not linear in its parameters,
or has a shape, is taken as linear about the fit of the larger model; how far that holds, the
smaller model's own fit tells.
"""

from dataclasses import dataclass, replace

import numpy as np

from tasks.explain.evidence.cells import CellEquations, CrossValidation
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.scatter import Scatter
from tasks.explain.search.fitted import FittedSelection
from tasks.model.model import Model
from tasks.model.regression import WhitenedEquations, inverse
from tasks.model.term import parameters_of


@dataclass(frozen=True)
class _Change:
    """kept: (k,) the columns that stay, in order. added: (q,) by which every column, times it, is
    put back into the misfit: of those left out what they add now, of the others less their change.
    """

    kept: np.ndarray
    added: np.ndarray

    def of_channel(self, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The matrix (k + 1, m + 1) by which a channel's products change from both sides, and
        which of the columns that stay it has. which: (m,) those that it has now.
        """
        own = np.flatnonzero(np.isin(which, self.kept))
        turn = np.zeros((len(own) + 1, len(which) + 1))
        turn[np.arange(len(own)), own] = 1.0
        turn[-1, :-1], turn[-1, -1] = self.added[which], 1.0
        return turn, np.searchsorted(self.kept, which[own])

    def of_equations(self, equations: WhitenedEquations) -> WhitenedEquations:
        pairs = zip(equations.grams, equations.which, strict=True)
        changed = [(gram, *self.of_channel(which)) for gram, which in pairs]
        return WhitenedEquations(
            tuple(turn @ gram @ turn.T for gram, turn, _ in changed),
            tuple(which for _, _, which in changed),
            len(self.kept),
        )

    def of_cells(self, cells: CellEquations) -> CellEquations:
        """Of every cell."""
        as_one = self.of_equations(WhitenedEquations(cells.grams, cells.which, cells.count))
        return CellEquations(as_one.grams, as_one.which, as_one.count)


def without(evidence: Evidence, number: int) -> Evidence:
    """The evidence of all findings but one, by the equations of all of them.

    What would become negative where no unit has it so is left out as well.
    """
    free = np.flatnonzero(evidence.fit.model.free)
    one_sided = np.zeros(evidence.whole.count, bool)
    one_sided[: len(free)] = _lowest(evidence.fit.model)[free] == 0.0
    left_out = np.isin(np.arange(evidence.whole.count), evidence.own[number][0])
    while True:
        change = _change(evidence, left_out)
        values = evidence.scatter.values - change.added
        below = ~left_out & one_sided & (values < 0.0)
        if not below.any():
            return _reduced(evidence, number, change)
        left_out |= below


def _lowest(model: Model) -> np.ndarray:
    """(p,) the lower end of each parameter's plausible range."""
    return np.array([p.plausible[0] for p in parameters_of(model.terms)])


def _change(evidence: Evidence, left_out: np.ndarray) -> _Change:
    """How the rest changes without some columns (q,) bool."""
    normal, right, _ = evidence.whole.normal()
    values, prior = evidence.scatter.values, evidence.prior
    added = np.where(left_out, values, 0.0)
    fitted = ~left_out
    fitted[list(evidence.known)] = False
    rows = np.flatnonzero(fitted)
    pull = (right + normal @ added - prior * values)[rows]
    added[rows] = -inverse(normal[np.ix_(rows, rows)] + np.diag(prior[rows])) @ pull
    return _Change(np.flatnonzero(~left_out), added)


def _reduced(evidence: Evidence, number: int, change: _Change) -> Evidence:
    kept = change.kept
    values = (evidence.scatter.values - change.added)[kept]
    stay = [n for n in range(len(evidence.groups)) if n != number]
    groups = tuple(evidence.groups[n] for n in stay)
    place = {q: k for k, q in enumerate(kept.tolist())}
    own = [[place[q] for q in evidence.own[n][0] if q in place] for n in stay]
    whole, prior = change.of_equations(evidence.whole), evidence.prior[kept]
    folds = CrossValidation(
        change.of_equations(evidence.folds.whole),
        tuple(map(change.of_equations, evidence.folds.folds)),
    )
    scatter = Scatter(
        change.of_cells(evidence.scatter.cells),
        tuple(np.array(mine, int) for mine in own),
        tuple(group.random for group in groups),
        prior,
        values,
    )
    return Evidence(
        _fit(evidence, number, kept, values, whole.normal()[0] + np.diag(prior)),
        groups,
        whole,
        folds,
        scatter,
        tuple((mine, values[mine]) for mine in own),
        tuple(place[q] for q in evidence.known if q in place),
        prior,
        evidence.smoothing_error[kept],
    )


def _fit(
    evidence: Evidence, number: int, kept: np.ndarray, values: np.ndarray, normal: np.ndarray
) -> FittedSelection:
    """The selection without a finding, its model where the equations have their optimum.

    normal: (k, k) of the columns that stay, with what is known beforehand.
    """
    fit, group = evidence.fit, evidence.groups[number]
    keys = {one.candidate.key for one in group.selected}
    selected = tuple(one for one in fit.selection.selected if one.candidate.key not in keys)
    model, free = fit.model, np.flatnonzero(fit.model.free)
    rows = free[kept[kept < len(free)]]
    moved, still_free = np.zeros(len(model.values)), np.zeros(len(model.values), bool)
    moved[~model.free] = model.values[~model.free]
    moved[rows], still_free[rows] = values[: len(rows)], True
    covariance = np.zeros_like(model.covariance)
    covariance[np.ix_(rows, rows)] = inverse(normal[: len(rows), : len(rows)])
    smaller = replace(model, values=moved, free=still_free, covariance=covariance)
    smaller = smaller.without({term.key for term in group.terms})
    selection = replace(fit.selection, selected=selected)
    return replace(fit, selection=selection, model=smaller)
