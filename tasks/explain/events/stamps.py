"""Faults of the time stamps: jitter, and rows that are missing."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.ndimage import median_filter, uniform_filter1d
from scipy.signal import savgol_filter
from scipy.stats import chi2, norm

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import Event, noise_by_rate
from tasks.explain.explanation import CHANNELS, EVERY, GYROS
from tasks.model.fit import plain_prediction
from tasks.motion.samples import gaps, interpolated, sample_interval
from tasks.motion.whole import Motion
from tasks.readings.robust import deviation
from tasks.readings.stamps import MODEL_U, OUTLIER, Staircase, fit_staircase, placed, window_delays
from tasks.words import Message, message
from tasks.words.numbers import moment

# Time stamps that scatter about the true instants.
#
# A logger that stamps rows when they arrive makes stamps uneven though the sensor samples evenly.
# Uneven stamps alone do not tell: sampling may be uneven and the stamps right. While the motion
# changes, the readings tell: where stamps are off by j, a reading differs by −j·dy/dt from what
# is predicted for its stamp, and where they are right it does not.

MISSING_ROWS = (
    1.5  # sample intervals by which stamps are late: rows are missing, evenness begins anew
)
SMOOTH = 101  # rows over which the true instants are even
WAITED, QUICK = SMOOTH // 2, 0.35  # rows that come in so small a part of their time: a backlog
LEAST = 1e-6  # s: less is the rounding of stamps in double precision
NEAR_ONE = 0.15  # how near the share of what the stamps claim must be to one
SLOPE_WINDOW, FEWEST = 0.15, 5  # s, and rows at least, of a parabola whose slope is the motion's
SIGNIFICANT = 1e-7
TRIMMED = 6.0  # times the scatter: rows with more are left out


@dataclass(frozen=True)
class StampJitter(Event):
    """late: (n,) s by which each stamp is after the true instant."""

    late: np.ndarray

    def sampled_at(self, t: np.ndarray) -> np.ndarray:
        return t - self.late

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return interpolated(self.sampled_at(t), t, predicted)


def find_jitter(
    readings: np.ndarray, motion: Motion, predicted: np.ndarray, masked: np.ndarray
) -> StampJitter | None:
    """The jitter of the stamps, where readings (n, 6) say that sampling was even.

    predicted: (n, 6) by a plain fit. masked: (n, 6) readings that are not used.
    """
    t = motion.t
    if len(t) < 3 * SMOOTH or not motion.known.any():
        return None
    late, usual = _uneven(t)
    if not np.std(late[usual]) > LEAST:
        return None
    used = np.where(masked | ~usual[:, None], np.nan, readings)
    shares = [
        estimate
        for c in range(len(CHANNELS))
        if (estimate := _share(t, used[:, c], predicted[:, c], late))
    ]
    if not shares:
        return None
    values, weights = np.array([s for s, _ in shares]), np.array([u**-2 for _, u in shares])
    share = float(values @ weights / weights.sum())
    u = float(weights.sum() ** -0.5)
    chi2 = float(((values - share) ** 2 * weights).sum())
    u *= max(1.0, np.sqrt(chi2 / max(1, len(shares) - 1)))
    p_value = 2.0 * float(norm.sf(abs(share) / u))
    if p_value > SIGNIFICANT or abs(share - 1.0) > max(NEAR_ONE, 3.0 * u) or 3.0 * u > 0.5:
        return None
    size = float(np.std(late[usual]))
    return StampJitter(
        "timestamp_jitter", GYROS if np.isfinite(readings[:, :3]).any() else (3, 4, 5),
        (FoundParameter(name="jitter", value=size, unit="s", u=size * max(u, 0.02)),),
        p_value, message("events-jitter", jitter=f"{1e3 * size:.3g}"), late,
    )  # fmt: skip


def _uneven(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,) s by which stamps are after an even course, between gaps each for itself and 0 on the
    mean, and which of them (n,) bool scatter: those of a backlog are late by what waited.
    """
    interval = sample_interval(t)
    late, usual = np.zeros(len(t)), ~_backlog(t, interval)
    edges = [0, *(gaps(t, interval, MISSING_ROWS) + 1).tolist(), len(t)]
    for start, stop in pairwise(edges):
        rows = np.flatnonzero(usual[start:stop])
        if len(rows) < SMOOTH:
            continue
        since, every = t[start:stop] - t[start], np.arange(stop - start)
        off = since - np.polyval(np.polyfit(rows, since[rows], 1), every)
        course = uniform_filter1d(median_filter(off[rows], SMOOTH, mode="nearest"), SMOOTH)
        off -= np.interp(every, rows, course)
        late[start:stop] = off - off[rows].mean()
    return late, usual & (np.abs(late) <= TRIMMED * deviation(late[usual]))


def _backlog(t: np.ndarray, interval: float) -> np.ndarray:
    """(n,) bool: rows that had waited, as many that came in a small part of the time they take."""
    waited = t[WAITED:] - t[:-WAITED] < QUICK * WAITED * interval
    after = np.convolve(waited, np.ones(WAITED + 1))
    return np.asarray(after > 0.5)


def _share(
    t: np.ndarray, reading: np.ndarray, predicted: np.ndarray, late: np.ndarray
) -> tuple[float, float] | None:
    """How much of the stamps' unevenness a channel's readings deny, and its standard uncertainty.

    From second differences, in which only what changes from row to row is left.
    """
    changes = np.diff(reading[np.isfinite(reading)])
    if len(changes) < SMOOTH or not np.median(np.abs(changes)) > 0.0:
        return None  # a step so coarse that most readings repeat does not tell an instant
    even = np.interp(t - late, t, predicted)
    # The noise of a reference makes slopes of its own, which are no motion.
    rows = max(FEWEST, 2 * round(0.5 * SLOPE_WINDOW / sample_interval(t)) + 1)
    slope = savgol_filter(even, rows, 2, 1, mode="nearest") / sample_interval(t)
    column = _rough(-slope * late)
    left = _rough(reading - savgol_filter(even, rows, 2, mode="nearest")) + column
    known = np.isfinite(left) & np.isfinite(column)
    if known.sum() < SMOOTH:
        return None
    left, column = left[known], column[known]
    scatter = float(np.median(np.abs(left))) / 0.6745
    used = np.abs(left) < TRIMMED * scatter + np.abs(column)
    left, column = left[used], column[used]
    power = float(column @ column)
    if power <= 0.0:
        return None
    share = float(column @ left) / power
    # What is left need not scatter alike where the motion changes: the sandwich.
    u = float(np.sqrt(((column * (left - share * column)) ** 2).sum())) / power
    return share, u * np.sqrt(2.0)


def _rough(values: np.ndarray) -> np.ndarray:
    return np.asarray(np.diff(values, 2))


# Dropped samples: lost in transmission, with stamps counted from those that arrived.
#
# After each loss the stamps lag behind by so many sample intervals, so that a reading stamped t
# was taken at t + δ, and differs from what is predicted for t by δ·dy/dt.

LATE_AFTER_GAP = 0.5  # sample intervals by which stamps are late after a gap
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
    before = gaps(t, interval, LATE_AFTER_GAP)
    if not len(before):
        return ()
    missing = int(np.round((t[before + 1] - t[before]) / interval - 1).sum())
    return (message("events-gaps", gaps=len(before), missing=missing),)
