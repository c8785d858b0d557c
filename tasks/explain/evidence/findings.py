"""From evidence and events to findings: what each is, what it adds and its parameters."""

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import Event, Events
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.groups import FindingGroup
from tasks.explain.explanation import UNNAMED, Finding
from tasks.explain.inputs.full_rate import FullRate
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.refit import fitted
from tasks.explain.search.scores import INDISTINGUISHABLE
from tasks.model.effect import EVENTS
from tasks.model.term import Parameter, Term, places
from tasks.words import Sayable, message

JUMPS = message("explain-jumps")
MOVING = 100.0  # chi-squared of what a finding moves in a channel: ten standard deviations
MAX_U = 0.9  # of what is plausible: a parameter known no better than before is not listed
MIN_SHARE = 0.02  # of a finding's power: a channel with less is not named
SI_UNITS = (("arcsec", "rad"), ("deg", "rad"), ("mT", "T"), ("/g", "/(m/s2)"))


def findings_of(evidence: Evidence, full: FullRate, predicted: np.ndarray) -> list[Finding]:
    """The findings of a fitted selection. predicted: (n, 6) by its whole model, at full rate."""
    return [_finding(evidence, number, full, predicted) for number in range(len(evidence.groups))]


def _finding(evidence: Evidence, number: int, full: FullRate, predicted: np.ndarray) -> Finding:
    group = evidence.groups[number]
    keys = {term.key for term in group.terms}
    contribution = evidence.fit.model.effect_of(keys, full.motion, predicted)
    gain = evidence.gain(number) if group.absorbed_by is None else group.selected[0].gain
    named, first = group.name != UNNAMED, group.terms[0]
    return Finding(
        effect=group.name,
        family=first.family if named else UNNAMED,
        title=first.title if named else _description(group),
        equation=first.equation,
        source=first.source,
        channels=_channels(contribution, full.rest_variance),
        parameters=_parameters(group, evidence.fit),
        contribution=contribution,
        gain=gain,
        delta_bic=gain - group.parameter_count * float(np.log(evidence.used)),
        held_out_gain=evidence.held_out_gain(number),
        indistinguishable=_indistinguishable(group) if named else (),
        separated_by=first.separated_by if named else None,
    )


def _description(group: FindingGroup) -> Sayable:
    """What an unnamed finding follows; empty where a name was withdrawn."""
    first = group.terms[0]
    if first.name == UNNAMED:
        return first.title
    several = first.time_course == "jump" and len(group.terms) > 1
    return JUMPS if several else ""


def _indistinguishable(group: FindingGroup) -> tuple[str, ...]:
    """Catalogue names that fit so nearly as well that the data do not tell them apart."""
    names = (
        other.candidate.name
        for one in group.selected
        for other in one.alternatives
        if one.score - other.score < INDISTINGUISHABLE
    )
    return tuple(name for name in dict.fromkeys(names) if name != UNNAMED)


def _channels(contribution: np.ndarray, variance: np.ndarray) -> tuple[int, ...]:
    """The channels with a share of the power in units of their noise, or that clearly move."""
    power = np.nansum(contribution**2, axis=0) / variance
    if not power.any():
        return ()
    mean = np.nansum(contribution, axis=0) / len(contribution)
    moving = np.nansum((contribution - mean) ** 2, axis=0) / variance
    return tuple(np.flatnonzero((power > MIN_SHARE * power.sum()) | (moving > MOVING)).tolist())


def _parameters(group: FindingGroup, fit: FittedSelection) -> tuple[FoundParameter, ...]:
    if group.random:
        return ()
    found: list[FoundParameter] = []
    model, keys = fit.model, {term.key for term in group.terms}
    for k, (term, place) in enumerate(zip(model.terms, places(model.terms), strict=True)):
        if term.key not in keys:
            continue
        found += _checked_parameters(fit, term, group.absorbed_by)
        for p, parameter in enumerate(term.parameters, place.start):
            largest = MAX_U * (parameter.plausible[1] - parameter.nominal)
            if model.free[p] and 0.0 < model.u[p] < largest:
                found.append(_in_si(parameter, float(model.values[p]), float(model.u[p])))
        for shape, value in zip(term.shapes, term.at, strict=True):
            found.append(_in_si(shape, value, model.shape_u[k] or 0.0))
    return tuple(found)


def _checked_parameters(
    fit: FittedSelection, term: Term, absorbed_by: str | None
) -> list[FoundParameter]:
    """Parameters of known physics as the data alone have them, all else fitted beside them.

    absorbed_by: a term of the standard that cannot be told from it, which is taken to be nothing.
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
            u=float(u * parameter.factor),
        )
        for parameter, value, u in zip(
            free.parameters, alone.values[-count:], alone.u[-count:], strict=True
        )
        if 0.0 < u < parameter.plausible[1] - parameter.plausible[0]
    ]


def _in_si(parameter: Parameter, value: float, u: float) -> FoundParameter:
    """In SI, so that whoever compares it need not know how it is printed."""
    unit = parameter.unit if parameter.factor == 1.0 else si_unit(parameter.unit)
    return FoundParameter(name=parameter.name, value=value, unit=unit, u=u)


def si_unit(printed: str) -> str:
    """The SI unit of what is printed in a unit of the standard."""
    for shown, si in SI_UNITS:
        printed = printed.replace(shown, si)
    return printed


def event_findings(events: Events, full: FullRate, predicted: np.ndarray) -> list[Finding]:
    """Findings of the events, each with what it changes after those before it.

    predicted: (n, 6) readings without events.
    """
    found = []
    for event in events.events:
        after = event.applied(full.motion.t, predicted)
        found.append(_event_finding(event, after - predicted, full))
        predicted = after
    return found


def _event_finding(event: Event, contribution: np.ndarray, full: FullRate) -> Finding:
    effect = EVENTS.get(event.effect)
    gain = float((np.nansum(contribution**2, axis=0) / full.rest_variance).sum())
    count = len(event.parameters)
    rows = max(1, int(np.isfinite(full.readings[:, list(event.channels)]).sum()))
    return Finding(
        effect=event.effect,
        family=effect.family if effect else UNNAMED,
        title=effect.title if effect else event.description,
        equation=effect.equation if effect else "",
        source=effect.source if effect else "",
        channels=event.channels,
        parameters=event.parameters,
        contribution=contribution,
        gain=gain,
        delta_bic=gain - count * float(np.log(rows)),
        held_out_gain=0.5 * gain - count,
        indistinguishable=event.indistinguishable,
        separated_by=effect.separated_by if effect else None,
    )
