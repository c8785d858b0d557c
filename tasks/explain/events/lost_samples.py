"""Dropped samples: lost in transmission, with stamps counted from those that arrived.

After each loss the stamps lag behind by so many sample intervals, so that a reading stamped t was
taken at t + δ, and differs from what is predicted for t by δ·dy/dt.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import EVERY
from tasks.explain.events.event import Event
from tasks.explain.events.noise import noise_by_rate
from tasks.model.fit import plain_prediction
from tasks.motion.samples import gaps, interpolated, sample_interval
from tasks.motion.whole import Motion
from tasks.readings.slips import (
    MODEL_U,
    OUTLIER,
    Staircase,
    fit_staircase,
    placed,
    window_delays,
)
from tasks.words import Message, message
from tasks.words.quantities import moment

GAP = 0.5  # sample intervals by which stamps are late after a gap
ROUNDS = 2  # the second with a fit that the losses do not disturb


@dataclass(frozen=True)
class LostSamples(Event):
    """times: (k,) s, stamps from which on. lost: (k,) whole samples. interval: s."""

    times: np.ndarray
    lost: np.ndarray
    interval: float

    def sampled_at(self, t: np.ndarray) -> np.ndarray:
        before = np.searchsorted(self.times, t, side="right")
        return t + np.concatenate([[0], np.cumsum(self.lost)])[before] * self.interval

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return interpolated(self.sampled_at(t), t, predicted)


def find_lost_samples(
    readings: np.ndarray, motion: Motion, masked: np.ndarray, start: float = 0.0
) -> LostSamples | None:
    """Losses that the stamps do not show.

    masked: (n, 6) readings that a limit disturbs. start: of t = 0 on the recording's own clock, s.
    """
    t = motion.t
    if len(t) < 3 or not motion.known.any():
        return None
    own = slice(0, 3) if np.isfinite(readings[:, :3]).any() else slice(3, 6)
    used, interval = np.where(masked, np.nan, readings), motion.interval
    # What scale factors are fitted to readings that slip is worth less than none.
    signal = motion.rate if own.start == 0 else motion.force
    event: LostSamples | None = None
    for _ in range(ROUNDS):
        delays = window_delays(t, interval, used[:, own], signal)
        steps = None if delays is None else fit_staircase(delays)
        if steps is None:
            return event
        predicted, late = aligned_prediction(
            t + steps.delay(t) * interval, readings, motion, masked
        )
        signal = predicted[:, own]
        slope = np.gradient(predicted, t, axis=0) * interval  # per sample interval
        variance = noise_by_rate(used - late, motion) ** 2 + (2 * MODEL_U * slope) ** 2
        event = _event(t, interval, used, predicted, variance, steps, start)
    return event


def aligned_prediction(
    instants: np.ndarray, readings: np.ndarray, motion: Motion, masked: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The plain fit of readings (n, 6) by the motion when they were taken, instants (n,) s that
    rise: what it predicts for the stamps, and for the instants.

    A fit beside the stamps would lose the more of the motion the farther they slipped.
    """

    count = len(readings)

    def both(values: np.ndarray) -> np.ndarray:
        then = interpolated(instants, motion.t, values.reshape(count, -1))
        return np.concatenate([then.reshape(values.shape), values])

    unread = np.full(readings.shape, np.nan)
    masked = masked | (instants > motion.t[-1])[:, None]
    fitted = plain_prediction(
        np.concatenate([readings, unread]), motion.mapped(both), np.concatenate([masked, masked])
    )
    return fitted[count:], fitted[:count]


def _event(
    t: np.ndarray, interval: float, readings: np.ndarray, predicted: np.ndarray,
    variance: np.ndarray, steps: Staircase, start: float,
) -> LostSamples:  # fmt: skip
    """Each jump of the staircase, placed by all rows (n, 6) of the windows beside it."""
    times, losses, parameters, texts = [], [], list[FoundParameter](), []
    jumps = np.flatnonzero(np.diff(steps.lost))
    for near in np.split(jumps, np.flatnonzero(np.diff(jumps) > 1) + 1):
        beside = steps.delays.at[[near[0], near[-1] + 1]] + steps.delays.width / 2 * np.array(
            [-1, 1]
        )
        first, last = np.searchsorted(t, beside)
        levels = np.arange(steps.lost[near[0]], steps.lost[near[-1] + 1] + 1)
        cost = np.empty((len(levels), last - first))
        for each, level in zip(cost, (steps.first + levels) * interval, strict=True):
            off = readings[first:last] - interpolated(t[first:last] + level, t, predicted)
            each[:] = np.minimum(np.nansum(off**2 / variance[first:last], axis=1), OUTLIER)
        cost[:-1, -1] = np.inf
        for low, high, lost in placed(cost):
            begun, ended = float(t[first + low]), float(t[min(first + high, len(t) - 1)])
            time, u = 0.5 * (begun + ended), max((ended - begun) / np.sqrt(12), interval)
            times.append(time)
            losses.append(float(lost))
            parameters += [
                FoundParameter(name=f"lost_{len(times)}", value=lost, unit="1", u=steps.u),
                FoundParameter(name=f"time_{len(times)}", value=start + time, unit="s", u=u),
            ]
            texts.append(
                message("events-lost-samples-at", lost=f"{lost:d}", time=moment(start + time))
            )
    return LostSamples(
        "dropped_samples", EVERY, tuple(parameters), float(chi2.sf(steps.gain, 2 * len(times))),
        message("events-lost-samples", losses=tuple(texts)), np.array(times), np.array(losses),
        interval,
    )  # fmt: skip


def gap_remarks(t: np.ndarray) -> tuple[Message, ...]:
    """Rows that are missing by the stamps themselves."""
    if len(t) < 2:
        return ()
    interval = sample_interval(t)
    before = gaps(t, interval, GAP)
    if not len(before):
        return ()
    missing = int(np.round((t[before + 1] - t[before]) / interval - 1).sum())
    return (message("events-gaps", gaps=len(before), missing=missing),)
