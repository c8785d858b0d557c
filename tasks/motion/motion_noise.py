"""How smoothing and differentiation transform the white noise of samples."""

import numpy as np

from tasks.motion.band import response

POINTS = 512


def derivative_gain(order: int, edge: float, interval: float, width: float = 0.0) -> float:
    """Variance of a derivative, per s^order, of white noise of variance one in each sample.

    edge: Hz, where the smoothing's band ends. interval: s between samples. width: s that it is
    averaged over.
    """
    frequency = (np.arange(POINTS) + 0.5) / (2.0 * POINTS * interval)
    size = (2.0 * np.pi * frequency) ** order * response(frequency, edge)
    return float(((size * np.sinc(frequency * width)) ** 2).mean())


def taken_away(edge: float, interval: float) -> float:
    """Share of the variance of white noise that the smoothing takes away."""
    frequency = (np.arange(POINTS) + 0.5) / (2.0 * POINTS * interval)
    return float(((1.0 - response(frequency, edge)) ** 2).mean())
