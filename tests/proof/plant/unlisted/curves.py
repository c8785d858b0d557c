"""Non-linearity: readings that bend over their own input, without memory."""

import numpy as np

from tests.proof.plant.unlisted.law import (
    ACCELEROMETERS,
    GYROS,
    Law,
    shares_of_force,
    shares_of_rate,
)
from tests.proof.plant.world import World


def _odd_powers(world: World) -> np.ndarray:
    """A cubic that a fifth power bends back."""
    x = shares_of_rate(world)
    return np.asarray(x**3 - 1.3 * x**5)


def _tanh(world: World) -> np.ndarray:
    return np.asarray(np.tanh(shares_of_rate(world) / 0.3))


def _piecewise(world: World) -> np.ndarray:
    """Another gain beyond 0.45 of the largest rate."""
    x = shares_of_rate(world)
    return np.asarray(np.sign(x) * np.maximum(np.abs(x) - 0.45, 0.0))


def _soft_dead_band(world: World) -> np.ndarray:
    x, d = shares_of_rate(world), 0.15
    return np.asarray(x * d**2 / (x**2 + d**2))


def _one_sided(world: World) -> np.ndarray:
    """A gain that grows with the rate, on the positive side alone."""
    return np.asarray(np.maximum(shares_of_rate(world), 0.0) ** 1.6)


def _ripple(world: World) -> np.ndarray:
    """Up and down over the rate, as a converter's steps of gain are."""
    return np.asarray(np.sin(2.0 * np.pi * shares_of_rate(world) / 0.55))


def _spring(world: World) -> np.ndarray:
    """A spring that gets stiff on one side only."""
    return np.asarray(np.log1p(np.exp(4.0 * shares_of_force(world))))


LAWS = (
    Law("odd_powers", "non-linearity", GYROS, _odd_powers),
    Law("tanh", "non-linearity", GYROS, _tanh),
    Law("piecewise_gain", "non-linearity", GYROS, _piecewise),
    Law("soft_dead_band", "non-linearity", GYROS, _soft_dead_band),
    Law("one_sided_gain", "non-linearity", GYROS, _one_sided),
    Law("ripple_over_rate", "non-linearity", GYROS, _ripple),
    Law("one_sided_spring", "non-linearity", ACCELEROMETERS, _spring),
)
