"""What a law of an unlisted form is: a course of six readings, of which only the size is free."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.signal import fftconvolve

from schemas.recording import Recording
from tests.proof.plant.case import Case, generator
from tests.proof.plant.effects.sensors import signs
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.simulate import (
    drive,
    motions_of,
    sampled,
    simulated_from,
    visibility_beside,
    without_noise,
)
from tests.proof.plant.world import Setting, World

Behaviour = Literal["hysteresis", "non-linearity", "rectification", "late temperature"]
Course = Callable[[World], np.ndarray]
GYROS, ACCELEROMETERS, BOTH = (1.0, 0.0), (0.0, 10.0), (1.0, 10.0)  # rad/s and m/s² beside another
BEHAVIOURS: tuple[Behaviour, ...] = (
    "hysteresis", "non-linearity", "rectification", "late temperature",
)  # fmt: skip


@dataclass(frozen=True)
class Law:
    """One law: each channel reads a factor of its own times the course of its axis.

    course: (3, n) or (n,) of what the unit goes through. triads: relative sizes of gyros and
    accelerometers. vibration: (n,) m/s², root mean square of the shaking that the accelerometers
    also read, as far as it lies within their band.
    """

    name: str
    behaviour: Behaviour
    triads: tuple[float, float]
    course: Course
    vibration: Course | None = None

    def sense(self, world: World) -> np.ndarray:
        """(6, n) at unit size."""
        course = np.broadcast_to(self.course(world), (3, len(world.t)))
        rng = generator(world.setting.case.seed, self.name)
        return np.concatenate([size * signs(rng)[:, None] * course for size in self.triads])


def shares_of_rate(world: World) -> np.ndarray:
    """(3, n) rates about the unit's axes, in shares of the run's largest."""
    return world.motion.rates / world.setting.top_rate


def shares_of_force(world: World) -> np.ndarray:
    """(3, n) specific force along the unit's axes, in shares of its largest."""
    force = world.motion.force
    return np.asarray(force / np.abs(force).max())


def speed(world: World) -> np.ndarray:
    """(n,) of turning, in shares of the run's largest rate."""
    return np.asarray(np.linalg.norm(shares_of_rate(world), axis=0))


# Non-linearity: readings that bend over their own input, without memory.


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


CURVES = (
    Law("odd_powers", "non-linearity", GYROS, _odd_powers),
    Law("tanh", "non-linearity", GYROS, _tanh),
    Law("piecewise_gain", "non-linearity", GYROS, _piecewise),
    Law("soft_dead_band", "non-linearity", GYROS, _soft_dead_band),
    Law("one_sided_gain", "non-linearity", GYROS, _one_sided),
    Law("ripple_over_rate", "non-linearity", GYROS, _ripple),
    Law("one_sided_spring", "non-linearity", ACCELEROMETERS, _spring),
)


# Hysteresis: what a reading owes to a motion that is over, sample by sample.

FAST = 0.6  # of the largest rate
STILL = 1e-4  # of the largest rate: slower is no motion
EVERY = 5  # of the fine grid's points one is computed, where a law has to go through them all


def _step_by_step(inputs: np.ndarray, begins: float, step: Callable[..., float]) -> np.ndarray:
    """States (3, n) that each go through their inputs (3, n): step(state, input, change)."""
    found = np.empty_like(inputs)
    for axis, course in enumerate(inputs):
        coarse = course[::EVERY].tolist()
        state, before = begins, coarse[0]
        states = []
        for now in coarse:
            state = step(state, now, now - before)
            before = now
            states.append(state)
        found[axis] = np.repeat(states, EVERY)[: len(course)]
    return found


def _last_fast_spin(world: World) -> np.ndarray:
    """The sign of the last spin that was fast, whatever came after it."""
    return _step_by_step(
        shares_of_rate(world), 0.0,
        lambda state, rate, _: float(np.sign(rate)) if abs(rate) > FAST else state,
    )  # fmt: skip


def _angle(world: World) -> np.ndarray:
    return np.asarray(np.cumsum(world.motion.rates, axis=1) * world.motion.step)


def _dead_band(world: World) -> np.ndarray:
    """−1 or 1 at either side of a gap of 0.5 rad, 0 within it: a contact that a turn carries."""
    gap, flank = 0.25, 0.02

    def carried(state: float, _: float, change: float) -> float:
        return float(min(max(state + change, -gap - flank), gap + flank))

    place = _step_by_step(_angle(world), 0.0, carried)
    return np.where(np.abs(place) > gap, np.sign(place), 0.0)


def _relays_of_force(world: World) -> np.ndarray:
    """Nine relays of the own specific force, their thresholds not about its middle."""
    force, total = shares_of_force(world), np.zeros((3, len(world.t)))
    for k in range(9):
        up, down = 0.05 + 0.09 * k, -0.75 + 0.07 * k

        def relay(state: float, now: float, _: float, up: float = up, down: float = down) -> float:
            return 1.0 if now > up else -1.0 if now < down else state

        total += _step_by_step(force, -1.0, relay) / 9.0
    return total


def _bouc_wen(world: World) -> np.ndarray:
    """ż = u̇·(1 − |z|ⁿ·(β·sign(u̇·z) + γ)), u: angle turned in 0.4 rad."""
    n, beta, gamma = 1.6, 0.7, 0.3

    def step(state: float, _: float, change: float) -> float:
        u = change / 0.4
        held = abs(state) ** n * (beta * np.sign(u * state) + gamma)
        return float(np.clip(state + u * (1.0 - held), -1.0, 1.0))

    return _step_by_step(_angle(world), 0.0, step)


