"""The share of the mismatch that each finding removes, and which shares deserve an entry.

A drift states its size. Whether a random walk walks: its increments are alike throughout, where a
signal that switches to and fro (random telegraph noise) changes at a few moments only; they are no
larger than those of working units, and no slow error of the reference's attitude.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import comb

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import CHANNELS
from tasks.explain.evidence.form_errors import without_name
from tasks.explain.evidence.left_over import LeftOver
from tasks.explain.explanation import UNNAMED, Finding, Refusal
from tasks.explain.odds import COVERAGE
from tasks.explain.search.empirical_terms import READINGS, SLOW_DRIFT
from tasks.model.parameters import ACCEL_FIRST
from tasks.model.terms.memory import BIAS_RANDOM_WALK, WALK_RATE
from tasks.motion.whole import Motion

SMALL = 0.02  # of the mismatch above noise: an engineer looks elsewhere first
MOSTLY_NOISE = 1.5  # chi-squared per degree of freedom up to which an account is complete
INTERVALS = 20  # of a run, whose increments are compared
LARGEST = 2  # increments: there and back
CHANCE = 0.01  # that so much of a walk's power is in them
LEVEL = 0.1  # of a drift's power: with less of it along the vertical it is level


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


def is_drift(finding: Finding) -> bool:
    """Whether it is a slow course of its own, named or not."""
    walks = any(name == BIAS_RANDOM_WALK.name for name, *_ in finding.terms)
    return walks or finding.title == SLOW_DRIFT


def drift(finding: Finding, motion: Motion) -> Finding:
    """A drift with its size, and without a name if it is no unit's walk; else the finding."""
    if not is_drift(finding):
        return finding
    lag = float(motion.t[-1] - motion.t[0]) / INTERVALS
    sizes = [_size(channel, finding.contribution[:, channel], lag) for channel in finding.channels]
    sized = replace(finding, parameters=tuple(p for size in sizes for p in size))
    if finding.effect != BIAS_RANDOM_WALK.name:
        return sized
    rates = [rate for _, rate in sizes]
    refusal = _switches(finding) or _too_fast(finding, rates) or _of_attitude(finding, motion)
    return without_name(sized, refusal) if refusal else sized


def _size(channel: int, course: np.ndarray, lag: float) -> tuple[FoundParameter, FoundParameter]:
    """Its rms about the mean, which is a bias, and q of b(t + τ) − b(t) ~ N(0, q²·τ), by the
    increments of a course (n,) over parts of the run of `lag` s.
    """
    name, rms = CHANNELS[channel], float(np.nanstd(course))
    rate = float(np.sqrt(np.mean(_increments(course) ** 2) / lag))
    u, unit = rate / np.sqrt(2.0 * INTERVALS), WALK_RATE[channel].si
    return (
        FoundParameter(name=f"rms_{name}", value=rms, unit=READINGS[channel >= ACCEL_FIRST], u=0.0),
        FoundParameter(name=f"rate_{name}", value=rate, unit=unit, u=u),
    )


def _switches(walk: Finding) -> Refusal | None:
    chances = [chance_of_largest(walk.contribution[:, channel]) for channel in walk.channels]
    return Refusal("switching", walk.effect) if max(chances, default=1.0) < CHANCE else None


def _too_fast(walk: Finding, rates: Sequence[FoundParameter]) -> Refusal | None:
    """Where it wanders by more than a working unit does."""
    limits = [WALK_RATE[channel].plausible[1] for channel in walk.channels]
    p, most = max(zip(rates, limits, strict=True), key=lambda pair: pair[0].value / pair[1])
    if p.value - COVERAGE * p.u <= most:
        return None
    return Refusal("implausible", walk.effect, p.name, p.unit, p.value, most)


def _of_attitude(walk: Finding, motion: Motion) -> Refusal | None:
    """Where a slow error of the attitude that poses or encoders tell would do the same: it turns
    gravity, and changes nothing along the vertical.
    """
    if min(walk.channels, default=0) < ACCEL_FIRST or (motion.tracking or motion.axes) is None:
        return None
    course = walk.contribution[:, ACCEL_FIRST:]
    course = course - np.nanmean(course, axis=0)
    upward = np.nansum((course * motion.up).sum(axis=1) ** 2)
    if upward > LEVEL * np.nansum(course**2):
        return None
    return Refusal("reference_noise", walk.effect)


def chance_of_largest(walk: np.ndarray) -> float:
    """Bound of the p value that two of the increments of a walk (n,) have so much of the power.

    Of N independent normal increments the share x of given two has a beta distribution:
    P(x > a) = (1 − a)^((N − 2)/2); by Bonferroni for every pair.
    """
    power = np.sort(_increments(walk) ** 2)
    total = float(power.sum())
    if not total:
        return 1.0
    rest = 1.0 - float(power[-LARGEST:].sum()) / total
    return min(1.0, comb(INTERVALS, LARGEST) * max(rest, 0.0) ** (0.5 * (INTERVALS - LARGEST)))


def _increments(course: np.ndarray) -> np.ndarray:
    """(INTERVALS,) of a course (n,) over equal parts of the run; zero where too little is known."""
    known = np.flatnonzero(np.isfinite(course))
    if len(known) <= INTERVALS:
        return np.zeros(INTERVALS)
    at = np.linspace(0.0, len(course) - 1.0, INTERVALS + 1)
    return np.diff(np.interp(at, known, course[known]))
