"""A made-up run for tests of events: rests, turns about each axis, ramps between, white noise."""

import numpy as np

from tasks.explain.events.detect import events_in_readings
from tasks.explain.events.event import Events
from tasks.motion.whole import Motion
from tasks.words import texts

RATE = 100.0
GRAVITY = 9.8
SIGMA = np.array([1e-3] * 3 + [5e-3] * 3)


def motion(minutes: float = 3.0, top: float = 5.0) -> Motion:
    """Body rate about each axis in turn, up and down to `top` rad/s, between rests of 6 s."""
    t = np.arange(round(60 * minutes * RATE)) / RATE
    period = 20.0  # s: rest 6, ramp 2, turn 10, ramp 2
    phase, turn = t % period, (t // period).astype(int)
    series = np.clip(np.minimum((phase - 6) / 2, (period - phase) / 2), 0, 1)
    speed = top * (1 + turn % 3) / 3 * np.where(turn % 2, 1.0, -1.0) * series
    rate = np.zeros((len(t), 3))
    rate[np.arange(len(t)), turn % 3] = speed
    tilt, azimuth = 0.9 * np.sin(0.013 * t), 0.5 * t / 60
    up = np.column_stack(
        [np.sin(tilt), np.cos(tilt) * np.sin(azimuth), np.cos(tilt) * np.cos(azimuth)]
    )
    zero = np.zeros((len(t), 3))
    return Motion(t, up, zero, rate, np.gradient(rate, t, axis=0), GRAVITY)


def mean_readings(made: Motion) -> np.ndarray:
    """What a unit with small errors reads without noise, (n, 6)."""
    return np.hstack([made.rate * 1.002 + 0.004, made.up * GRAVITY * 0.999 - 0.02])


def noisy(mean: np.ndarray, seed: int) -> np.ndarray:
    return mean + SIGMA * np.random.default_rng(seed).standard_normal(mean.shape)


def counted(readings: np.ndarray, steps: tuple[float, float] = (1e-4, 2e-3)) -> np.ndarray:
    """Rounded to steps of the gyros and the accelerometers."""
    step = np.repeat(steps, 3)
    return np.round(readings / step) * step


def found_in(readings: np.ndarray, made: Motion) -> Events:
    """What is found in readings; each event has a sentence in every language."""
    events = events_in_readings(readings, made)
    assert all(all(texts(event.description).values()) for event in events.events)
    return events


def sizes(events: Events) -> dict[str, float]:
    """The parameters of all events by their names."""
    return {each.name: each.value for event in events.events for each in event.parameters}
