"""From events to findings: what each changes, and whether the readings bear it out."""

from dataclasses import replace

import numpy as np

from tasks.explain.events.event import Event, Events
from tasks.explain.evidence.left_over import LeftOver
from tasks.explain.explanation import UNNAMED, Finding
from tasks.explain.inputs.full_rate import FullRate
from tasks.model.effect import EVENTS

LEAST_P = 1e-300
CONTRADICTED = 3.0  # standard deviations of a gain by which readings speak against an event


def event_findings(
    events: Events, full: FullRate, predicted: np.ndarray, left: LeftOver
) -> tuple[list[Finding], Events]:
    """Findings of the events, each with what it changes after those before it; and the events
    that are findings: what gains nothing is a remark on the readings.

    predicted: (n, 6) readings without events. left: of all that was found, all events included.
    """
    before = predicted
    found, kept, remarks = list[Finding](), list[Event](), list(events.remarks)
    for event in events.events:
        after = event.applied(full.motion.t, before)
        gain = _gain(event, _without(event, events, full, predicted), left)
        finding = _finding(event, after - before, gain, full)
        if finding.delta_bic > 0.0 and finding.held_out_gain > 0.0:
            found.append(finding)
            kept.append(event)
        else:
            remarks.append(event.description)
        before = after
    return found, replace(events, events=tuple(kept), remarks=tuple(remarks))


def removed_by(
    events: Events, full: FullRate, predicted: np.ndarray, left: LeftOver
) -> list[float]:
    """Chi-squared at the unit's rows that each event removes, not below zero."""
    residuals = (_without(event, events, full, predicted) for event in events.events)
    return [max(0.0, float(np.nansum(left.squares(one) - left.after))) for one in residuals]


def _without(event: Event, events: Events, full: FullRate, predicted: np.ndarray) -> np.ndarray:
    """(n, 6) readings less what is predicted with all other events."""
    others = replace(events, events=tuple(one for one in events.events if one is not event))
    return full.readings - others.applied(full.motion.t, predicted)


def _gain(event: Event, residual: np.ndarray, left: LeftOver) -> float:
    """Chi-squared that an event explains, counted against what is left in its channels.

    What changes no mean reading (a pile at a limit, steps, spikes) has its own test's p value;
    but not where the readings are clearly farther from the model with the event than without.
    residual: (n, 6) readings less what is predicted with all other events.
    """
    squares = left.squares(residual)
    gain = float(np.nansum(squares - left.after))
    moved = np.abs(np.sqrt(squares) - np.sqrt(left.after))
    spread = max(1.0, float(np.nanmean(left.chi2_per_degree[list(event.channels)])))
    if gain < -CONTRADICTED * spread * float(np.sqrt(np.nansum(moved**2))):
        return gain / spread
    return max(gain / spread, -2.0 * float(np.log(max(event.p_value, LEAST_P))))


def _finding(event: Event, contribution: np.ndarray, gain: float, full: FullRate) -> Finding:
    effect = EVENTS.get(event.effect)
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
