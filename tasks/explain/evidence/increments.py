"""Whether a random walk walks: its increments are alike throughout, where a signal that switches to
and fro (random telegraph noise) changes at a few moments only.
"""

from collections.abc import Sequence
from math import comb

import numpy as np

from tasks.explain.evidence.shares import without_name
from tasks.explain.explanation import Finding, Refusal
from tasks.model.terms.memory import BIAS_RANDOM_WALK

INTERVALS = 20  # of a run, whose increments are compared
LARGEST = 2  # increments: there and back
CHANCE = 0.01  # that so much of a walk's power is in them


def without_switching(findings: Sequence[Finding]) -> list[Finding]:
    """The findings, random walks without a name that change at two moments in every channel."""
    return [
        without_name(one, Refusal("switching", one.effect))
        if one.effect == BIAS_RANDOM_WALK.name and _switches(one)
        else one
        for one in findings
    ]


def _switches(walk: Finding) -> bool:
    chances = [chance_of_largest(walk.contribution[:, channel]) for channel in walk.channels]
    return max(chances, default=1.0) < CHANCE


def chance_of_largest(walk: np.ndarray) -> float:
    """Bound of the p value that two of the increments of a walk (n,) have so much of the power.

    Of N independent normal increments the share x of given two has a beta distribution:
    P(x > a) = (1 − a)^((N − 2)/2); by Bonferroni for every pair.
    """
    known = np.flatnonzero(np.isfinite(walk))
    if len(known) <= INTERVALS:
        return 1.0
    at = np.linspace(0.0, len(walk) - 1.0, INTERVALS + 1)
    power = np.sort(np.diff(np.interp(at, known, walk[known])) ** 2)
    total = float(power.sum())
    if not total:
        return 1.0
    rest = 1.0 - float(power[-LARGEST:].sum()) / total
    return min(1.0, comb(INTERVALS, LARGEST) * max(rest, 0.0) ** (0.5 * (INTERVALS - LARGEST)))
