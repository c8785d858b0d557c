"""Turns evidence into findings: identity, contribution and parameters."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import comb

import numpy as np
from scipy.special import chdtrc

from schemas.discrepancy import FoundParameter, Verdict
from tasks.explain.events.codes import CodeFault
from tasks.explain.events.detect import AxisMapping, Fault, RangeSetting, events_in_residual
from tasks.explain.events.event import Event, Events
from tasks.explain.events.saturation import EFFECTS as LIMITS
from tasks.explain.evidence.confounding import chi2_of, common_part
from tasks.explain.evidence.evidence import (
    Evidence,
    FindingGroup,
    change_without,
    step_time,
    unsupported,
)
from tasks.explain.evidence.form_errors import (
    determined_model,
    named_beside,
    widening,
    without_name,
)
from tasks.explain.evidence.left_over import NEAR_NOISE, REFERENCE_KNOWN, LeftOver, remainder
from tasks.explain.evidence.reference_errors import fitted_to_reference_noise, with_smoothing_error
from tasks.explain.evidence.scrutiny import Scrutiny
from tasks.explain.explanation import (
    CHANNELS,
    COVERAGE,
    EVERY,
    FITTED,
    UNNAMED,
    DeterminedModel,
    Explanation,
    Finding,
    Refusal,
)
from tasks.explain.inputs.blocks import FullRate
from tasks.explain.inputs.prepared import Prepared
from tasks.explain.search.candidates import TIME
from tasks.explain.search.empirical import READINGS, SLOW_DRIFT
from tasks.explain.search.fitted import FittedSelection, fitted, model_of
from tasks.explain.search.stepwise import FALSE_ALARMS
from tasks.model.model import Model
from tasks.model.term import ACCEL_FIRST, EVENTS, Term, places
from tasks.model.terms.memory import BIAS_RANDOM_WALK, WALK_RATE
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import Motion
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
        n: replace(one, u=np.hypot(one.u, change[evidence.own[n]])) for n, one in scrutinies.items()
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
        indistinguishable=_indistinguishable(group) if named else (),
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


def _indistinguishable(group: FindingGroup) -> tuple[str, ...]:
    """Catalogue names that fit as well, so that the data cannot distinguish them."""
    names = [name for one in group.selected for name in one.rivals if name != UNNAMED]
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
    widened = dict(zip(evidence.own[number].tolist(), scrutiny.u.tolist(), strict=True))
    column = np.cumsum(model.free) - 1
    spread = np.sqrt(evidence.dispersion(number))
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


# Turns events into findings: what each changes, and whether the readings support it.
#
# States the explanation of repaired readings for the readings as they were recorded.
#
# A fault that is there from the first row to the last is undone before anything else is looked
# for: what is found then has the units, axes and codes that it ought to have. Here it is put
# back.

LEAST_P = LEAST_TOTAL = 1e-300
OF_A_LIMIT = 100.0  # ΔBIC, about ten standard deviations: what only bends looks like a limit
CONTRADICTED = 3.0  # standard deviations of a gain by which readings speak against an event
CLEAR_CHANGE = 3.0  # times the noise: a smaller change may be that of the reference's errors


@dataclass(frozen=True)
class EventFindings:
    """The events that are findings, and what all findings leave beside them.

    events: as many, in the order in which they act. found: (n, 6) predicted readings with them.
    removed: chi-squared at the unit's rows that each of them removes, not below zero. per_reading:
    (6,) mean chi-squared that all of them together remove from a reading that is used.
    """

    findings: list[Finding]
    events: Events
    found: np.ndarray
    left: LeftOver
    removed: list[float]
    per_reading: np.ndarray


def event_findings(
    events: Events, full: FullRate, nominal: np.ndarray, predicted: np.ndarray
) -> EventFindings:
    """Findings of the events, each with what it changes after those before it; what gains nothing
    is a remark on the readings.

    nominal, predicted: (n, 6) readings without events, by the standard's model and with all else
    that was found.
    """
    t, before = full.motion.t, predicted
    every = LeftOver.of(full, nominal, events.applied(t, predicted), events.masked)
    findings, kept, remarks = list[Finding](), list[Event](), list(events.remarks)
    for event in events.events:
        after = event.applied(t, before)
        gain = _gain(event, _without(event, events, full, predicted), after - before, every)
        rows = np.isfinite(full.readings[:, list(event.channels)]).sum()
        finding = event_finding(event, after - before, gain, len(event.parameters), int(rows))
        if finding.delta_bic > _needed(event, every) and finding.held_out_gain > 0.0:
            findings.append(finding)
            kept.append(event)
        else:
            remarks.append(event.description)
        before = after
    borne_out = replace(events, events=tuple(kept), remarks=tuple(remarks))
    found = borne_out.applied(t, predicted)
    left = (
        LeftOver.of(full, nominal, found, events.masked)
        if len(kept) < len(events.events)
        else every
    )
    without = (_without(event, borne_out, full, predicted) for event in kept)
    removed = [max(0.0, float(np.nansum(left.squares(one) - left.after))) for one in without]
    per_reading = _per_reading(left, left.squares(full.readings - predicted))
    return EventFindings(findings, borne_out, found, left, removed, per_reading)


def _per_reading(left: LeftOver, squares: np.ndarray) -> np.ndarray:
    """(6,) by how much the mean square (n, 6) of the readings that are used falls, not below 0."""
    fall = np.where(left.masked, np.nan, squares - left.after)
    rows = np.isfinite(fall).sum(axis=0)
    total = np.nansum(fall, axis=0)
    return np.maximum(np.divide(total, rows, out=np.zeros(len(rows)), where=rows > 0), 0.0)


def _needed(event: Event, left: LeftOver) -> float:
    """ΔBIC beyond which an event is a finding. A few readings that fall short of the prediction at
    the end of its range look like a limit: they are one only where that is clear of what is left.
    """
    if event.effect not in LIMITS:
        return 0.0
    return OF_A_LIMIT * _left_in(event, left)


def event_finding(
    event: Event, contribution: np.ndarray, gain: float, charged: int = 0, rows: int = 1
) -> Finding:
    """The finding of an event or a fault. charged: parameters that were fitted to `rows`."""
    effect = EVENTS.get(event.effect)
    return Finding(
        effect=event.effect,
        family=effect.family if effect else UNNAMED,
        title=event.title or (effect.title if effect else event.description),
        equation=effect.equation if effect else "",
        source=effect.source if effect else "",
        channels=event.channels,
        parameters=event.parameters,
        contribution=contribution,
        gain=gain,
        delta_bic=gain - charged * float(np.log(max(1, rows))),
        held_out_gain=0.5 * gain - charged,
        indistinguishable=event.indistinguishable,
        separated_by=effect.separated_by if effect else None,
    )


def _without(event: Event, events: Events, full: FullRate, predicted: np.ndarray) -> np.ndarray:
    """(n, 6) readings less what is predicted with all other events."""
    others = replace(events, events=tuple(one for one in events.events if one is not event))
    return full.readings - others.applied(full.motion.t, predicted)


def _gain(event: Event, residual: np.ndarray, change: np.ndarray, left: LeftOver) -> float:
    """Chi-squared that an event explains, relative to the residual in its channels.

    An event that changes no mean reading (a pile at a limit, steps, spikes) is judged by the p
    value of its own test; but not if the readings are clearly farther from the model with the event
    than without, judged by those that it changes by more than the reference's own errors. residual:
    (n, 6) readings minus the prediction with all other events. change: (n, 6) of the prediction, by
    the event.
    """
    squares = left.squares(residual)
    gains = squares - left.after
    gain = float(np.nansum(gains))
    clear = left.squares(change) > CLEAR_CHANGE**2
    spread = _left_in(event, left)
    # Where a motion begins or ends a few readings lose much: the sandwich.
    limit = CONTRADICTED * float(np.sqrt(np.nansum(gains[clear] ** 2)))
    if float(np.nansum(gains[clear])) < -limit:
        return min(gain, 0.0) / spread
    return max(gain / spread, -2.0 * float(np.log(max(event.p_value, LEAST_P))))


def _left_in(event: Event, left: LeftOver) -> float:
    """Mean chi-squared per degree of freedom of the event's channels that are known, at least 1."""
    after = left.chi2_per_degree[list(event.channels)]
    known = after[np.isfinite(after)]
    return max(1.0, float(known.mean())) if len(known) else 1.0


