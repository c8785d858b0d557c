"""All events of a recording: limits first, for they disturb the fit that the others are seen by."""

import numpy as np

from tasks.explain.events.event import Event, Events
from tasks.explain.events.lines import find_lines
from tasks.explain.events.plain import noise_of, predictions
from tasks.explain.events.quantisation import find_quantisation
from tasks.explain.events.saturation import find_saturation
from tasks.explain.events.slips import find_slips, gaps
from tasks.explain.events.transients import find_bursts, find_spikes
from tasks.motion.whole import Motion

TURNS = 0.05  # rad/s


def find_events(t: np.ndarray, readings: np.ndarray, motion: Motion) -> Events:
    """What happened to the readings of a unit at its full sample rate.

    t: (n,) s, rising. readings: (n, 6) rad/s and m/s², NaN where a triad was not recorded.
    motion: at the same rows, NaN where it is not known.
    """
    limits, masked = find_saturation(readings, motion)
    slips = find_slips(t, readings, motion, masked)
    free = np.where(masked, np.nan, readings)
    noise = noise_of(free - predictions(readings, motion, masked), motion)
    heard: tuple[Event, ...] = (slips,) if slips is not None else ()
    kept = _kept(t, readings, motion, masked, heard + limits, noise)
    steps = find_quantisation(free, readings - kept)
    kept[masked] = np.nan
    turning = np.linalg.norm(motion.rate, axis=1) > TURNS
    lines = find_lines(t, kept, noise, turning)
    for line in lines:
        kept = kept - line.applied(t, np.zeros(kept.shape), noise)
    if steps is not None:  # near a code nothing scatters, and then by a whole step
        for channel, codes in zip(steps.channels, steps.codes, strict=True):
            noise[:, channel] = np.maximum(noise[:, channel], codes.step / np.sqrt(12))
    spikes, at_spikes = find_spikes(kept, noise, motion)
    bursts, in_bursts = find_bursts(t, np.where(at_spikes, np.nan, kept), noise, motion)
    # In the order in which they act: what is added, when it was taken, limit, rounding.
    last = tuple(event for event in (steps, spikes, bursts) if event is not None)
    return Events(lines + heard + limits + last, masked | at_spikes | in_bursts, gaps(t))


def _kept(
    t: np.ndarray,
    readings: np.ndarray,
    motion: Motion,
    masked: np.ndarray,
    events: tuple[Event, ...],
    noise: np.ndarray,
) -> np.ndarray:
    """What a fit leaves (n, 6) once the events found so far are undone."""
    predicted = predictions(readings, motion, masked)
    if not events:
        return readings - predicted
    undone = Events(events, masked).undone(t, readings, predicted, noise)
    return undone - predictions(undone, motion, masked)
