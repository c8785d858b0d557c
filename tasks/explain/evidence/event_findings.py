"""Turns events into findings: what each changes, and whether the readings support it.

States the explanation of repaired readings for the readings as they were recorded.

A fault that is there from the first row to the last is undone before anything else is looked for:
what is found then has the units, axes and codes that it ought to have. Here it is put back.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.discrepancy import Verdict
from tasks.explain.channels import CHANNELS, EVERY
from tasks.explain.events.code_fault import CodeFault
from tasks.explain.events.event import Event, Events
from tasks.explain.events.faults import AxisMapping, Fault, RangeSetting
from tasks.explain.events.saturation import EFFECTS as LIMITS
from tasks.explain.evidence.form_errors import named_beside
from tasks.explain.evidence.left_over import LeftOver
from tasks.explain.explanation import UNNAMED, Explanation, Finding
from tasks.explain.inputs.full_rate import FullRate
from tasks.explain.inputs.prepared import Prepared
from tasks.model.effect import EVENTS

LEAST_P = LEAST_TOTAL = 1e-300
OF_A_LIMIT = 100.0  # ΔBIC, about ten standard deviations: what only bends looks like a limit
CONTRADICTED = 3.0  # standard deviations of a gain by which readings speak against an event
CLEAR = 3.0  # times the noise: a smaller change may be that of the reference's errors


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
    clear = left.squares(change) > CLEAR**2
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
        own.append(_finding(fault, read - found, noise))
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
        verdict=_verdict(explanation),
        held_out=explanation.held_out.model_copy(update={"rms_ratio": ratio}),
        left_over=explanation.left_over[place.argsort()],
        explained_share=(sum(by_codes) + left.removed) / total if explanation.findings else 1.0,
        findings=(*own, *named_beside(moved, own, np.zeros(6), np.ones(6), noise)),
        small=tuple(small),
        determined=explanation.determined and replace(explanation.determined, axes=matrix),
    )


def _verdict(explanation: Explanation) -> Verdict:
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


def _finding(fault: Fault, contribution: np.ndarray, noise: np.ndarray) -> Finding:
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
