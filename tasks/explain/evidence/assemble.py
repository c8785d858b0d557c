"""From a fitted model to findings: what each piece of physics earns, and its parameters."""

from collections.abc import Sequence

import numpy as np

from schemas.discrepancy import FoundParameter, Verdict
from schemas.recording import Recording
from tasks.explain.events.detect import events_in_residual
from tasks.explain.events.event import Event, Events
from tasks.explain.evidence.other_parameters import other_parameters
from tasks.explain.evidence.weigh import Group, Weighed, groups_of
from tasks.explain.explanation import FITTED, Explanation, Finding
from tasks.explain.inputs.observed import FullRate, Observed
from tasks.explain.inputs.reference import Told
from tasks.explain.regression.spectrum import Noise
from tasks.explain.search.empirical_terms import UNNAMED
from tasks.explain.search.rank import NEAR
from tasks.explain.search.refit import Model, fitted, model_of
from tasks.explain.search.stepwise import Found
from tasks.model.events import EVENTS
from tasks.model.simulate import predict
from tasks.model.term import Parameter, Term, places
from tasks.words import Sayable, message

MOVING = 100.0  # chi-squared of what a finding moves in a channel: ten standard deviations
TOLD = 0.9  # of what is plausible: a parameter known no better than before is not listed
SEEN = 0.02  # of a finding's power: a channel with less is not named


def assembled(
    recording: Recording,
    full: FullRate,
    fine: Observed,
    events: Events,
    found: Found,
    model: Model,
    noises: Sequence[Noise],
    told: Told | None = None,
) -> Explanation:
    """The explanation that a fitted model is, with the events.

    told: a prediction from elsewhere, by which the readings were reduced to those of an ideal unit.
    """
    more = 0.0 if told is None else told.beyond_ideal(full.motion)
    standard = fitted(model_of((), fine), fine, noises)
    noise = np.sqrt(full.quiet).repeat(3)
    t = full.motion.t
    bare = predict(model.terms, full.motion, model.values)
    groups = groups_of(found)
    weighed = Weighed.of(model, fine, noises, groups)
    residual = full.readings - events.applied(t, bare + more)
    heard = events_in_residual(events, t, residual, noise, full.motion)
    findings = [
        _finding(group, number, weighed, model, full, bare, fine, noises)
        for number, group in enumerate(groups)
    ]
    happened = _of_events(heard, t, full, bare + more, noise)
    nominal = predict(standard.terms, full.motion, standard.values)
    if told is not None:
        nominal = told.readings
        other = other_parameters(standard, full, fine, noises)
        findings += [other] if other is not None else []
    whole = tuple(sorted((*happened, *findings), key=lambda each: -each.gain))
    return Explanation(
        recording=recording,
        nominal=nominal,
        found=heard.applied(t, bare + more),
        noise=noise,
        p_value=min([found.p_value, *(event.p_value for event in heard.events)]),
        verdict=_verdict(whole),
        held_out=weighed.held_out(),
        findings=whole,
        remarks=heard.remarks,
        model=FITTED if told is None else told.model,
    )


def _verdict(findings: Sequence[Finding]) -> Verdict:
    if not findings:
        return "no_mismatch"
    unnamed = [each.effect == UNNAMED for each in findings]
    if all(unnamed):
        return "unexplained"
    return "partly_explained" if any(unnamed) else "explained"


def _finding(
    group: Group,
    number: int,
    weighed: Weighed,
    model: Model,
    full: FullRate,
    bare: np.ndarray,
    fine: Observed,
    noises: Sequence[Noise],
) -> Finding:
    rest = model.without({term.key for term in group.terms})
    contribution = bare - predict(rest.terms, full.motion, rest.values)
    soaked = group.chosen[0].instead_of is not None
    gain = group.chosen[0].gain if soaked else weighed.gain(number)
    count = sum(len(one.candidate.own) for one in group.chosen if not one.candidate.known)
    if group.chosen[0].candidate.prior is not None:
        count = len(group.chosen)
    first = group.terms[0]
    named = group.name != UNNAMED
    title = first.title if named else _followed(group)
    return Finding(
        effect=group.name,
        family=first.family if named else UNNAMED,
        title=title,
        equation=first.equation,
        source=first.source,
        channels=_channels(contribution, full),
        parameters=_parameters(group, model, fine, noises),
        contribution=contribution,
        gain=gain,
        delta_bic=gain - count * float(np.log(weighed.used)),
        held_out_gain=weighed.held_out_gain(number),
        indistinguishable=_alike(group) if named else (),
        separated_by=first.separated_by if named else None,
        follows=None if named else title,
    )


def _followed(group: Group) -> Sayable:
    """What an unnamed finding follows; a name that was withdrawn becomes a likeness."""
    first = group.terms[0]
    if first.name == UNNAMED:
        return first.title
    if len(group.terms) > 1:
        return JUMPS
    return message("explain-other-form", title=first.title)


