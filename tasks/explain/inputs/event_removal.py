"""The readings before a search: what happened to them, and a long delay of their stamps, undone."""

from dataclasses import replace

import numpy as np

from schemas.recording import Recording
from tasks.explain.events.detect import events_in_readings
from tasks.explain.events.event import Events
from tasks.explain.events.lost_samples import LostSamples
from tasks.explain.inputs.delay import long_delay, taken_back
from tasks.explain.inputs.observed import FullRate, full_rate
from tasks.model.plain_fit import plain_prediction

ROUNDS = 4  # of a fit whose prediction tells what events did to the readings


def without_happenings(
    recording: Recording, full: FullRate, offset_asked: bool
) -> tuple[float, Events, FullRate, np.ndarray]:
    """How late all stamps are, what happened, and the readings without either, as
    `_without_events`; lost samples hide a delay until they are told, so it is asked again.
    """
    late = long_delay(full) if offset_asked else 0.0
    stamped = full_rate(taken_back(recording, late)) if late else full
    events = events_in_readings(stamped.motion.t, stamped.readings, stamped.motion)
    losses = [one for one in events.events if isinstance(one, LostSamples)]
    more = long_delay(stamped, until=losses[0].times[0]) if losses and offset_asked else 0.0
    if more:
        late += more
        stamped = full_rate(taken_back(recording, late))
        events = events_in_readings(stamped.motion.t, stamped.readings, stamped.motion)
    return late, events, *_without_events(stamped, events)


def _without_events(full: FullRate, events: Events) -> tuple[FullRate, np.ndarray]:
    """The readings as they were before the events changed them, and which (n, 6) tell nothing."""
    if not events.events:
        return full, events.masked
    freed = full.readings
    for _ in range(ROUNDS):
        predicted = plain_prediction(np.where(events.masked, np.nan, freed), full.motion)
        freed = events.corrected(full.motion.t, full.readings, predicted)
    masked = events.masked | (np.isnan(freed) & np.isfinite(predicted))
    return replace(full, readings=np.where(np.isfinite(freed), freed, full.readings)), masked
