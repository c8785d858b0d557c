"""Turns evidence into findings: identity, contribution and parameters."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.confounding.delays import common_part
from tasks.explain.determined import DeterminedModel
from tasks.explain.evidence.clipping import possibly_clipped, possibly_clipped_in_noise
from tasks.explain.evidence.dependence import change_without
from tasks.explain.evidence.determination import widening
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.groups import FindingGroup
from tasks.explain.evidence.pruning import unsupported
from tasks.explain.evidence.scrutiny import Scrutiny
from tasks.explain.evidence.step_time import step_time
from tasks.explain.explanation import UNNAMED, Finding, Refusal
from tasks.explain.inputs.full_rate import FullRate
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.proposals import TIME
from tasks.explain.search.refit import fitted
from tasks.model.term import Term, places
from tasks.words import Sayable, message

JUMPS = message("explain-jumps")
MOVING = 100.0  # chi-squared of what a finding moves in a channel: ten standard deviations
MAX_U = 0.9  # of what is plausible: a parameter known no better than before is not listed
MIN_SHARE = 0.02  # of a finding's power: a channel with less is not named


def findings_of(
    evidence: Evidence, scrutinies: Mapping[int, Scrutiny], full: FullRate,
    determined: DeterminedModel, to_noise: Collection[int] = (), ordered: bool = False,
) -> list[Finding]:  # fmt: skip
    """The findings of a fitted selection. determined: the part that is corrected for.

    scrutinies: of the findings, by number. to_noise: numbers of those that only reduce the noise of
    the reference. ordered: exactly these terms were requested, and they keep the requested names,
    with the evidence against them.
    """
    scrutinies = dict(scrutinies)
    for number in scrutinies.keys() & set(to_noise):
        refusal = Refusal("reference_noise", evidence.groups[number].name)
        if evidence.groups[number].name != UNNAMED and not _refused(scrutinies[number]):
            scrutinies[number] = replace(scrutinies[number], refusal=refusal)
    groups = evidence.groups
    if not ordered:
        groups = _without_refused(groups, scrutinies)
    wider = _beside_implausible(evidence, scrutinies)
    return [
        _finding(evidence, number, groups[number], wider[number], full, determined)
        for number in scrutinies
    ]


def _beside_implausible(
    evidence: Evidence, scrutinies: Mapping[int, Scrutiny]
) -> dict[int, Scrutiny]:
    """The same with u, as it is stated, that covers what each parameter would be without the
    implausible findings. What the recording determines, and what is named, stays as it is.
    """
    beyond = [
        n for n, one in scrutinies.items() if one.refusal and one.refusal.kind == "implausible"
    ]
    if not beyond:
        return dict(scrutinies)
    change = change_without(evidence, beyond)
    return {
        n: replace(one, u=np.hypot(one.u, change[evidence.own[n][0]]))
        for n, one in scrutinies.items()
    }


def _without_refused(
    groups: Sequence[FindingGroup], scrutinies: Mapping[int, Scrutiny]
) -> tuple[FindingGroup, ...]:
    """The groups, those without a name whose name was refused."""
    return tuple(replace(group, name=UNNAMED) if _refused(scrutinies.get(n)) else group
                 for n, group in enumerate(groups))  # fmt: skip


def scrutinised(evidence: Evidence) -> dict[int, Scrutiny]:
    """By number the scrutiny of each group that is a finding: a nuisance of every model is one
    only where the recording determines it.
    """
    every = {number: Scrutiny.of(evidence, number) for number in range(len(evidence.groups))}
    return {n: one for n, one in every.items() if not _only_a_nuisance(evidence, n, one)}


def _only_a_nuisance(evidence: Evidence, number: int, scrutiny: Scrutiny) -> bool:
    """Whether it is in every model of such a recording, and this one has no evidence for more: an
    unnamed rest of what every model fits is none of the unit's.
    """
    if not evidence.groups[number].nuisance:
        return False
    unclear = scrutiny.refusal is not None or unsupported(evidence, number, 1)
    return unclear or evidence.held_out_gain(number) <= 0.0


def _refused(scrutiny: Scrutiny | None) -> bool:
    return scrutiny is not None and scrutiny.refusal is not None


def _finding(
    evidence: Evidence,
    number: int,
    group: FindingGroup,
    scrutiny: Scrutiny,
    full: FullRate,
    determined: DeterminedModel,
) -> Finding:
    keys = {term.key for term in group.terms}
    contribution = determined.contribution(keys)
    absorbed = group.absorbed_by is not None
    gain = group.selected[0].gain if absorbed else evidence.evidence(number)
    named, first = group.name != UNNAMED, group.terms[0]
    channels = _channels(contribution, full.rest_variance)
    return Finding(
        effect=group.name,
        family=first.family if named else UNNAMED,
        title=first.title if named else _behaviour(group),
        behaviour="" if group.known else _behaviour(group),
        equation=first.equation,
        source=first.source,
        channels=channels,
        parameters=_parameters(evidence, number, scrutiny, full.start),
        contribution=contribution,
        terms=tuple(keys),
        gain=gain,
        delta_bic=gain if absorbed else evidence.delta_bic(number),
        held_out_gain=evidence.held_out_gain(number),
        indistinguishable=_indistinguishable(group, channels, contribution, full) if named else (),
        separated_by=first.separated_by if named else None,
        homogeneity_p=scrutiny.homogeneity_p,
        refusal=scrutiny.refusal,
        group=group.selected[0].group if named else (),
        unlisted=group.unlisted and (named or first.name == UNNAMED),
        common=_common_part(evidence, number, scrutiny),
    )


def _common_part(evidence: Evidence, number: int, scrutiny: Scrutiny) -> tuple[FoundParameter, ...]:
    """What mutually compensating effects have in common, with U as its parameters have."""
    group = evidence.groups[number]
    names, wider = group.selected[0].group, widening(evidence, {number: scrutiny})
    return common_part(evidence.fit.model, group.terms, names, wider) if names else ()


def _behaviour(group: FindingGroup) -> Sayable:
    """What an unnamed finding follows: never a name of the catalogue."""
    first = group.terms[0]
    several = len(group.terms) > 1 and first.time_course == "jump"
    return JUMPS if several else first.behaviour


def _indistinguishable(
    group: FindingGroup, channels: tuple[int, ...], contribution: np.ndarray, full: FullRate
) -> tuple[str, ...]:
    """Catalogue names that fit as well, so that the data cannot distinguish them."""
    names = [name for one in group.selected for name in one.rivals if name != UNNAMED]
    names += possibly_clipped(group.name, channels, full.motion)
    names += possibly_clipped_in_noise(group.name, contribution, full.readings, full.motion)
    return tuple(dict.fromkeys(names))


def _channels(contribution: np.ndarray, variance: np.ndarray) -> tuple[int, ...]:
    """The channels with a share of the power in units of their noise, or that clearly move."""
    power = np.nansum(contribution**2, axis=0) / variance
    if not power.any():
        return ()
    mean = np.nansum(contribution, axis=0) / len(contribution)
    moving = np.nansum((contribution - mean) ** 2, axis=0) / variance
    return tuple(np.flatnonzero((power > MIN_SHARE * power.sum()) | (moving > MOVING)).tolist())


def _parameters(
    evidence: Evidence, number: int, scrutiny: Scrutiny, start: float
) -> tuple[FoundParameter, ...]:
    """Parameters with U that covers the residual and the differences between parts.

    start: of the engine's t = 0 on the recording's own clock, s.
    """
    group, model = evidence.groups[number], evidence.fit.model
    if group.random:
        return ()
    found: list[FoundParameter] = []
    keys = {term.key for term in group.terms}
    widened = dict(zip(evidence.own[number][0], scrutiny.u.tolist(), strict=True))
    column = np.cumsum(model.free) - 1
    spread = np.sqrt(evidence.scatter.dispersion(number))
    for k, (term, place) in enumerate(zip(model.terms, places(model.terms), strict=True)):
        if term.key not in keys:
            continue
        found += _checked_parameters(evidence.fit, term, group.absorbed_by, spread)
        for p, parameter in enumerate(term.parameters, place.start):
            largest = MAX_U * (parameter.plausible[1] - parameter.nominal)
            u = widened.get(int(column[p]), 0.0) if model.free[p] else 0.0
            if 0.0 < u < largest:
                found.append(parameter.found(float(model.values[p]), u))
        for shape, value in zip(term.shapes, term.at, strict=True):
            if shape.name == TIME:
                time, u = step_time(evidence.fit, term, spread**2)
                found.append(shape.found(start + time, u))
                continue
            found.append(shape.found(value, float(spread * (model.shape_u[k] or 0.0))))
    return tuple(found)


def _checked_parameters(
    fit: FittedSelection, term: Term, absorbed_by: str | None, spread: float
) -> list[FoundParameter]:
    """Parameters of known physics from the data alone, with all else fitted beside them.

    absorbed_by: an indistinguishable term of the standard, which is assumed to be zero. spread: the
    factor by which the residual widens their uncertainties.
    """
    free = term.with_free_size()
    if free is None:
        return []
    others = {other.key for other in fit.model.terms if other.name == absorbed_by}
    rest = fit.model.without({term.key} | others)
    alone = fitted(rest.with_term(free), fit.blocks, fit.noises)
    count = len(free.parameters)
    return [
        FoundParameter(
            name=parameter.name,
            value=float(value * parameter.factor),
            unit=parameter.unit,
            u=float(spread * u * parameter.factor),
        )
        for parameter, value, u in zip(
            free.parameters, alone.values[-count:], alone.u[-count:], strict=True
        )
        if 0.0 < u < parameter.plausible[1] - parameter.plausible[0]
    ]
