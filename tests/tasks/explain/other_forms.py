"""Physics as others write it: signals (n, 6) of no particular size for a short run.

Each has another equation than the catalogue's terms, and all of its axes a size of their own.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.signal import lfilter
from short_run import ShortRun

Form = Callable[[ShortRun, np.random.Generator], np.ndarray]
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


def last_sign(rate: np.ndarray) -> np.ndarray:
    """(n,) sign of the last motion about an axis; 0 before any."""
    sign, found = 0.0, np.zeros(len(rate))
    for n, w in enumerate(rate):
        sign = np.sign(w) if abs(w) > STILL else sign
        found[n] = sign
    return found


def each(signal: Callable[[np.ndarray], np.ndarray], of: np.ndarray) -> np.ndarray:
    return np.column_stack([signal(column) for column in of.T])


def preisach_of_rate(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    up, down = np.sort(rng.uniform(-3.0, 3.0, (50, 2)))[:, ::-1].T
    return on_gyros(each(lambda w: relays(w, up, down), run.rate), signs(rng))


def play_of_rate(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    radius = rng.uniform(0.3, 2.0)
    return on_gyros(each(lambda w: backlash(w, radius), run.rate), signs(rng))


def plays_of_rate(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    radii, weights = rng.uniform(0.05, 3.0, 8), rng.uniform(0.0, 1.0, 8)
    parts = [each(partial(backlash, radius=radius), run.rate) for radius in radii]
    return on_gyros(np.tensordot(weights, parts, axes=1), signs(rng))


def backlash_of_angle(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """A spring that is wound up by 2r of turning: angle less its play."""
    angle, radius = np.cumsum(run.rate, axis=0) * run.step, rng.uniform(0.02, 1.0)
    return on_gyros(angle - each(lambda x: backlash(x, radius), angle), signs(rng))


def last_turn(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    return on_gyros(each(last_sign, run.rate), signs(rng))


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


def lagging_sign(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """The sign of the turning through a lag of first order: builds up and fades in time."""
    keep = np.exp(-run.step / rng.uniform(3.0, 30.0))
    signal = np.where(np.abs(run.rate) > STILL, np.sign(run.rate), 0.0)
    return on_gyros(lfilter([1 - keep], [1, -keep], signal, axis=0), signs(rng))


def last_peak(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """The fastest rate of the last turn, kept until the next is over."""

    def kept(w: np.ndarray) -> np.ndarray:
        found, state, peak = np.zeros(len(w)), 0.0, 0.0
        for n, x in enumerate(w):
            if abs(x) > STILL:
                peak = x if abs(x) > abs(peak) else peak
            elif peak:
                state, peak = peak, 0.0
            found[n] = state
        return found

    return on_gyros(each(kept, run.rate), signs(rng))


def bouc_wen(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """dz = A·dω − (β·|dω|·z + γ·dω·|z|), the smooth loop of structural mechanics."""
    beta, gamma = rng.uniform(0.5, 2.0), rng.uniform(-0.3, 0.3)

    def loop(w: np.ndarray) -> np.ndarray:
        z, found, before = 0.0, np.zeros(len(w)), w[0]
        for n, x in enumerate(w):
            d, before = x - before, x
            z += d - (beta * abs(d) * z + gamma * d * abs(z))
            found[n] = z
        return found

    return on_gyros(each(loop, run.rate), signs(rng))


def preisach_of_force(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    up, down = np.sort(rng.uniform(-9.0, 9.0, (50, 2)))[:, ::-1].T
    return on_accelerometers(each(lambda f: relays(f, up, down), run.force), signs(rng))


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


def gyro_step(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    return step_at(run, _time(run, rng), [*rng.standard_normal(3), 0, 0, 0])


def one_gyro_step(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    return step_at(run, _time(run, rng), np.eye(6)[rng.integers(3)])


def one_accel_step(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    return step_at(run, _time(run, rng), np.eye(6)[3 + rng.integers(3)])


def knock(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """Everything jumps at once."""
    return step_at(run, _time(run, rng), rng.standard_normal(6))


def step_within_a_ramp(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    turning = np.linalg.norm(run.rate, axis=1)
    ramps = np.flatnonzero(np.abs(np.gradient(turning, run.step)) > 0.5)
    inner = ramps[(ramps > 0.15 * len(run.t)) & (ramps < 0.85 * len(run.t))]
    return step_at(run, run.t[rng.choice(inner)], [*rng.standard_normal(3), 0, 0, 0])


def gradual_step(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """A relay that warms: two seconds from one level to the other."""
    return step_at(run, _time(run, rng), [0, 0, 0, *rng.standard_normal(3)], 2.0)


def early_step(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    return step_at(run, 0.06 * run.t[-1], [*rng.standard_normal(3), 0, 0, 0])


def _speed(run: ShortRun) -> np.ndarray:
    return np.linalg.norm(run.rate, axis=1)[:, None] / 3.5


def rectified(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """A bias with speed^1.5, and no vibration to be seen."""
    return on_accelerometers(_speed(run) ** 1.5 * np.ones(3), signs(rng))


def rectified_speed(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    return on_accelerometers(_speed(run) * np.ones(3), signs(rng))


def rectified_square(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    return on_accelerometers(_speed(run) ** 2 * np.ones(3), signs(rng))


def rectified_resonance(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """The fixture resonates near one speed."""
    at = rng.choice([20.0, 80.0, 200.0]) / 200.0
    return on_accelerometers(np.exp(-(((_speed(run) - at) / 0.15) ** 2)) * np.ones(3), signs(rng))


def bent_as_a_sine(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    return on_gyros(np.sin(run.rate / rng.uniform(0.6, 1.5)), signs(rng))


def compressed(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    return on_gyros(np.tanh(run.rate / rng.uniform(1.0, 3.0)), signs(rng))


def dead_band(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """Nothing is read of rates below a threshold, and above it that much less."""
    least = rng.uniform(0.01, 0.1)
    return on_gyros(-np.clip(run.rate, -least, least), rng.uniform(0.5, 1.5, 3))


def root_of_rate(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    return on_gyros(np.sign(run.rate) * np.sqrt(np.abs(run.rate)), signs(rng))


def bent_force(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    return on_accelerometers(np.tanh(run.force / 8.0), signs(rng))


def size_of_force(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """Another scale factor for forces up and down."""
    return on_accelerometers(np.abs(run.force), signs(rng))


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


def late_bend(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """Bends with the square of the rate, and creeps there within seconds."""
    keep = np.exp(-run.step / rng.uniform(1.0, 4.0))
    matrix = rng.standard_normal((3, 3)) * (1.0 - np.eye(3))
    return _bent(run, lfilter([1 - keep], [1, -keep], run.rate**2, axis=0) @ matrix)


def late_warmth(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """The sensor is warm later than its thermometer."""
    warm = run.recording.imu.columns["temperature"] - 25.0
    keep = np.exp(-run.step / rng.uniform(40.0, 150.0))
    start = np.array([keep * warm[0]])
    late = lfilter([1 - keep], [1, -keep], warm, zi=start)[0]
    return late[:, None] * rng.standard_normal(6) * np.repeat([1.0, 10.0], 3)


def two_warm_ups(run: ShortRun, rng: np.random.Generator) -> np.ndarray:
    """The chip within seconds, the housing within minutes."""
    fast, slow = np.exp(-run.t / rng.uniform(10.0, 25.0)), np.exp(-run.t / rng.uniform(80.0, 200.0))
    sizes = rng.standard_normal((2, 6)) * np.repeat([1.0, 10.0], 3)
    return np.column_stack([fast, slow]) @ sizes


FORMS: dict[str, dict[str, Form]] = {
    "hysteresis": {f.__name__: f for f in (
        preisach_of_rate, play_of_rate, plays_of_rate, backlash_of_angle, last_turn, fading,
        lagging_sign, last_peak, bouc_wen, preisach_of_force, play_of_force,
    )},
    "bias_step": {f.__name__: f for f in (
        gyro_step, one_gyro_step, one_accel_step, knock, step_within_a_ramp, gradual_step,
        early_step,
    )},
    "vibration_rectification": {f.__name__: f for f in (
        rectified, rectified_speed, rectified_square, rectified_resonance,
    )},
    "gyro_scale_nonlinearity": {f.__name__: f for f in (
        bent_as_a_sine, compressed, root_of_rate, dead_band,
    )},
    "accel_nonlinearity": {f.__name__: f for f in (
        bent_force, size_of_force, wave_of_a_converter,
    )},
    "structural_compliance": {f.__name__: f for f in (sag, late_bend)},
    "temperature_bias": {f.__name__: f for f in (late_warmth,)},
    "thermal_transient": {f.__name__: f for f in (two_warm_ups,)},
}  # fmt: skip
