"""Events that are heard in what a regression leaves: lines, clicks, bursts."""

from collections.abc import Sequence

import numpy as np

from tasks.explain.events.before import scatter_with
from tasks.explain.events.bursts import find_bursts
from tasks.explain.events.clicks import find_clicks
from tasks.explain.events.event import Event, Events
from tasks.explain.events.lines import find_lines
from tasks.explain.events.plain import alive, noise_of
from tasks.explain.events.quantisation import Quantisation
from tasks.explain.events.saturation import Saturation
from tasks.explain.events.slips import Slips, delay
from tasks.motion.whole import Motion

TURNS = 0.05  # rad/s


def heard_after(
    events: Events, t: np.ndarray, residual: np.ndarray, noise: np.ndarray, motion: Motion
) -> Events:
    """The events found before a regression, and those that are heard in what it leaves.

    t: (n,) s. residual: (n, 6) readings minus `events.applied` to what the fitted model predicts,
    NaN where that is not known or `events.masked`. noise: (6,) standard deviation of a sample,
    where the residual itself tells none. motion: at the same rows.
    What is heard is added to what the unit senses, so that it acts before all that follows.
    """
    taken = _taken_at(events, t)
    left = np.where(events.masked, np.nan, residual)
    level = _level(events, left, noise, motion)
    turning = np.linalg.norm(motion.rate, axis=1) > TURNS
    lines = find_lines(taken, left, level, turning)
    clicks = find_clicks(taken, _without(lines, taken, left), level, motion)
    if clicks is not None:  # at even speed they look like lines
        left = _without((clicks,), taken, left)
        lines = find_lines(taken, left, level, turning)
    left = _without(lines, taken, left)
    left[:, _uneven(events)] = np.nan
    bursts = find_bursts(taken, left, level, motion)
    rung = tuple(event for event in (clicks, bursts) if event is not None)
    return Events(lines + rung + events.events, events.masked, events.remarks)


def _without(events: Sequence[Event], t: np.ndarray, left: np.ndarray) -> np.ndarray:
    """What is left (n, 6) once events are taken out as well."""
    nothing = np.zeros(left.shape)
    for event in events:
        left = left - event.applied(t, nothing, nothing)
    return left


def _taken_at(events: Events, t: np.ndarray) -> np.ndarray:
    """When each reading was taken, s: stamps slip where samples were lost."""
    for event in events.events:
        if isinstance(event, Slips):
            return t + delay(t, event.times, event.lost) * event.interval
    return t


def _uneven(events: Events) -> list[int]:
    """Channels with a limit or with visible steps: they leave more than noise."""
    return [
        channel for event in events.events if isinstance(event, Quantisation | Saturation)
        for channel in event.channels
    ]  # fmt: skip


def _level(events: Events, residual: np.ndarray, noise: np.ndarray, motion: Motion) -> np.ndarray:
    """The noise (n, 6) that the residual has at each rate."""
    level = alive(noise_of(residual, motion))
    level = np.where(level == 0, noise, level)
    for event in events.events:
        if isinstance(event, Quantisation):
            level = scatter_with(event, level)
    return level