def with_faults(explanation: Explanation, prepared: Prepared, left: LeftOver) -> Explanation:
    """The explanation of a recording that was put right, with the faults as its first findings.

    The standard's scale factors take a setting up whole: against the fitted model it leaves no
    mismatch, and its evidence is that no working unit has such scale factors.
    """
    recording, faults = prepared.recorded, prepared.faults
    if not faults:
        return explanation
    t, found, own = recording.imu.t, explanation.found, list[Finding]()
    matrix = _matrix(faults, t)
    place = np.abs(matrix).argmax(axis=0)  # the channel in which each one is read
    noise = np.abs(matrix) @ explanation.noise
    for fault in faults:
        read = fault.applied(t, found)
        own.append(_event_finding(fault, read - found, noise))
        found = read
    # Of a setting the residual shows nothing; wrong codes share it with what is beside them.
    by_codes = [one.gain * isinstance(f, CodeFault) for one, f in zip(own, faults, strict=True)]
    rest = left.removed + left.remaining
    total = max(sum(by_codes) + rest, LEAST_TOTAL)
    own = [replace(one, share=part / total) for one, part in zip(own, by_codes, strict=True)]
    names = {CHANNELS[c]: CHANNELS[place[c]] for c in EVERY}
    ratio = {names[name]: value for name, value in explanation.held_out.rms_ratio.items()}
    moved, small = (
        [replace(_moved(one, matrix, place), share=one.share * rest / total) for one in some]
        for some in (explanation.findings, explanation.small)
    )
    return replace(
        explanation,
        recording=recording,
        nominal=explanation.nominal @ matrix.T,
        found=found,
        noise=noise,
        p_value=min([explanation.p_value, *(fault.p_value for fault in faults)]),
        verdict=_verdict_after_correction(explanation),
        held_out=explanation.held_out.model_copy(update={"rms_ratio": ratio}),
        left_over=explanation.left_over[place.argsort()],
        explained_share=(sum(by_codes) + left.removed) / total if explanation.findings else 1.0,
        findings=(*own, *named_beside(moved, own, np.zeros(6), np.ones(6), noise)),
        small=tuple(small),
        determined=explanation.determined and replace(explanation.determined, axes=matrix),
    )


