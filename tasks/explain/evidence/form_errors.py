"""Whether a name stands beside what the forms of everything else may leave.

A unit follows a published equation to a few per cent of what it adds; what is called by its
behaviour alone, or explained by nothing, follows a form that is known far worse. What a form lacks
resembles whatever is left in the catalogue: at worst it lies along a weaker finding whole. So it is
a random effect along that finding, of a variance in proportion to what the others gain, beside the
noise, whose variance is one. Of a gain g, the square of a fitted size in units of its noise, the
log of the odds keeps g/(1 + v), v = Σ τ²·g of the others in the channels of the finding.

The gain of each channel is counted in units of what is left there, χ² per degree of freedom
(Birge's ratio). Of a memory one form stands for its kind, known no better than an unpublished one.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from tasks.explain.channels import CHANNELS
from tasks.explain.evidence.lookalikes import MEMORY
from tasks.explain.explanation import UNNAMED, Finding, Refusal
from tasks.explain.odds import CERTAIN, PUBLISHED, UNPUBLISHED


def named_beside(
    findings: Sequence[Finding],
    beside: Sequence[Finding],
    unexplained: np.ndarray,
    scale: np.ndarray,
    noise: np.ndarray,
    nuisances: Collection[str] = (),
) -> list[Finding]:
    """The findings, without their names those whose odds do not stand beside the forms of others.

    beside: what else was found. unexplained: (6,) chi-squared of each channel that nothing removes,
    as the gains of the findings count; scale: (6,) χ² per degree of freedom that stays there.
    noise: (6,) of a sample. nuisances: names that every model of such a recording contains: they
    are there for certain, whatever has been found beside them.
    """
    every = [*findings, *beside]
    powers = np.array([_gain_by_channel(one, noise) for one in every]).reshape(-1, len(CHANNELS))
    loose = np.array([one.unlisted or one.effect in (UNNAMED, MEMORY) for one in every], bool)
    forms = np.where(loose, UNPUBLISHED, PUBLISHED) ** 2
    counted = powers / np.fmax(scale, 1.0)
    named = []
    for number, one in enumerate(findings):
        if one.effect == UNNAMED or not one.behaviour:
            named.append(one)
            continue
        channels = list(one.channels)
        others = powers[:, channels].sum(axis=1)
        others[number] = 0.0
        others *= one.effect not in nuisances
        left = float(unexplained[channels].sum())
        most_left = float(np.fmax.reduce(scale[channels], initial=1.0))
        by_forms, by_left = float(forms @ others), UNPUBLISHED**2 * left
        if _log_odds(one, float(counted[number].sum()), 1.0 + by_forms + by_left) > CERTAIN:
            named.append(one)
            continue
        times = np.array([others.sum(), left]) / max(one.gain, 1e-300)
        refusal = (
            Refusal("overshadowed", one.effect, value=float(times[1]), limit=most_left)
            if _log_odds(one, one.gain, 1.0 + by_forms) > CERTAIN
            else Refusal("form_error", one.effect, value=float(times[0]))
        )
        named.append(without_name(one, refusal))
    return named


def _log_odds(finding: Finding, gain: float, variance: float) -> float:
    """Twice the logarithm of a finding's odds by what it gains, beside noise of a variance.

    Each parameter costs ln(1 + n) for n informative cells of unit variance; of a larger one they
    tell as much less.
    """
    count = max(1, len(finding.parameters))
    cells = np.expm1(max(0.0, finding.gain - finding.delta_bic) / count)
    return gain / variance - count * float(np.log1p(cells / variance))


def _gain_by_channel(finding: Finding, noise: np.ndarray) -> np.ndarray:
    """(6,) what a finding gains, by the power of what it adds to each channel."""
    power = np.nansum((finding.contribution / np.where(noise > 0, noise, np.inf)) ** 2, axis=0)
    return np.asarray(finding.gain * power / max(float(power.sum()), 1e-300))


def without_name(finding: Finding, refusal: Refusal) -> Finding:
    """The finding, called by what it follows, and why it lost its name."""
    return replace(
        finding, effect=UNNAMED, family=UNNAMED, title=finding.behaviour, refusal=refusal,
        indistinguishable=(), separated_by=None, group=(), common=(),
    )  # fmt: skip
