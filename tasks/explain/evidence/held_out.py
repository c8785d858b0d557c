"""How well a model predicts segments that its fit did not use: every fourth one, in turn."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tasks.explain.evidence.cells import CellEquations
from tasks.model.regression import WhitenedEquations

FOLDS = 4
HiddenChannel = tuple[float, np.ndarray, np.ndarray]  # misfit, gradient (q,), normal (q, q)
DIFFUSE = 1e-9  # of a column's power: what no other fold determines is as good as free


@dataclass(frozen=True)
class CrossValidation:
    """A model's normal equations on all rows, and on each fold of them."""

    whole: WhitenedEquations
    folds: tuple[WhitenedEquations, ...]

    def deviance(self, fitted: Sequence[int], values: np.ndarray, prior: np.ndarray) -> np.ndarray:
        """−2·ln of the likelihood (6,) of each channel of a fold, as a fit to the others has it.

        What the others leave uncertain is uncertain in the prediction: e ~ N(0, 1 + J·C·Jᵀ).
        fitted: the columns that are fitted. values: (q,) of columns that are put back into the
        misfit first. prior: (q,) precision beforehand, of changes about `values`.
        """
        total = np.zeros(len(self.whole.grams))
        for known, channels in self._hidden(fitted, values, prior):
            total += [_deviance(known, *channel) for channel in channels]
        return total

    def joint_deviance(
        self, fitted: Sequence[int], values: np.ndarray, prior: np.ndarray
    ) -> tuple[float, np.ndarray]:
        """The same of all channels of a fold together; and of each channel (6,), where the others
        of the fold are known too. An uncertainty that channels share counts once so, and in
        `deviance` in each of them.
        """
        together, beside = 0.0, np.zeros(len(self.whole.grams))
        for known, channels in self._hidden(fitted, values, prior):
            whole = _deviance(known, *_summed(channels))
            together += whole
            for number in range(len(channels)):
                others = [one for c, one in enumerate(channels) if c != number]
                beside[number] += whole - _deviance(known, *_summed(others))
        return together, beside

    def _hidden(
        self, fitted: Sequence[int], values: np.ndarray, prior: np.ndarray
    ) -> Iterator[tuple[np.ndarray, list[HiddenChannel]]]:
        """Of each fold the information that the others have on the fitted columns, and its own
        equations, channel by channel; columns at unit size.
        """
        rows = list(fitted)
        whole, whole_right, _ = self.whole.normal()
        power = np.diag(whole)[rows] + prior[rows]
        scale = 1.0 / np.sqrt(np.maximum(power, 1e-300))
        least = np.diag(np.full(len(rows), DIFFUSE))
        for fold in self.folds:
            hidden, hidden_right, _ = fold.normal()
            normal, right = whole - hidden, whole_right - hidden_right
            right = right + normal @ values
            known = normal[np.ix_(rows, rows)] + np.diag(prior[rows])
            known = known * scale[:, None] * scale + least
            change = values.copy()
            change[rows] -= scale * np.linalg.solve(known, scale * right[rows])
            channels = []
            for gram, which in zip(fold.grams, fold.which, strict=True):
                left = np.append(change[which], 1.0)
                gradient, more = np.zeros(fold.count), np.zeros((fold.count, fold.count))
                gradient[which] = gram[:-1] @ left
                more[np.ix_(which, which)] = gram[:-1, :-1]
                own = more[np.ix_(rows, rows)] * scale[:, None] * scale
                channels.append((float(left @ gram @ left), scale * gradient[rows], own))
            yield known, channels


def _summed(channels: Sequence[HiddenChannel]) -> HiddenChannel:
    misfits, gradients, normals = zip(*channels, strict=True)
    return sum(misfits), np.sum(gradients, axis=0), np.sum(normals, axis=0)


def _deviance(known: np.ndarray, misfit: float, gradient: np.ndarray, normal: np.ndarray) -> float:
    """Of readings with these equations (q,), (q, q), beside what is known (q, q) beforehand."""
    both = known + normal
    volume = np.linalg.slogdet(both)[1] - np.linalg.slogdet(known)[1]
    return float(misfit - gradient @ np.linalg.solve(both, gradient) + volume)


def cross_validation(cells: CellEquations) -> CrossValidation:
    """Every fourth cell is a fold. cells: of `fold_cells`."""
    number = np.arange(cells.cells) % FOLDS
    folds = tuple(
        WhitenedEquations(
            tuple(part[number == k].sum(axis=0) for part in cells.grams), cells.which, cells.count
        )
        for k in range(FOLDS)
    )
    whole = tuple(part.sum(axis=0) for part in cells.grams)
    return CrossValidation(WhitenedEquations(whole, cells.which, cells.count), folds)
