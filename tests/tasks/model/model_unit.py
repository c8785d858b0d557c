"""A tumbling and turning unit by plain algebra, for the tests of the model."""

import numpy as np

from tasks.motion.whole import Motion

GRAVITY = 9.8


def tumbling(count: int = 400, seed: int = 0, seconds: float = 400.0) -> Motion:
    """Stretches of rest and of turning at many attitudes and rates, angular acceleration too."""
    rng = np.random.default_rng(seed)
    hold = max(1, count // 40)
    pieces = -(-count // hold)

    def held(scale: float) -> np.ndarray:
        return np.repeat(scale * rng.standard_normal((pieces, 3)), hold, axis=0)[:count]

    up, north = held(1.0), held(1.0)
    up /= np.linalg.norm(up, axis=1)[:, None]
    north -= (north * up).sum(axis=1)[:, None] * up
    north /= np.linalg.norm(north, axis=1)[:, None]
    rate = held(2.0) * (np.arange(count) // hold % 2)[:, None]
    return Motion(np.linspace(0.0, seconds, count), up, north, rate, held(3.0), GRAVITY)


def flicker(count: int, interval: float, h: float, rng: np.random.Generator) -> np.ndarray:
    """Noise of spectrum S(f) = h/f (one-sided), (count,), by shaping white noise."""
    size = 16 * count
    f = np.fft.rfftfreq(size, interval)
    shape = np.zeros(len(f))
    shape[1:] = np.sqrt(h / f[1:] / (2.0 * interval))
    return np.fft.irfft(np.fft.rfft(rng.standard_normal(size)) * shape, size)[:count]
