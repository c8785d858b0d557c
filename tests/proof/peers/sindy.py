"""Peer 3: sparse regression of what the standard leaves on a polynomial library (SINDy).

pysindy's sequentially thresholded least squares (Brunton, Proctor & Kutz, PNAS 113, 2016), its
threshold by cross validation on held-out segments. Columns are whitened, cleared of the standard's
part and brought to unit size, so that a coefficient is in standard deviations of the noise; the
Cholesky factor of their normal equations stands for the rows, with the same least squares.
"""

import warnings
from collections.abc import Sequence

import numpy as np
from pysindy import STLSQ

from tasks.explain.evidence.cells import FOLDS
from tests.proof.peers.naming import dimension_of, reading_of
from tests.proof.peers.observation import CHANNELS, Equations, Observation
from tests.proof.peers.peer import UNNAMED, Answer, Located, in_order
from tests.proof.peers.regression import partialled_out, predicted, surprise, unseen

THRESHOLD = 3.0  # nats gained on held-out segments by the best channel
GRID = (4.0, 6.0, 10.0, 20.0, 50.0)  # standard deviations a coefficient must have
RIDGE = 0.01  # of a column's power
DEPENDENT = 1e-8  # of a column's power: rounding

Reduced = tuple[np.ndarray, np.ndarray, np.ndarray]


def sindy(observation: Observation) -> Answer:
    """What each channel's sparse model holds; named where its columns have one fair reading."""
    gains, names, located = [0.0], [], []
    which: list[list[int]] = []
    for c, each in enumerate(observation.equations):
        gain, mine = (0.0, []) if each is None else _best(each, observation)
        gains.append(gain)
        if each is None or gain <= THRESHOLD:
            which.append([])
            continue
        which.append(mine)
        for k, size in zip(mine, _sizes(each, mine), strict=True):
            names.append((size**2, reading_of(c, each.names[k]) or UNNAMED))
            located.append(Located(CHANNELS[c], dimension_of(each.names[k]), each.names[k], size))
    located.sort(key=lambda one: -one.strength)
    found = predicted(observation, which) if names else None
    held_out = unseen(observation.equations, which)
    return Answer(max(gains), THRESHOLD, tuple(located), in_order(names), found, held_out)


def _best(equations: Equations, observation: Observation) -> tuple[float, list[int]]:
    """Nats gained on held-out segments, and the columns, at the threshold where that is most."""
    allowed = [k for k, name in enumerate(equations.names) if name in observation.polynomial_names]
    gains = np.zeros(len(GRID))
    for fold in range(FOLDS):
        plain = surprise(equations, fold, ())[1]
        reduced = _reduced(equations.without(fold), equations.base, allowed)
        for n, threshold in enumerate(GRID):
            mine = _sparse(reduced, threshold)
            if mine:
                gains[n] += 0.5 * (plain - surprise(equations, fold, mine)[1])
    best = int(np.argmax(gains))
    whole = _reduced(equations.without(None), equations.base, allowed)
    return float(gains[best]), _sparse(whole, GRID[best])


def _reduced(gram: np.ndarray, base: int, allowed: Sequence[int]) -> Reduced:
    """Rows (r, k) and readings (r,) with the same least squares as all blocks; the columns."""
    normal, right, open_ = partialled_out(gram, base)
    mine = np.array([k for k in allowed if open_[k]], int)
    size = np.sqrt(np.diag(normal)[mine])
    power, turned = np.linalg.eigh(normal[np.ix_(mine, mine)] / size[:, None] / size)
    kept = power > DEPENDENT
    rows = np.sqrt(power[kept])[:, None] * turned[:, kept].T
    return rows, turned[:, kept].T @ (right[mine] / size) / np.sqrt(power[kept]), mine


def _sparse(reduced: Reduced, threshold: float) -> list[int]:
    """The columns that are left at one threshold."""
    rows, readings, mine = reduced
    if not len(mine):
        return []
    optimiser = STLSQ(threshold=threshold, alpha=RIDGE, unbias=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that a threshold leaves nothing is an answer
        optimiser.fit(rows, readings[:, None])
    return [int(k) for k in mine[np.flatnonzero(optimiser.coef_[0])]]


def _sizes(equations: Equations, mine: Sequence[int]) -> list[float]:
    """Each column's strength: its coefficient in standard deviations, all fitted together."""
    normal, right, _ = partialled_out(equations.without(None), equations.base)
    block = np.linalg.pinv(normal[np.ix_(mine, mine)], rcond=1e-11, hermitian=True)
    spread = np.sqrt(np.maximum(np.diag(block), 1e-300))
    return [float(size) for size in np.abs(block @ right[mine]) / spread]