JUMPS = message("explain-jumps")


def _alike(group: Group) -> tuple[str, ...]:
    """Catalogue names that fit so nearly as well that the data do not tell them apart."""
    alike: dict[str, None] = {}
    for one in group.chosen:
        for rival in one.rivals:
            if rival.candidate.name != UNNAMED and one.score - rival.score < NEAR:
                alike[rival.candidate.name] = None
    return tuple(alike)


def _channels(contribution: np.ndarray, full: FullRate) -> tuple[int, ...]:
    """The channels with a share of the power in units of their noise, or that clearly move."""
    variance = full.quiet.repeat(3)
    power = np.nansum(contribution**2, axis=0) / variance
    if not power.any():
        return ()
    mean = np.nansum(contribution, axis=0) / len(contribution)
    moving = np.nansum((contribution - mean) ** 2, axis=0) / variance
    return tuple(int(c) for c in np.flatnonzero((power > SEEN * power.sum()) | (moving > MOVING)))


def _parameters(
    group: Group, model: Model, fine: Observed, noises: Sequence[Noise]
) -> tuple[FoundParameter, ...]:
    found: list[FoundParameter] = []
    own = places(model.terms)
    u = np.sqrt(np.maximum(np.diag(model.covariance), 0.0))
    random = group.chosen[0].candidate.prior is not None
    for k, term in enumerate(model.terms):
        if term.key not in {each.key for each in group.terms} or random:
            continue
        freed = term.freed()
        if freed is not None:
            soaks = group.chosen[0].instead_of
            found.extend(_freed_parameters(model, term, freed, soaks, fine, noises))
        for p, parameter in zip(range(own[k].start, own[k].stop), term.parameters, strict=True):
            if model.free[p] and 0.0 < u[p] < TOLD * (parameter.plausible[1] - parameter.nominal):
                found.append(_said(parameter, float(model.values[p]), float(u[p])))
        for shape, value in zip(term.shapes, term.at, strict=True):
            found.append(_said(shape, value, model.shape_u[k] or 0.0))
    return tuple(found)


def _freed_parameters(
    model: Model,
    term: Term,
    freed: Term,
    soaks: str | None,
    fine: Observed,
    noises: Sequence[Noise],
) -> list[FoundParameter]:
    """Parameters of known physics as the data alone have them, all else fitted beside them.

    soaks: a term of the standard that cannot be told from it, which is taken to be nothing.
    """
    rest = model.without({term.key, *(each.key for each in model.terms if each.name == soaks)})
    free = np.concatenate([rest.free, np.ones(len(freed.parameters), bool)])
    count = len(freed.parameters)
    longer = Model(
        (*rest.terms, freed),
        np.concatenate([rest.values, [p.nominal for p in freed.parameters]]),
        free,
        np.concatenate([rest.prior, np.zeros(count)]),
        np.zeros((len(free), len(free))),
        (*rest.shape_u, None),
    )
    alone = fitted(longer, fine, noises)
    u = np.sqrt(np.maximum(np.diag(alone.covariance), 0.0))
    return [
        FoundParameter(
            name=parameter.name,
            value=float(value * parameter.factor),
            unit=parameter.unit,
            u=float(known * parameter.factor),
        )
        for parameter, value, known in zip(
            freed.parameters, alone.values[-count:], u[-count:], strict=True
        )
        if 0.0 < known < parameter.plausible[1] - parameter.plausible[0]
    ]


def _said(parameter: Parameter, value: float, u: float) -> FoundParameter:
    """In SI, so that whoever compares it need not know how it is printed."""
    unit = parameter.unit if parameter.factor == 1.0 else si_unit(parameter.unit)
    return FoundParameter(name=parameter.name, value=value, unit=unit, u=u)


def si_unit(printed: str) -> str:
    """The SI unit of what is printed in a unit of the house."""
    for shown, kept in (("arcsec", "rad"), ("deg", "rad"), ("mT", "T"), ("/g", "/(m/s2)")):
        printed = printed.replace(shown, kept)
    return printed


def _of_events(
    events: Events, t: np.ndarray, full: FullRate, bare: np.ndarray, noise: np.ndarray
) -> list[Finding]:
    """Findings of the events, each with what it changes after those before it."""
    found, reading = [], bare
    for event in events.events:
        after = event.applied(t, reading)
        found.append(_of_event(event, after - reading, full, noise))
        reading = after
    return found


def _of_event(event: Event, contribution: np.ndarray, full: FullRate, noise: np.ndarray) -> Finding:
    effect = EVENTS.get(event.effect)
    variance = np.where(noise > 0, noise**2, np.inf)
    gain = float((np.nansum(contribution**2, axis=0) / variance).sum())
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
        separated_by=effect.separated_by if effect else None,
        follows=None if effect else event.description,
    )
