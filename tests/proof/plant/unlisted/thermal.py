"""Late temperature: biases that the unit's temperature reaches after its thermometer."""

import numpy as np
from scipy.signal import fftconvolve

from tests.proof.plant.unlisted.law import BOTH, Law, speed
from tests.proof.plant.world import World

PADDING = 3000.0  # s before the run, through which it was in balance


def _through(world: World, kernel: np.ndarray, pace: float) -> np.ndarray:
    """The temperature's deviation from its first value through a kernel, every `pace` s."""
    temperature = world.weather.temperature
    at = np.arange(world.t[0], world.t[-1] + pace, pace)
    coarse = np.interp(at, world.t, temperature - temperature[0])
    return np.interp(world.t, at, fftconvolve(coarse, kernel)[: len(at)])


def _lag(world: World, tau: float, pace: float = 0.5) -> np.ndarray:
    after = np.arange(0.0, PADDING, pace)
    kernel = np.exp(-after / tau)
    return _through(world, kernel / kernel.sum(), pace)


def _one_lag_bent(world: World) -> np.ndarray:
    """Late, and more than in proportion."""
    late = _lag(world, 80.0)
    return np.asarray(late + late**2 / 6.0)


def _two_lags(world: World) -> np.ndarray:
    """A fast part inside a slow one: what the one gives, the other takes."""
    return _lag(world, 30.0) - 1.6 * _lag(world, 240.0)


def _diffusion(world: World) -> np.ndarray:
    """Into a thick wall: the course of √t after each step of the temperature."""
    pace = 0.5
    after = np.arange(pace, PADDING, pace)
    depth = 120.0  # s
    kernel = np.exp(-depth / after) / after**1.5
    return _through(world, kernel / kernel.sum(), pace)


def _late_gradient(world: World) -> np.ndarray:
    """The heat that flows, a minute late."""
    return np.asarray((_lag(world, 45.0) - _lag(world, 75.0)) / 30.0)


def _dead_time(world: World) -> np.ndarray:
    """As it was 75 s before."""
    temperature = world.weather.temperature
    return np.interp(world.t - 75.0, world.t, temperature)


def _self_heating(world: World) -> np.ndarray:
    """What a spin beyond half of the largest rate warms, over 70 s; no thermometer is near it."""
    load = np.where(speed(world) > 0.5, speed(world) ** 2, 0.0)
    pace = 0.5
    after = np.arange(0.0, PADDING, pace)
    kernel = np.exp(-after / 70.0)
    at = np.arange(world.t[0], world.t[-1] + pace, pace)
    coarse = np.interp(at, world.t, load)
    return np.interp(world.t, at, fftconvolve(coarse, kernel / kernel.sum())[: len(at)])


def _play_in_temperature(world: World) -> np.ndarray:
    """Joints that give way by 0.8 K before they follow, through a lag of 20 s."""
    state, states = 0.0, []
    for now in _lag(world, 20.0)[::50].tolist():
        state = min(max(state, now - 0.8), now + 0.8)
        states.append(state)
    return np.repeat(states, 50)[: len(world.t)]


LAWS = (
    Law("late_and_bent", "late temperature", BOTH, _one_lag_bent),
    Law("two_lags", "late temperature", BOTH, _two_lags),
    Law("diffusion", "late temperature", BOTH, _diffusion),
    Law("late_gradient", "late temperature", BOTH, _late_gradient),
    Law("dead_time", "late temperature", BOTH, _dead_time),
    Law("self_heating", "late temperature", BOTH, _self_heating),
    Law("play_in_temperature", "late temperature", BOTH, _play_in_temperature),
)
