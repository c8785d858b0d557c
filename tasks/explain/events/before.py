"""Events that a regression must know of: limits, slips, steps, spikes. They come before it."""

import numpy as np

from tasks.explain.events.event import Event, Events
from tasks.explain.events.plain import alive, noise_of
from tasks.explain.events.quantisation import Quantisation, find_quantisation
from tasks.explain.events.saturation import find_saturation
from tasks.explain.events.slips import find_slips, gaps
from tasks.explain.events.spikes import find_spikes
from tasks.model.plain_fit import plain_prediction
from tasks.motion.whole import Motion


def find_events(t: np.ndarray, readings: np.ndarray, motion: Motion) -> Events:
    """What happened to the readings of a unit at its full sample rate and hurts a regression.

    t: (n,) s, rising. readings: (n, 6) rad/s and m/s², NaN where a triad was not recorded.
    motion: at the same rows, NaN where it is not known. Lines, clicks and bursts are weaker: they
    are heard in what the regression leaves, see `heard_after`.
    """
    limits, masked = find_saturation(readings, motion)
    slips = find_slips(t, readings, motion, masked)
    free = np.where(masked, np.nan, readings)
    noise = noise_of(free - plain_prediction(readings, motion, masked), motion)
    found: tuple[Event, ...] = (slips,) if slips is not None else ()
    left = _left(t, readings, motion, masked, found + limits, noise)
    steps = find_quantisation(free, readings - left)
    left[masked] = np.nan
    spikes, at_spikes = find_spikes(left, scatter_with(steps, alive(noise)), motion)
    # In the order in which they act: when a reading was taken, limit, rounding.
    last = tuple(event for event in (steps, spikes) if event is not None)
    return Events(found + limits + last, masked | at_spikes, gaps(t))


def scatter_with(steps: Quantisation | None, noise: np.ndarray) -> np.ndarray:
    """The noise (n, 6) with that of coarse steps: near a code nothing scatters."""
    if steps is None:
        return noise
    wider = noise.copy()
    for channel, codes in zip(steps.channels, steps.codes, strict=True):
        wider[:, channel] = np.fmax(wider[:, channel], codes.step / np.sqrt(12))
    return wider


def _left(
    t: np.ndarray,
    readings: np.ndarray,
    motion: Motion,
    masked: np.ndarray,
    events: tuple[Event, ...],
    noise: np.ndarray,
) -> np.ndarray:
    """What a plain fit leaves (n, 6) once the events found so far are undone."""
    predicted = plain_prediction(readings, motion, masked)
    if not events:
        return readings - predicted
    undone = Events(events, masked).undone(t, readings, predicted, noise)
    return undone - plain_prediction(undone, motion, masked)