def _creeping_backlash(world: World) -> np.ndarray:
    """What is left of a spring with friction (0.15 of the largest rate) that creeps back: 90 s."""
    pace = EVERY * world.motion.step / 90.0

    def step(state: float, _: float, change: float) -> float:
        return float(np.clip(state * (1.0 - pace) + change, -0.15, 0.15))

    return _step_by_step(shares_of_rate(world), 0.0, step)


def _jiles_atherton(world: World) -> np.ndarray:
    """dM/dH = (M_an − M)/k in the way of H, M_an = coth(H/a) − a/H, H: own specific force."""
    a, k = 0.3, 0.35

    def step(state: float, now: float, change: float) -> float:
        x = now / a
        goal = x / 3.0 if abs(x) < 1e-3 else 1.0 / np.tanh(x) - 1.0 / x
        away = goal - state
        return float(state + (abs(change) / k * away if away * change > 0.0 else 0.0))

    return _step_by_step(shares_of_force(world), 0.0, step)


def _remanence(world: World) -> np.ndarray:
    """What the fastest of the last spin leaves of itself at rest: its root, with its sign."""

    def step(state: float, rate: float, change: float) -> float:
        if abs(rate) < STILL:
            return state
        new = float(np.sign(rate) * np.sqrt(abs(rate)))
        return new if new * state <= 0.0 or abs(new) > abs(state) else state

    return _step_by_step(shares_of_rate(world), 0.0, step)


MEMORY = (
    Law("last_fast_spin", "hysteresis", GYROS, _last_fast_spin),
    Law("dead_band", "hysteresis", GYROS, _dead_band),
    Law("relays_of_force", "hysteresis", ACCELEROMETERS, _relays_of_force),
    Law("bouc_wen", "hysteresis", GYROS, _bouc_wen),
    Law("creeping_backlash", "hysteresis", GYROS, _creeping_backlash),
    Law("jiles_atherton", "hysteresis", ACCELEROMETERS, _jiles_atherton),
    Law("remanence", "hysteresis", GYROS, _remanence),
)


# Late temperature: biases that the unit's temperature reaches after its thermometer.

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


THERMAL = (
    Law("late_and_bent", "late temperature", BOTH, _one_lag_bent),
    Law("two_lags", "late temperature", BOTH, _two_lags),
    Law("diffusion", "late temperature", BOTH, _diffusion),
    Law("late_gradient", "late temperature", BOTH, _late_gradient),
    Law("dead_time", "late temperature", BOTH, _dead_time),
    Law("self_heating", "late temperature", BOTH, _self_heating),
    Law("play_in_temperature", "late temperature", BOTH, _play_in_temperature),
)


# Rectification: accelerometers whose bias follows how much they are shaken.

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


VIBRATION = (
    Law("power_in_band", "rectification", ACCELEROMETERS, _power_in_band, _resonant),
    Law("size_of_shaking", "rectification", ACCELEROMETERS, _size_of_shaking, _resonant),
    Law("saturating", "rectification", ACCELEROMETERS, _saturating, _resonant),
    Law("of_other_axes", "rectification", ACCELEROMETERS, _of_other_axes, speed),
    Law("rough_bearing", "rectification", ACCELEROMETERS, _rough, _rough),
    Law("beyond_a_speed", "rectification", ACCELEROMETERS, _beyond_a_speed, speed),
)


# Recordings of a unit that follows one law of an unlisted form, at a given visibility.

LAWS: dict[str, Law] = {law.name: law for law in (*MEMORY, *CURVES, *VIBRATION, *THERMAL)}
IN_BAND = 0.01  # of the vibration: the rest lies above the unit's band


def case_of(law: Law, seed: int) -> Case:
    """The run that can show a law: every axis turns; the room's temperature goes to and fro."""
    rng = generator(seed, f"case {law.name}")
    thermal_law = law.behaviour == "late temperature"
    return Case(
        seed=seed,
        grade=str(rng.choice(["consumer", "industrial", "tactical"])),  # type: ignore[arg-type]
        procedure="three_axis",
        rate_hz=50,
        rates_deg_s=((20.0, 60.0, 150.0, 250.0), (10.0, 50.0, 100.0, 200.0, 300.0))[
            int(rng.integers(2))
        ],
        dwell_s=20.0 if thermal_law else 12.0,
        order=str(rng.choice(["rising", "alternating", "shuffled"])),  # type: ignore[arg-type]
        climate="cycling" if thermal_law else "room",
        latitude_deg=round(float(rng.uniform(-50.0, 60.0)), 2),
        heading_deg=round(float(rng.uniform(-180.0, 180.0)), 1),
        gravity_m_s2=round(float(rng.uniform(9.781, 9.825)), 4),
    )


def recordings(law: Law, case: Case, z: tuple[float, ...]) -> Iterator[Recording]:
    """The same run, unit and noise with the law at each visibility; z 0 is without it."""
    clean = without_noise(case)
    setting = Setting(case, clean.plan)
    motion, _ = motions_of(setting, (), *drive(case, plan_of(case)))
    world = World(setting, motion)
    part = sampled(law.sense(world), motion, (), clean.true_time, np.empty(0, int))
    unit = visibility_beside(case, part.T).z
    shaken = np.zeros_like(part)
    if law.vibration is not None:
        noise = generator(case.seed, f"shaking {law.name}").standard_normal((3, len(world.t)))
        shaking = np.concatenate([np.zeros_like(noise), IN_BAND * law.vibration(world) * noise])
        shaken = sampled(shaking, motion, (), clean.true_time, np.empty(0, int))
    for each in z:
        grown = each / unit * part
        made = replace(
            clean, analog=clean.analog + grown, truth=clean.truth + grown,
            shaken=shaken if each else np.zeros_like(part),
        )  # fmt: skip
        yield simulated_from(case, made).recording
