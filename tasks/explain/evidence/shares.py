"""The share of the mismatch that each finding removes, and which shares deserve an entry.

Whether a random walk walks: its increments are alike throughout, where a signal that switches to
and fro (random telegraph noise) changes at a few moments only.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from math import comb

import numpy as np

from tasks.explain.evidence.left_over import LeftOver
from tasks.explain.explanation import UNNAMED, Finding, Refusal
from tasks.model.terms.memory import BIAS_RANDOM_WALK

SMALL = 0.02  # of the mismatch above noise: an engineer looks elsewhere first
SHADOW = 0.15  # of what stays unexplained in its channels: who removes less has no name
WEAK = 100.0  # ΔBIC up to which something far stronger beside it may have made it: z of about ten
FORM = 0.1  # relative: as well as the form of a strong effect is known
LEAVING_DRIFTS = ("hysteresis", "dead_zone", "code_fault")
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


def without_shadows(
    findings: Sequence[Finding],
    removed: Sequence[float],
    left: LeftOver,
    nuisances: Collection[str] = (),
) -> list[Finding]:
    """The findings, those without a name that remove far less than remains unexplained beside them.

    A much larger unknown effect has parts that resemble anything in the catalogue: a name would be
    one of its shadows. A random drift, which has no parameters, absorbs part of any slow change: it
    is named only if nothing else is left, and weak physics only if it is clear beside the residual.
    removed: chi-squared removed by each, at the unit's rows. nuisances: names that every model of
    such a recording contains.
    """
    findings = [
        one if one.effect in nuisances else _named_or_incomplete(one, left) for one in findings
    ]
    return [
        _named_or_shadow(one, each, left) if one.effect != UNNAMED and one.behaviour else one
        for one, each in zip(findings, removed, strict=True)
    ]


def _named_or_shadow(finding: Finding, removed: float, left: LeftOver) -> Finding:
    beside = float(left.remaining_by_channel[list(finding.channels)].sum())
    if removed >= SHADOW * beside:
        return finding
    refusal = Refusal("overshadowed", finding.effect, value=beside / max(removed, 1e-300))
    return without_name(finding, refusal)


def _named_or_incomplete(finding: Finding, left: LeftOver) -> Finding:
    after = float(np.nan_to_num(left.chi2_per_degree[list(finding.channels)]).max())
    if finding.effect == UNNAMED or not finding.behaviour or after < MOSTLY_NOISE:
        return finding
    if finding.parameters and finding.delta_bic > WEAK * after:
        return finding
    return without_name(finding, Refusal("incomplete", finding.effect, value=after))


def without_slivers(findings: Sequence[Finding], nuisances: Collection[str]) -> list[Finding]:
    """The findings, those of the catalogue without a name that remove less of the mismatch than the
    forms of the others may leave; whatever their evidence, which grows with the length of a run.

    nuisances: names that every model of such a recording contains; their shares do not count.
    """
    beside = 1.0 - sum(one.share for one in findings if one.effect in nuisances)
    return [
        one
        if one.effect in nuisances or not one.terms or one.share >= FORM**2 * beside
        else _form_error(one, beside / max(one.share, 1e-300))
        for one in findings
    ]


def without_form_errors(
    findings: Sequence[Finding],
    beside: Sequence[Finding] = (),
    nuisances: Collection[str] = (),
) -> list[Finding]:
    """The findings, those without a name that are weak beside something far stronger.

    A strong effect whose form is a little different from its equation leaves a residual of its
    square, and that resembles whatever is left in the catalogue. beside: what else was found.
    nuisances: names that every model of such a recording contains, whatever is beside them.
    Memory has so many published forms, and readings that a logger changed are put right so
    roughly, that a drift weaker than either, in channels that it changes, may be its form's.
    """
    gains = [one.gain for one in (*findings, *beside)]
    strongest = max(gains, default=0.0)
    leaving = [one for one in (*findings, *beside) if one.effect in LEAVING_DRIFTS]
    return [
        one if one.effect in nuisances else _drift_beside(_named_beside(one, strongest), leaving)
        for one in findings
    ]


def _named_beside(finding: Finding, strongest: float) -> Finding:
    if finding.delta_bic > WEAK or finding.gain > FORM**2 * strongest:
        return finding
    return _form_error(finding, strongest / max(finding.gain, 1e-300))


def _drift_beside(finding: Finding, leaving: Sequence[Finding]) -> Finding:
    shared = [one.gain for one in leaving if set(one.channels) & set(finding.channels)]
    strongest = max(shared, default=0.0)
    if finding.effect != BIAS_RANDOM_WALK.name or finding.gain >= strongest:
        return finding
    return _form_error(finding, strongest / max(finding.gain, 1e-300))


def _form_error(finding: Finding, times: float) -> Finding:
    """Without its name, as what the form of others, `times` as large, may leave; physics that is
    known beforehand keeps it.
    """
    if finding.effect == UNNAMED or not finding.behaviour:
        return finding
    return without_name(finding, Refusal("form_error", finding.effect, value=times))


def without_name(finding: Finding, refusal: Refusal) -> Finding:
    """The finding, called by what it follows, and why it lost its name."""
    return replace(
        finding, effect=UNNAMED, family=UNNAMED, title=finding.behaviour, refusal=refusal,
        indistinguishable=(), separated_by=None, group=(), common=(),
    )  # fmt: skip


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
