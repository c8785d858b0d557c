"""The share of the mismatch that each finding removes, and which shares deserve an entry.

Whether a random walk walks: its increments are alike throughout, where a signal that switches to
and fro (random telegraph noise) changes at a few moments only.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import comb

import numpy as np

from tasks.explain.evidence.form_errors import without_name
from tasks.explain.evidence.left_over import LeftOver
from tasks.explain.explanation import UNNAMED, Finding, Refusal
from tasks.model.terms.memory import BIAS_RANDOM_WALK

SMALL = 0.02  # of the mismatch above noise: an engineer looks elsewhere first
MOSTLY_NOISE = 1.5  # chi-squared per degree of freedom up to which an account is complete
INTERVALS = 20  # of a run, whose increments are compared
LARGEST = 2  # increments: there and back
CHANCE = 0.01  # that so much of a walk's power is in them


def with_shares(
    findings: Sequence[Finding], removed: Sequence[float], left: LeftOver
) -> list[Finding]:
    """The findings with the share of the mismatch above noise that each removes, largest first.

    removed: by each, chi-squared at the unit's rows.
    """
    mismatch = max(left.removed + left.remaining, 1e-300)
    shares = np.clip(np.array(removed) / mismatch, 0.0, left.explained_share)
    findings = [replace(one, share=float(each)) for one, each in zip(findings, shares, strict=True)]
    return sorted(findings, key=lambda one: (-one.share, -one.gain))


def small_remainder(finding: Finding, left: LeftOver) -> bool:
    """Whether a finding deserves only one line: it removes little, and has no name or leaves more
    unexplained in its channels.

    Faults of a logger or limit have tests of their own and are repaired on their own, whatever
    share of the mismatch is in the few rows they spoilt: they are always reported.
    """
    if not finding.terms and finding.effect != UNNAMED:
        return False
    after = left.chi2_per_degree[list(finding.channels)]
    complete = bool((np.nan_to_num(after) < MOSTLY_NOISE).all())
    return finding.share < SMALL and (finding.effect == UNNAMED or not complete)


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
