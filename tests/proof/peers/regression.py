"""Algebra on normal equations that the regressions share: the standard's columns taken out first
(Frisch, Waugh and Lovell), fits, and what a fit is worth on segments that it did not see."""

from collections.abc import Sequence

import numpy as np

from tasks.explain.evidence.cells import DIFFUSE, FOLDS
from tests.proof.peers.observation import SAME, Equations, Observation
from tests.proof.peers.peer import HeldOut


def partialled_out(gram: np.ndarray, base: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gram (p, p) of the library without the standard's part, right side (p,), and which columns
    are more than what the standard tells."""
    shared = gram[:base, base:]
    rest = gram[base:, base:] - shared.T @ _solved(gram[:base, :base], shared)
    observation = np.diag(rest)[:-1] > SAME * np.diag(gram)[base:-1]
    return rest[:-1, :-1], rest[:-1, -1], observation


def fit(gram: np.ndarray, base: int, chosen: Sequence[int]) -> np.ndarray:
    """(m − 1,) coefficients of the standard's columns and the chosen ones; 0 elsewhere."""
    which = [*range(base), *(base + k for k in chosen)]
    values = np.zeros(len(gram) - 1)
    values[which] = _solved(gram[np.ix_(which, which)], gram[which, -1])
    return values


def _solved(normal: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Least squares of a normal matrix that may be short of rank: axes that never turned."""
    size = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    scaled = np.linalg.pinv(normal / size[:, None] / size, rcond=1e-11, hermitian=True)
    if right.ndim == 1:
        return np.asarray(scaled @ (right / size) / size)
    return np.asarray(scaled @ (right / size[:, None]) / size[:, None])


def surprise(equations: Equations, fold: int, chosen: Sequence[int]) -> tuple[float, float]:
    """What a fold is beside a fit to the others: squared misfit, and −2·ln of its likelihood.

    With e the error of prediction and C the covariance of what is fitted, eᵀ(1 + J·C·Jᵀ)⁻¹e is by
    how much the squared misfit grows when the fold is fitted, too, and |1 + J·C·Jᵀ| the ratio of
    the determinants of the normal matrices (recursive least squares).
    """
    which = [*range(equations.base), *(equations.base + k for k in chosen)]
    whole = equations.without(None)
    size = np.sqrt(np.maximum(np.diag(whole)[which], 1e-300))
    square = likelihood = 0.0
    for gram, sign in ((whole, 1.0), (equations.without(fold), -1.0)):
        normal = gram[np.ix_(which, which)] / size[:, None] / size + DIFFUSE * np.eye(len(which))
        right = gram[which, -1] / size
        square += sign * float(gram[-1, -1] - right @ np.linalg.solve(normal, right))
        likelihood += sign * float(np.linalg.slogdet(normal)[1])
    return square, square + likelihood


def unseen(equations: Sequence[Equations | None], chosen: Sequence[Sequence[int]]) -> HeldOut:
    """What the chosen columns of each channel are worth on folds that the fit did not see."""
    before, after, gain = 0.0, 0.0, 0.0
    for each, mine in zip(equations, chosen, strict=True):
        if each is None or not mine:
            continue
        for fold in range(FOLDS):
            plain, better = surprise(each, fold, ()), surprise(each, fold, mine)
            before, after = before + plain[0], after + better[0]
            gain += 0.5 * (plain[1] - better[1])
    return HeldOut(float(np.sqrt(after / before)) if before > 0.0 else 1.0, gain)


def predicted(observation: Observation, chosen: Sequence[Sequence[int]]) -> np.ndarray:
    """(n, 6) the standard's model with the chosen columns of each channel, fitted together."""
    found = observation.nominal.copy()
    for c, mine in enumerate(chosen):
        equations = observation.equations[c]
        if equations is None or not mine:
            continue
        values = fit(equations.without(None), equations.base, mine) / equations.scale
        found[:, c] += observation.standard[c] @ values[: equations.base]
        for k in mine:
            found[:, c] += values[equations.base + k] * observation.library[equations.names[k]]
    return found
