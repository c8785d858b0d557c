"""Dropped samples: lost in transmission, with stamps counted from those that arrived.

After each loss the stamps lag behind by so many sample intervals, so that a reading stamped t was
taken at t + δ, and differs from what is predicted for t by δ·dy/dt.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import EVERY
from tasks.explain.events.delays import (
    MODEL_U,
    WindowDelays,
    delays_by_grid,
    delays_by_slope,
    oscillates,
)
from tasks.explain.events.event import Event
from tasks.explain.events.noise import noise_by_rate
from tasks.model.fit import plain_prediction
from tasks.motion.samples import gaps, interpolated, sample_interval
from tasks.motion.whole import Motion
from tasks.words import Message, message
from tasks.words.quantities import moment

FLAT = 0.5  # of the noise: what changes less from sample to sample is the encoders' noise
GAP = 0.5  # sample intervals by which stamps are late after a gap
MIN_WINDOWS = 6
MAX_LOST = 30  # samples in all
CHANGE_POINT_COST = 30.0  # chi-squared that a further loss must gain
MIN_GAIN = 75.0  # chi-squared that losses must gain against a constant and a running delay
CLOSE = 0.2  # sample intervals: half of the windows lie nearer to the staircase
WHOLE = 0.25  # sample intervals that a step may be off a whole number


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


@dataclass(frozen=True)
class Staircase:
    """Whole samples lost (m,) before each window of the delays, from 0 up."""

    delays: WindowDelays
    lost: np.ndarray

    @property
    def first(self) -> float:
        """The delay before the first loss, in sample intervals."""
        return float(np.median(self.delays.delay - self.lost))

    @property
    def gain(self) -> float:
        """Chi-squared against a constant delay."""
        constant = self.delays.cost(np.median(self.delays.delay)).sum()
        return float(constant - self.delays.cost(self.first + self.lost).sum())

    @property
    def u(self) -> float:
        """Standard uncertainty of the number of samples that a step is high."""
        levels = (self.delays.u[self.lost == level] for level in np.unique(self.lost))
        return max(float(np.median(level)) / len(level) ** 0.5 for level in levels)

    def delay(self, t: np.ndarray) -> np.ndarray:
        """The delay (n,) at times t (n,) s, in sample intervals."""
        window = np.clip(np.searchsorted(self.delays.at, t), 0, len(self.lost) - 1)
        return self.first + self.lost[window]


def find_lost_samples(
    readings: np.ndarray,
    motion: Motion,
    predicted: np.ndarray,
    masked: np.ndarray,
    start: float = 0.0,
) -> LostSamples | None:
    """Losses that the stamps do not show.

    predicted: (n, 6) by a plain fit. masked: (n, 6) readings that a limit disturbs. start: of
    t = 0 on the recording's own clock, s.
    """
    t = motion.t
    if len(t) < 3 or not motion.known.any():
        return None
    interval = motion.interval
    noise = noise_by_rate(readings - predicted, motion)
    slope = np.gradient(predicted, t, axis=0) * interval  # per sample interval
    slope = np.where(np.abs(slope) > FLAT * noise, slope, 0.0)
    used = np.where(masked, np.nan, readings)
    grid = delays_by_grid(t, used[:, :3], motion.rate) if oscillates(motion) else None
    event: LostSamples | None = None
    for _ in range(2):  # the second time with a fit that the losses do not disturb
        steps = fit_staircase(grid or delays_by_slope(t, used - predicted, predicted, slope, noise))
        if steps is None:
            return None
        if grid:
            late = interpolated(t + steps.delay(t) * interval, t, predicted)
            noise = noise_by_rate(used - late, motion)
        variance = noise**2 + (2 * MODEL_U * slope) ** 2
        event = _event(t, interval, used, predicted, variance, steps, start)
        shift = event.applied(t, predicted) - predicted
        predicted = plain_prediction(readings - np.nan_to_num(shift), motion, masked)
    return event


def _event(
    t: np.ndarray, interval: float, readings: np.ndarray, predicted: np.ndarray,
    variance: np.ndarray, steps: Staircase, start: float,
) -> LostSamples:  # fmt: skip
    """Each jump of the staircase, placed by all rows (n, 6) of the two windows beside it."""
    times, losses, parameters, texts = [], [], list[FoundParameter](), []
    reach = steps.delays.width / 2
    for k in np.flatnonzero(np.diff(steps.lost)):
        first = int(np.searchsorted(t, steps.delays.at[k] - reach))
        rows = slice(first, int(np.searchsorted(t, steps.delays.at[k + 1] + reach)))
        levels = (steps.first + steps.lost[k : k + 2]) * interval
        signals = (interpolated(t[rows] + level, t, predicted) for level in levels)
        before, after = (
            np.nan_to_num((readings[rows] - signal) ** 2 / variance[rows]) for signal in signals
        )
        # Chi-squared if the jump comes before row j: what is before it, and after it.
        cost = np.concatenate([[0.0], np.cumsum((before - after).sum(axis=1))])
        likely = first + np.flatnonzero(cost <= cost.min() + 4)
        low, high = float(t[likely[0]]), float(t[min(likely[-1], len(t) - 1)])
        time, lost = 0.5 * (low + high), float(steps.lost[k + 1] - steps.lost[k])
        u = max((high - low) / np.sqrt(12), interval)
        times.append(time)
        losses.append(lost)
        parameters += [
            FoundParameter(name=f"lost_{len(times)}", value=lost, unit="1", u=steps.u),
            FoundParameter(name=f"time_{len(times)}", value=start + time, unit="s", u=u),
        ]
        texts.append(
            message("events-lost-samples-at", lost=f"{lost:.0f}", time=moment(start + time))
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


def fit_staircase(delays: WindowDelays) -> Staircase | None:
    """The staircase of the delays; None if they do not form one."""
    if len(delays.at) < MIN_WINDOWS:
        return None
    path, start = _best_path(delays)
    if path[0] != 0 or path[-1] == 0 or path[-1] >= MAX_LOST:
        return None
    constant = delays.cost(np.median(delays.delay)).sum()
    if min(constant, _drift_cost(delays)) - _cost(delays, path, start) < MIN_GAIN:
        return None
    close = float(np.median(np.abs(delays.delay - start - path))) < CLOSE
    if not close and 2 * delays.cost(start + path).sum() > constant:
        return None
    levels = [float(np.median(delays.delay[path == step])) - step for step in np.unique(path)]
    return Staircase(delays, path) if np.ptp(levels) < WHOLE else None


def _cost(delays: WindowDelays, path: np.ndarray, start: float) -> float:
    """Chi-squared of a staircase, its change points included."""
    steps = CHANGE_POINT_COST * np.count_nonzero(np.diff(path))
    return float(delays.cost(start + path).sum() + steps)


def _best_path(delays: WindowDelays) -> tuple[np.ndarray, float]:
    """The cheapest staircase (m,) and its first delay, from several first delays to begin with."""
    candidates = []
    for first in np.unique(np.round(delays.delay[: max(3, len(delays.at) // 4)], 1)):
        path = _cheapest_path(delays, float(first))
        for _ in range(3):
            start = float(np.median(delays.delay - path))
            path = _cheapest_path(delays, start)
        candidates.append((path, start))
    return min(candidates, key=lambda candidate: _cost(delays, *candidate))


def _cheapest_path(delays: WindowDelays, start: float) -> np.ndarray:
    """The rising staircase of least cost, by dynamic programming over the samples lost."""
    states = np.arange(MAX_LOST + 1)
    cost = delays.cost(start + states[:, None])  # (states, windows)
    total = np.where(states == 0, cost[:, 0], np.inf)
    came_from = np.zeros(cost.shape, int)
    for k in range(1, cost.shape[1]):
        best = np.minimum.accumulate(total)
        first = np.maximum.accumulate(np.where(total == best, states, 0))
        jump = np.concatenate([[np.inf], best[:-1]]) + CHANGE_POINT_COST
        stay = total <= jump
        came_from[:, k] = np.where(stay, states, np.concatenate([[0], first[:-1]]))
        total = np.where(stay, total, jump) + cost[:, k]
    path = [int(total.argmin())]
    for k in range(cost.shape[1] - 1, 0, -1):
        path.append(int(came_from[path[-1], k]))
    return np.array(path[::-1], float)


def _drift_cost(delays: WindowDelays) -> float:
    """Chi-squared of a delay that grows evenly, as of a clock that runs fast (robust line fit)."""
    weight = 1 / delays.u
    line = np.polyfit(delays.at, delays.delay, 1, w=weight)
    for _ in range(5):
        off = np.abs(delays.delay - np.polyval(line, delays.at)) * weight
        line = np.polyfit(delays.at, delays.delay, 1, w=weight / np.sqrt(np.maximum(off / 2, 1)))
    return float(delays.cost(np.polyval(line, delays.at)).sum())
