"""Readings prepared for the search: events and a long delay of the stamps removed."""

from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import Recording
from tasks.explain.events.detect import events_in_readings
from tasks.explain.events.event import Events
from tasks.explain.events.lost_samples import LostSamples
from tasks.explain.events.quantisation import quantiser_of
from tasks.explain.events.repeats import find_repeats
from tasks.explain.inputs.blocks import Blocks, block_means
from tasks.explain.inputs.delay import advanced, coarse_delay
from tasks.explain.inputs.full_rate import FullRate, full_rate
from tasks.explain.inputs.recorded_signals import within_jumps
from tasks.explain.inputs.reference import ReferencePrediction
from tasks.model.plain_fit import plain_prediction
from tasks.motion.samples import bridged, interpolated

ROUNDS = 4  # of a fit whose prediction shows what events did to the readings


@dataclass(frozen=True)
class Cleaned:
    """A recording without its events and without a delay of all time stamps.

    delay: s by which the stamps were late. masked: (n, 6) bool, readings that say nothing.
    """

    full: FullRate
    delay: float
    events: Events
    masked: np.ndarray

    def blocks(self, rate: float) -> Blocks:
        """Block means at a rate, Hz, compared but for the lines that were removed."""
        blocks = block_means(self.full, rate, self.masked)
        return replace(blocks, lines=self.events.lines)

    def less(self, reference: ReferencePrediction | None, full: FullRate) -> "Cleaned":
        """The same less what a reference predicts beyond an ideal unit. full: as recorded."""
        if reference is None:
            return self
        readings = self.full.readings - reference.beyond_ideal(full.motion)
        return replace(self, full=replace(self.full, readings=readings))

    def with_stamps_of(self, full: FullRate) -> "Cleaned":
        """The same readings at the time stamps as they were recorded."""
        return replace(self, full=replace(self.full, motion=self.as_stamped(full).motion))

    def as_stamped(self, full: FullRate) -> FullRate:
        """What was recorded, with the acceleration that gyros showed `delay` s later."""
        if full.motion.tracking is None or not self.delay:
            return full
        t, known = full.motion.t, np.isfinite(self.full.motion.acceleration).all(axis=1)
        earlier = interpolated(t, t[known] - self.delay, self.full.motion.acceleration[known])
        same = np.where(np.isfinite(full.motion.acceleration), earlier, np.nan)
        return replace(full, motion=replace(full.motion, acceleration=same))


def cleaned(recording: Recording, full: FullRate, delay_sought: bool) -> Cleaned:
    """The readings without events and delay; lost samples hide a delay until they are known, so
    that it is sought before and after them, and held ones feign one.
    """
    delay = coarse_delay(_between_fresh(full)) if delay_sought else 0.0
    advanced_rows, events = _with_delay(recording, full, delay)
    losses = [event for event in events.events if isinstance(event, LostSamples)]
    if losses and delay_sought:
        more = coarse_delay(advanced_rows, until=losses[0].times[0])
        if more:
            delay += more
            advanced_rows, events = _with_delay(recording, full, delay)
    without_events, masked = _without_events(advanced_rows, events)
    return Cleaned(without_events, delay, events, masked)


def _between_fresh(full: FullRate) -> FullRate:
    """The readings with straight lines between samples where a row holds that of another: what is
    held is late by itself, and would be taken for a delay of all stamps.
    """
    repeats = find_repeats(full.readings, full.motion, [quantiser_of(c) for c in full.readings.T])
    if repeats is None or repeats.slipped.any():
        return full
    lines = bridged(np.where(repeats.held, np.nan, full.readings))
    return replace(full, readings=np.where(repeats.held, lines, full.readings))


def _with_delay(recording: Recording, full: FullRate, delay: float) -> tuple[FullRate, Events]:
    rows = full_rate(advanced(recording, delay)) if delay else full
    events = events_in_readings(rows.motion.t, rows.readings, rows.motion, rows.start)
    unknown = within_jumps(recording, rows.motion.t + rows.start)
    return rows, replace(events, masked=events.masked | unknown[:, None])


def _without_events(full: FullRate, events: Events) -> tuple[FullRate, np.ndarray]:
    """The readings as they were before the events changed them, and which (n, 6) say nothing."""
    if not events.events:
        return full, events.masked
    corrected = full.readings
    for _ in range(ROUNDS):
        predicted = plain_prediction(corrected, full.motion, events.masked, own_squared_rate=True)
        corrected = events.corrected(full.motion.t, full.readings, predicted)
    masked = events.masked | (np.isnan(corrected) & np.isfinite(predicted))
    readings = np.where(np.isfinite(corrected), corrected, full.readings)
    return replace(full, readings=readings), masked
