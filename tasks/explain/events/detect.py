"""Detects events: those that would disturb the regression before it, weaker ones after it.

Spikes: single outlying readings without a name in the catalogue.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.ndimage import binary_dilation, maximum_filter1d
from scipy.stats import norm

from schemas.discrepancy import FoundParameter
from tasks.explain.events.bias_at_rest import BiasAtRest, find_bias_at_rest
from tasks.explain.events.bursts import find_bursts
from tasks.explain.events.dead_zone import find_dead_zone
from tasks.explain.events.dominant_lines import find_dominant_lines
from tasks.explain.events.event import AddedSignal, Event, Events, channel_names
from tasks.explain.events.impacts import find_impacts
from tasks.explain.events.jitter import find_jitter
from tasks.explain.events.lines import find_lines
from tasks.explain.events.lost_samples import aligned_prediction, find_lost_samples, gap_remarks
from tasks.explain.events.noise import noise_by_rate, without_dead
from tasks.explain.events.quantisation import (
    cut_off,
    find_quantisation,
    noise_estimates,
)
from tasks.explain.events.repeats import find_repeats
from tasks.explain.events.residual import Residual
from tasks.explain.events.saturation import find_saturation
from tasks.explain.events.settling import find_settling
from tasks.model.effect import EVENTS
from tasks.model.fit import plain_prediction
from tasks.motion.whole import Motion
from tasks.readings.lattice import Quantiser, quantiser_of
from tasks.words import Message, message

MIN_SPIKES = 3
THRESHOLD = 7.0  # times the noise, by which a reading stands out from both its neighbours
CORNER = 10  # rows
STEADY = 0.02  # rad/s: how far the rate may move where it counts as steady
MIN_REST = 0.05  # share of the rows at rest, so that spikes may be missing there


def events_in_readings(readings: np.ndarray, motion: Motion, start: float = 0.0) -> Events:
    """Events that disturb a regression: rows repeated or lost, limits, dead zone, steps, spikes.

    readings: (n, 6) rad/s and m/s² at the unit's full sample rate, NaN where a triad was not
    recorded. motion: at the same rows, NaN where it is not known. start: of t = 0 on the
    recording's own clock, s.
    """
    t, flat = motion.t, constant_channels(readings)
    at_ends, settling = find_settling(readings, motion)
    if at_ends.any():
        readings = np.where(at_ends, plain_prediction(readings, motion, at_ends), readings)
    quantisers = [quantiser_of(column) for column in readings.T]
    zone, zeroed = _zone(readings, motion, quantisers)
    if isinstance(zone, BiasAtRest):  # all other events act before it
        readings = readings - zone.applied(t, np.zeros(readings.shape))
    repeats = find_repeats(readings, motion, quantisers)
    limits, masked = find_saturation(readings, motion, quantisers)
    masked |= zeroed | flat | at_ends
    predicted = plain_prediction(readings, motion, masked)
    used = np.where(masked, np.nan, readings)
    if masked.any():
        quantisers = [quantiser_of(column) for column in used.T]
    held = masked if repeats is None else masked | repeats.held
    jitter = find_jitter(readings, motion, predicted, held)
    lost = find_lost_samples(readings, motion, masked, start)
    if lost is not None:
        masked = masked | (lost.sampled_at(t) > t[-1])[:, None]  # what moved them is not known
        predicted, _ = aligned_prediction(lost.sampled_at(t), readings, motion, masked)
    times = (event for event in (jitter, repeats, lost) if event is not None)
    events: tuple[Event, ...] = (*times, *limits)
    residual = readings - predicted
    if events:
        corrected = Events(events, masked).corrected(t, readings, predicted)
        residual = corrected - plain_prediction(corrected, motion, masked)
    noises = noise_estimates(used, readings - residual, quantisers)
    short = cut_off(
        noises, used, lambda c: np.asarray((motion.rate if c < 3 else motion.force)[:, c % 3])
    )
    steps = find_quantisation(noises, short)
    level = without_dead(noise_by_rate(used - predicted, motion))
    if steps is not None:
        level = steps.noise_floor(level)
    spikes, at_spikes = find_spikes(used, np.where(masked, np.nan, residual), level, motion)
    lines: tuple[AddedSignal, ...] = ()
    if motion.tracking is None:  # poses do not show how a body vibrates
        unmasked = np.where(masked | at_spikes, np.nan, residual)
        lines = find_dominant_lines(Residual.of(t, unmasked, level, motion), predicted)
    # In the order in which they act: what is added, when a reading was taken, limit, rounding,
    # threshold.
    last = tuple(event for event in (steps, zone, spikes) if event is not None)
    remarks = (*settling, *gap_remarks(t), *flat_remarks(flat), *cut_off_remarks(short))
    return Events((*lines, *events, *last), masked | at_spikes, remarks)


def constant_channels(readings: np.ndarray) -> np.ndarray:
    """(6,) bool: channels that read one value throughout.

    What has no noise would determine every model exactly: such a channel is not used.
    """
    known = np.isfinite(readings)
    top = np.where(known, readings, -np.inf).max(axis=0)
    bottom = np.where(known, readings, np.inf).min(axis=0)
    return np.asarray(top == bottom)


def flat_remarks(flat: np.ndarray) -> tuple[Message, ...]:
    """Which channels are not used because they read one value throughout."""
    if not flat.any():
        return ()
    names = channel_names(tuple(np.flatnonzero(flat).tolist()))
    return (message("events-constant", channels=names),)


def cut_off_remarks(shares: Mapping[int, float]) -> tuple[Message, ...]:
    """Which channels read what share of their input with little noise."""
    return tuple(
        message("events-cut-off", channel=channel_names((channel,)), share=f"{100.0 * share:.0f}")
        for channel, share in shares.items()
    )


def _zone(
    readings: np.ndarray, motion: Motion, quantisers: Sequence[Quantiser | None]
) -> tuple[Event | None, np.ndarray]:
    """What firmware does to small rates, and the readings (n, 6) bool that say nothing for it.

    An estimate of the bias is a closer account of rests whose means lie at zero, and masks none.
    """
    zone, zeroed = find_dead_zone(readings, motion, quantisers)
    if zone is not None and zone.thresholds:
        return zone, zeroed
    estimated = find_bias_at_rest(readings, motion)
    return (zone, zeroed) if estimated is None else (estimated, np.zeros(readings.shape, bool))


def events_in_residual(
    events: Events, residual: np.ndarray, noise: np.ndarray, motion: Motion, start: float = 0.0
) -> Events:
    """The events found before a regression, and lines, impacts and bursts in its residual.

    residual: (n, 6) readings minus `events.applied` to the prediction of the fitted model, NaN
    where that is unknown. noise: (6,) standard deviation of a sample, for channels whose residual
    does not scatter. motion: at the same rows. start: of t = 0 on the recording's own clock, s.
    These events add to what the unit senses, so they act before all others. Poses do not show how
    a body vibrates: fast components of the residual need not be errors, unless they have the mains'
    frequency throughout.
    """
    t, values = motion.t, np.where(events.masked, np.nan, residual)
    level = without_dead(noise_by_rate(values, motion))
    level = np.where(level == 0, noise, level)
    for event in events.events:
        t, level = event.sampled_at(t), event.noise_floor(level)
    left = Residual.of(t, values, level, motion)
    lines = find_lines(left)
    if motion.tracking is not None:
        mains = tuple(line for line in lines if line.effect in EVENTS)
        return Events((*mains, *events.events), events.masked, events.remarks)
    impacts = find_impacts(left.without(*lines))
    if impacts is not None:  # at even speed they look like lines
        left = left.without(impacts)
        lines = find_lines(left)
    nonlinear = tuple(c for event in events.events if not event.linear for c in event.channels)
    bursts = find_bursts(left.without(*lines).without_channels(nonlinear), start)
    transients = tuple(event for event in (impacts, bursts) if event is not None)
    return Events((*lines, *transients, *events.events), events.masked, events.remarks)


def find_spikes(
    readings: np.ndarray, residual: np.ndarray, noise: np.ndarray, motion: Motion
) -> tuple[Event | None, np.ndarray]:
    """Single readings far from both their neighbours, and which (n, 6) bool to mask for them.

    In the readings and in what a plain fit leaves of them (n, 6): the one has the motion's corners,
    the other those of the reference's noise.
    """
    apart = np.minimum(_apart(readings, noise), _apart(residual, noise))
    far = (apart > THRESHOLD) & _steady(motion.rate)[:, None]
    masked = np.asarray(binary_dilation(far, np.ones((3, 1))))
    # A neighbour of a spike stands out as well, by less.
    size = np.where(far, apart, 0.0)
    peak = far & (size == maximum_filter1d(size, 3, axis=0, mode="constant"))
    rows = peak.any(axis=1)
    count = int(rows.sum())
    if count < MIN_SPIKES:
        return None, masked
    channels = tuple(np.flatnonzero(peak.any(axis=0)).tolist())
    at_rest = np.linalg.norm(motion.rate, axis=1) < STEADY
    turning = bool(at_rest.mean() > MIN_REST and not (rows & at_rest).any())
    description = message(
        "events-spikes-in-rotation" if turning else "events-spikes",
        count=count, threshold=f"{THRESHOLD:.0f}", channels=channel_names(channels),
    )  # fmt: skip
    parameters = (FoundParameter(name="spikes", value=float(count), unit="1", u=0.0),)
    expected = far.size * 2 * norm.sf(THRESHOLD)
    p_value = float(min(1.0, expected**MIN_SPIKES))
    return Event("unnamed", channels, parameters, p_value, description), masked


def _apart(values: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """(n, 6) times the noise by which values are off the middle of their neighbours."""
    white = np.divide(values, noise, out=np.full(values.shape, np.nan), where=noise > 0)
    apart = np.zeros(values.shape)
    apart[1:-1] = np.abs(white[1:-1] - 0.5 * (white[:-2] + white[2:])) / np.sqrt(1.5)
    return apart


def _steady(rate: np.ndarray) -> np.ndarray:
    """Rows (n,) bool about which the rate does not change: a corner of a ramp is no spike."""
    moving = np.ones(len(rate), bool)
    change = np.abs(rate[2 * CORNER :] - rate[: -2 * CORNER]).max(axis=1, initial=0.0)
    moving[CORNER:-CORNER] = ~(change < STEADY)
    return ~maximum_filter1d(moving, 2 * CORNER + 1, mode="constant")