def _verdict_after_correction(explanation: Explanation) -> Verdict:
    """What becomes of a verdict when a fault is explained besides."""
    if explanation.verdict == "no_mismatch":
        return "explained"
    return "partly_explained" if explanation.verdict == "unexplained" else explanation.verdict


def _matrix(faults: Sequence[Fault], t: np.ndarray) -> np.ndarray:
    """(6, 6) effect of the settings on the readings of each channel."""
    read = np.eye(len(CHANNELS))  # a row for each channel that reads one
    for fault in faults:
        if isinstance(fault, AxisMapping | RangeSetting):
            read = fault.applied(t, read)
    return read.T


def _moved(finding: Finding, matrix: np.ndarray, place: np.ndarray) -> Finding:
    return replace(
        finding,
        channels=tuple(sorted(int(place[c]) for c in finding.channels)),
        contribution=finding.contribution @ matrix.T,
    )


def _event_finding(fault: Fault, contribution: np.ndarray, noise: np.ndarray) -> Finding:
    """The finding of a fault; the offset of wrong codes is compared with the noise (6,).

    Of a setting the residual shows nothing, so that no share of the mismatch is its own.
    """
    if isinstance(fault, CodeFault):
        return event_finding(fault, contribution, _squares(contribution, noise))
    finding = event_finding(fault, contribution, float(-2.0 * np.log(fault.p_value)))
    return replace(finding, held_out_gain=0.0)


def _squares(residual: np.ndarray, noise: np.ndarray) -> float:
    """Sum of squares of (n, 6) over the noise (6,)."""
    return float(np.nansum((residual / np.where(noise > 0, noise, np.inf)) ** 2))


# The share of the mismatch that each finding removes, and which shares deserve an entry.
#
# A drift states its size. Whether a random walk walks: its increments are alike throughout, where
# a signal that switches to and fro (random telegraph noise) changes at a few moments only; they
# are no larger than those of working units, and no slow error of the reference's attitude.

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


# Assembles the explanation from evidence and events.

MOSTLY = 0.5  # explained share up to which what is left is told as a finding of its own
CLEAR_PARAMETER = 3.0  # standard uncertainties from which on a parameter is listed
OTHER = message("explain-other-parameters")


