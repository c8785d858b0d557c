"""Whether a name stands beside what the forms of everything else may leave.

A unit follows a published equation to a few per cent of what it adds; what is called by its
behaviour alone, or explained by nothing, follows a form that is known far worse. What a form lacks
resembles whatever is left in the catalogue: at worst it lies along a weaker finding whole. So it is
a random effect along that finding, of a variance in proportion to what the others gain, beside the
noise, whose variance is one. Of a gain g, the square of a fitted size in units of its noise, the
log of the odds keeps g/(1 + v), v = Σ τ²·g of the others in the channels of the finding.

What has no name may be one law with what a name was given: where both add to the same readings at
the same time, half of its size may lie along the name. A random walk, which any course resembles,
is the last resort: all of it may.

The gain of each channel is counted in units of what is left there, χ² per degree of freedom
(Birge's ratio). Of a memory one form stands for its kind, known no better than an unpublished one.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.scrutiny import Scrutiny
from tasks.explain.explanation import (
    CERTAIN,
    CHANNELS,
    COVERAGE,
    PUBLISHED,
    UNKNOWN,
    UNNAMED,
    UNPUBLISHED,
    DeterminedModel,
    Finding,
    Refusal,
)
from tasks.explain.inputs.blocks import FullRate
from tasks.explain.noise import equations_of
from tasks.explain.search.fitted import fitted
from tasks.model.fit import inverse
from tasks.model.model import Model
from tasks.model.term import TermKey

MEMORY, WALK = "hysteresis", "bias_random_walk"


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
        by_forms += sum(
            float(g) * (1.0 if one.effect == WALK else UNKNOWN**2 * _at_once(one, other, noise))
            for g, other in zip(others, every, strict=True) if g and other.effect == UNNAMED
        )  # fmt: skip
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


def _at_once(one: Finding, other: Finding, noise: np.ndarray) -> float:
    """0 to 1: how far two findings add to the same readings at the same time, whatever the sign."""
    sizes = [np.nan_to_num(np.abs(each.contribution) / np.where(noise > 0, noise, np.inf))
             for each in (one, other)]  # fmt: skip
    powers = float((sizes[0] ** 2).sum() * (sizes[1] ** 2).sum())
    return float((sizes[0] * sizes[1]).sum()) ** 2 / max(powers, 1e-300)


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


# Which parameters of the findings the recording determines, and the model of these alone.


def determined_model(
    evidence: Evidence, scrutinies: Mapping[int, Scrutiny], full: FullRate
) -> DeterminedModel:
    """The fitted model with its undetermined parameters set to nothing and the rest fitted again.

    A parameter no better known than its size would otherwise shift the standard's parameters that
    compensate for it. Its possible size, with everything that compensates for it, stays in the
    covariance. scrutinies: of the findings, by number.
    """
    fit, model = evidence.fit, evidence.fit.model
    wider = widening(evidence, scrutinies)
    free, groups = np.flatnonzero(model.free), evidence.groups
    own = [evidence.own[number].tolist() for number in scrutinies if not groups[number].random]
    loose = undetermined(
        model, [{int(free[q]) for q in one if q < len(free)} for one in own], wider
    )
    if loose.any():
        without = fitted(model.held_at_zero(loose), fit.blocks, fit.noises)
        model = replace(without, free=without.free | loose)
    spread = [_spread(evidence, model.terms[k].key) for k in model.fitted_shapes]
    wide = np.concatenate([wider[model.free], spread])
    covariance = _covariance(model, evidence) * wide[:, None] * wide
    return DeterminedModel(model, loose, covariance, full.motion, full.start)


def _spread(evidence: Evidence, key: TermKey) -> float:
    """The factor by which the residual widens u of a term's shape."""
    numbers = [n for n, group in enumerate(evidence.groups) if key in {t.key for t in group.terms}]
    return float(np.sqrt(max((evidence.dispersion(n) for n in numbers), default=1.0)))


def widening(evidence: Evidence, scrutinies: Mapping[int, Scrutiny]) -> np.ndarray:
    """(p,) factors by which the residual, and the differences between parts, widen each u."""
    model, wider = evidence.fit.model, np.ones(len(evidence.fit.model.values))
    free = np.flatnonzero(model.free)
    for number, scrutiny in scrutinies.items():
        for q, u in zip(evidence.own[number].tolist(), scrutiny.u.tolist(), strict=True):
            if q < len(free) and model.u[free[q]] > 0.0:
                wider[free[q]] = u / model.u[free[q]]
    return wider


def undetermined(model: Model, owned: Sequence[set[int]], wider: np.ndarray) -> np.ndarray:
    """(p,) bool: parameters no larger than their U once the less clear ones are set to nothing.

    One by one, the least clear first, since whatever compensates for it then becomes clearer: of
    effects that compensate for each other one stays, and the last parameter of each does. owned:
    the places of each effect's parameters. wider: (p,) factors by which each u exceeds the fit's.
    """
    values, covariance = model.values.copy(), model.covariance.copy()
    left = [set(own) for own in owned]
    loose = np.zeros(len(values), bool)
    while True:
        u = wider * np.sqrt(np.maximum(np.diag(covariance), 0.0))
        tried = [p for own in left if len(own) > 1 for p in own if u[p] > 0.0]
        least = min(tried, key=lambda p: abs(values[p]) / u[p], default=None)
        if least is None or abs(values[least]) > COVERAGE * u[least]:
            return loose
        loose[least] = True
        for own in left:
            own.discard(least)
        gain = covariance[:, least] / covariance[least, least]
        values = values - gain * values[least]
        covariance = covariance - np.outer(gain, covariance[least])


def _covariance(model: Model, evidence: Evidence) -> np.ndarray:
    """(q, q) of the free parameters and the fitted shapes, by the fit's noise."""
    blocks, noises = evidence.fit.blocks, evidence.fit.noises
    if model.fitted_shapes:
        design = model.design(blocks.motion)
        misfit = blocks.readings - design.prediction
        normal, _, _ = equations_of(design.columns, misfit, blocks, noises).normal()
    else:
        rows = np.flatnonzero(model.free[evidence.fit.model.free])
        normal = evidence.whole.normal()[0][np.ix_(rows, rows)]
    prior = np.zeros(len(normal))
    prior[: int(model.free.sum())] = model.prior[model.free]
    return inverse(normal + np.diag(prior))
