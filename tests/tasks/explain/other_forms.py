"""Physics as others write it: signals (n, 6) of no particular size for a short run.

Each has another equation than the catalogue's terms, and all of its axes a size of their own.
"""

from collections.abc import Callable

import numpy as np
from short_run import ShortRun

STILL = 1e-3  # rad/s


def on_gyros(signal: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    return np.hstack([signal * sizes, np.zeros_like(signal)])


def on_accelerometers(signal: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    return np.hstack([np.zeros_like(signal), signal * sizes * 10.0])


def signs(rng: np.random.Generator) -> np.ndarray:
    return rng.choice([-1.0, 1.0], 3) * rng.uniform(0.5, 1.5, 3)


def relays(drive: np.ndarray, up: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Mean state (n,) of Preisach's relays, which switch up above `up` and down below `down`."""
    state = -np.sign(up + down)
    found = np.zeros(len(drive))
    for n, x in enumerate(drive):
        state = np.where(x > up, 1.0, np.where(x < down, -1.0, state))
        found[n] = state.mean()
    return found


def backlash(drive: np.ndarray, radius: float) -> np.ndarray:
    """Play (n,) of a gear: it follows as soon as a flank touches."""
    found, at = np.zeros(len(drive)), float(drive[0])
    for n, x in enumerate(drive):
        at = min(max(at, x - radius), x + radius)
        found[n] = at
    return found


def each(signal: Callable[[np.ndarray], np.ndarray], of: np.ndarray) -> np.ndarray:
    return np.column_stack([signal(column) for column in of.T])


def preisach_of_rate(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    up, down = np.sort(rng.uniform(-3.0, 3.0, (50, 2)))[:, ::-1].T
    return on_gyros(each(lambda w: relays(w, up, down), run.rate), signs(rng))


def fading(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """The sign of the last turn, forgotten in time."""
    tau = rng.uniform(5.0, 60.0)

    def faded(w: np.ndarray) -> np.ndarray:
        state, found, keep = 0.0, np.zeros(len(w)), np.exp(-run.step / tau)
        for n, x in enumerate(w):
            state = np.sign(x) if abs(x) > STILL else state * keep
            found[n] = state
        return found

    return on_gyros(each(faded, run.rate), signs(rng))


def play_of_force(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    radius = rng.uniform(1.0, 8.0)
    return on_accelerometers(each(lambda f: backlash(f, radius), run.force), signs(rng))


def step_at(run: ShortRun, time: float, sizes: np.ndarray, lasts: float = 0.0) -> np.ndarray:
    after = (run.t >= time).astype(float)
    if lasts:
        after = np.clip((run.t - time) / lasts, 0.0, 1.0)
    return after[:, None] * np.asarray(sizes) * np.repeat([1.0, 10.0], 3)


def _time(run: ShortRun, rng: np.random.Generator) -> float:
    return float(rng.uniform(0.15, 0.85) * run.t[-1])


def knock(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """Everything jumps at once."""
    return step_at(run, _time(run, rng), rng.standard_normal(6))


def gradual_step(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """A relay that warms: two seconds from one level to the other."""
    return step_at(run, _time(run, rng), [0, 0, 0, *rng.standard_normal(3)], 2.0)


def _speed(run: ShortRun) -> np.ndarray:
    return np.linalg.norm(run.rate, axis=1)[:, None] / 3.5


def rectified(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """A bias with speed^1.5, and no vibration to be seen."""
    return on_accelerometers(_speed(run) ** 1.5 * np.ones(3), signs(rng))


def dead_band(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """Nothing is read of rates below a threshold, and above it that much less."""
    least = rng.uniform(0.01, 0.1)
    return on_gyros(-np.clip(run.rate, -least, least), rng.uniform(0.5, 1.5, 3))


def wave_of_a_converter(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """An error of the codes that goes round once in so much of the range."""
    wave = np.sin(2.0 * np.pi * run.force / rng.uniform(8.0, 12.0))
    return on_accelerometers(wave, signs(rng))


def _bent(run: ShortRun, turn: np.ndarray) -> np.ndarray:
    """What a small rotation (n, 3) of the unit makes of rate and force."""
    faster = np.gradient(turn, run.t, axis=0)
    return np.hstack([faster - np.cross(turn, run.rate), -np.cross(turn, run.force)])


def sag(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """A fixture that hangs down: turned in proportion to gravity's torque about its root."""
    root = rng.standard_normal(3)
    return _bent(run, np.cross(root, run.force) * rng.uniform(0.5, 1.5, 3))