def explanation_of(prepared: Prepared, evidence: Evidence, ordered: bool = False) -> Explanation:
    """The explanation given by a fitted selection, the events and the faults of the logger.

    ordered: exactly these terms were requested, and each is reported whatever the evidence.
    """
    evidence = with_smoothing_error(evidence, prepared)
    full, events, reference = prepared.full, prepared.events.without_added(), prepared.reference
    fit, t, noise = evidence.fit, full.motion.t, np.sqrt(full.rest_variance)
    standard = fitted(model_of((), fit.blocks), fit.blocks, fit.noises)
    predicted, nominal = fit.model.prediction(full.motion), standard.prediction(full.motion)
    to_noise = fitted_to_reference_noise(prepared, standard, evidence)
    scrutinies = scrutinised(evidence)
    determined = determined_model(evidence, scrutinies, full)
    terms = findings_of(evidence, scrutinies, full, determined, to_noise, ordered)
    gains = [max(evidence.together(number), 0.0) for number in scrutinies]
    if reference is not None:
        deviations = reference_deviation(standard, nominal, full, fit)
        terms, gains = terms + deviations, gains + [one.gain for one in deviations]
        nominal = reference.readings
        predicted = predicted + reference.beyond_ideal(full.motion)
    residual = full.readings - events.applied(t, predicted)
    events = events_in_residual(events, residual, noise, full.motion, full.start)
    artefacts = event_findings(events, full, nominal, predicted)
    left, total = artefacts.left, max(sum(gains), 1e-300)
    by_terms = max(left.removed - sum(artefacts.removed), 0.0)
    by_term = [by_terms * gain / total for gain in gains]
    if not ordered:
        nuisances = {group.name for group in evidence.groups if group.nuisance}
        counted = sum(one.gain for one in terms) / max(by_terms, 1e-300)
        unexplained = (left.remaining_by_channel + left.rounded_by_channel) * counted
        named = named_beside(
            terms, artefacts.findings, unexplained, left.chi2_per_degree, noise, nuisances
        )
        terms = [drift(one, full.motion) for one in named]
    findings = with_shares([*artefacts.findings, *terms], [*artefacts.removed, *by_term], left)
    if not ordered:
        # Of what every model has, a part without a name says nothing of the unit: see the remarks.
        common = {t.key for group in evidence.groups if group.nuisance for t in group.terms}
        findings = [
            one for one in findings
            if one.effect != UNNAMED or not one.terms or not common.issuperset(one.terms)
        ]  # fmt: skip
    small = [one for one in findings if not ordered and small_remainder(one, left)]
    reported = [one for one in findings if one not in small]
    mostly = left.explained_share < MOSTLY and not ordered
    if mostly and (rest := remainder(full, artefacts.found, left)):
        reported.append(rest)
    p_value = min([fit.selection.p_value, *(event.p_value for event in artefacts.events.events)])
    explanation = Explanation(
        recording=prepared.recording,
        nominal=nominal,
        found=artefacts.found,
        noise=noise,
        p_value=p_value,
        verdict=_verdict(reported, p_value, left),
        held_out=evidence.held_out(artefacts.per_reading),
        findings=tuple(reported),
        remarks=(*full.remarks, *artefacts.events.remarks),
        model=FITTED if reference is None else reference.model,
        left_over=left.chi2_per_degree,
        explained_share=left.explained_share,
        small=tuple(small),
        determined=determined,
    )
    return with_faults(explanation, prepared, left)


def _verdict(findings: Sequence[Finding], p_value: float, left: LeftOver) -> Verdict:
    """Explained is what has names, and leaves next to noise in every channel."""
    named = [finding for finding in findings if finding.effect != UNNAMED]
    # Where nothing was found, what may be the reference's own errors is no mismatch of the unit.
    known = 1.0 if findings else REFERENCE_KNOWN
    quiet = bool((np.nan_to_num(left.beyond_reference(known)) < MOSTLY_NOISE).all())
    if not findings:
        return "no_mismatch" if quiet and p_value > FALSE_ALARMS else "unexplained"
    if not named:
        return "unexplained"
    complete = bool((np.nan_to_num(left.chi2_per_degree) < NEAR_NOISE).all())
    return "explained" if len(named) == len(findings) and complete else "partly_explained"


def reference_deviation(
    standard: Model, predicted: np.ndarray, full: FullRate, fit: FittedSelection
) -> list[Finding]:
    """The finding that the standard's parameters are not those of the prediction; none: they are.

    standard: the standard's model fitted to the readings less what the prediction has beyond an
    ideal unit. predicted: (n, 6) by it at full rate.
    """
    ideal = Model.of(STANDARD_TERMS)
    count = int(standard.free.sum())
    gain = chi2_of(ideal, fit) - chi2_of(standard, fit)
    if chdtrc(count, max(gain, 0.0)) > FALSE_ALARMS:
        return []
    return [
        Finding(
            effect=UNNAMED,
            family=UNNAMED,
            title=OTHER,
            equation="models (1) and (2)",
            source="JJF 2003-2022, 5.1 and 5.2",
            channels=EVERY,
            parameters=_clear_deviations(standard, ideal.values),
            contribution=predicted - ideal.prediction(full.motion),
            gain=gain,
            delta_bic=gain - count * float(np.log(fit.blocks.used)),
            held_out_gain=0.5 * gain - count,
        )
    ]


def _clear_deviations(standard: Model, ideal: np.ndarray) -> tuple[FoundParameter, ...]:
    """The parameters that clearly deviate, as differences from the prediction's, SI."""
    found = []
    for term, place in zip(STANDARD_TERMS, places(STANDARD_TERMS), strict=True):
        for p, parameter in enumerate(term.parameters, place.start):
            name, u = f"{term.name}_{parameter.name}", float(standard.u[p])
            change = float(standard.values[p] - ideal[p])
            if u > 0 and abs(change) > CLEAR_PARAMETER * u:
                found.append(FoundParameter(name=name, value=change, unit=parameter.si, u=u))
    return tuple(found)
