"""Peer 2: forward stepwise regression by BIC over the generic library, channel by channel.

Noise has colour, so rows are whitened by the Allan variance first; the standard's columns are
refitted at every step. The penalty is the extended BIC's: with a library this large the plain one
alarms too often (Schwarz, Ann. Stat. 6, 1978; Chen & Chen, Biometrika 95, 2008).
"""

import numpy as np

from tests.proof.peers.naming import dimension_of, reading_of
from tests.proof.peers.observation import CHANNELS, SAME, Equations, Observation
from tests.proof.peers.peer import UNNAMED, Answer, Located, in_order
from tests.proof.peers.regression import partialled_out, predicted, unseen

THRESHOLD = 1.6  # gain of one column in ln n: the plain criterion asks for 1
MOST = 8  # columns of a channel

Step = tuple[int, float]  # library column, gain in ln n


def stepwise_bic(observation: Observation) -> Answer:
    """What each channel chooses; named where its columns have one fair reading."""
    steps = [[] if each is None else chosen(each, _rows(observation, c))
             for c, each in enumerate(observation.equations)]  # fmt: skip
    taken = [[step for step in one if step[1] > THRESHOLD] for one in steps]
    statistic = max((one[0][1] for one in steps if one), default=0.0)
    names, located = [], []
    for c, mine in enumerate(taken):
        for k, gain in mine:
            regressor = observation.equations[c].names[k]  # type: ignore[union-attr]
            names.append((gain, reading_of(c, regressor) or UNNAMED))
            located.append(Located(CHANNELS[c], dimension_of(regressor), regressor, gain))
    located.sort(key=lambda one: -one.strength)
    which = [[k for k, _ in mine] for mine in taken]
    found = predicted(observation, which) if names else None
    held_out = unseen(observation.equations, which)
    return Answer(statistic, THRESHOLD, tuple(located), in_order(names), found, held_out)


def _rows(observation: Observation, channel: int) -> int:
    return int((observation.observed.weight[:, channel] > 0).sum())


def chosen(equations: Equations, rows: int) -> list[Step]:
    """Columns in the order taken, with their gains; the first one whatever it gains."""
    whole = equations.without(None)
    normal, right, open_ = partialled_out(whole, equations.base)
    power = np.diag(whole)[equations.base : -1].copy()
    misfit = float(_rest(whole, equations.base))
    steps: list[Step] = []
    while len(steps) < MOST:
        size = np.diag(normal).copy()
        open_ = open_ & (size > SAME * power)
        gains = np.where(open_, right**2 / np.where(open_, size, 1.0), 0.0)
        best = int(np.argmax(gains))
        gain = rows * np.log(misfit / max(misfit - gains[best], 1e-300)) / np.log(rows)
        if steps and gain <= THRESHOLD:
            break
        steps.append((best, float(gain)))
        misfit -= gains[best]
        column = normal[:, best] / size[best]
        right = right - column * right[best]
        normal = normal - np.outer(column, normal[best])
        open_[best] = False
    return steps


def _rest(gram: np.ndarray, base: int) -> float:
    """Squared sum that the standard's columns alone leave."""
    shared = gram[:base, -1]
    return float(gram[-1, -1] - shared @ np.linalg.pinv(gram[:base, :base], 1e-11, True) @ shared)
