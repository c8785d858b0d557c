"""From events to findings: what each changes in the readings."""

import numpy as np

from tasks.explain.events.event import Event, Events
from tasks.explain.explanation import UNNAMED, Finding
from tasks.explain.inputs.full_rate import FullRate
from tasks.model.events import EVENTS


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
        separated_by=effect.separated_by if effect else None,
    )
