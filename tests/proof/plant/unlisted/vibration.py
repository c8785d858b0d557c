"""Rectification: accelerometers whose bias follows how much they are shaken."""

import numpy as np

from tests.proof.plant.unlisted.law import ACCELEROMETERS, Law, shares_of_rate, speed
from tests.proof.plant.world import World

SHAKEN = 1.0  # m/s² at the most


def _resonant(world: World) -> np.ndarray:
    """The table shakes most at 0.45 of the largest rate, where its drive meets its base."""
    x = speed(world)
    return np.asarray(SHAKEN * x**2 / np.hypot(1.0 - (x / 0.45) ** 2, 0.5 * x / 0.45) / 0.45)


def _rough(world: World) -> np.ndarray:
    """It shakes as soon as it turns, and little more the faster it does."""
    return np.asarray(SHAKEN * np.tanh(speed(world) / 0.15))


def _power_in_band(world: World) -> np.ndarray:
    return np.asarray(_resonant(world) ** 2)


def _size_of_shaking(world: World) -> np.ndarray:
    return np.asarray(_resonant(world))


def _saturating(world: World) -> np.ndarray:
    power = _resonant(world) ** 2
    return np.asarray(power / (1.0 + 4.0 * power))


def _of_other_axes(world: World) -> np.ndarray:
    """Each is shaken by what turns across it."""
    power = np.abs(shares_of_rate(world)) ** 1.3
    return np.asarray(power.sum(axis=0) - power)


def _beyond_a_speed(world: World) -> np.ndarray:
    return np.asarray(np.maximum(speed(world) - 0.35, 0.0) ** 1.5)


LAWS = (
    Law("power_in_band", "rectification", ACCELEROMETERS, _power_in_band, _resonant),
    Law("size_of_shaking", "rectification", ACCELEROMETERS, _size_of_shaking, _resonant),
    Law("saturating", "rectification", ACCELEROMETERS, _saturating, _resonant),
    Law("of_other_axes", "rectification", ACCELEROMETERS, _of_other_axes, speed),
    Law("rough_bearing", "rectification", ACCELEROMETERS, _rough, _rough),
    Law("beyond_a_speed", "rectification", ACCELEROMETERS, _beyond_a_speed, speed),
)
