"""What the unit goes through, on the fine grid: the ground on which effects act."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tests.proof.plant.case import (
    Case,
    Plan,
    UnitErrors,
    draw_unit,
    generator,
    inverse,
    slope,
    turned,
)

# A chamber that is set in the course of a run: its air, and what of it reaches the unit.

STATED_K_S = 4.0 / 60.0  # in the station file
STEP = 0.1  # s


@dataclass(frozen=True)
class Heating:
    """Beyond the room's: air K, of the unit K, and its change K/s, each (n,)."""

    air: np.ndarray
    unit: np.ndarray
    unit_rate: np.ndarray


def set_points(case: Case) -> list[tuple[float, float]]:
    """When (s) a case's procedure sets the chamber, and to what (°C)."""
    if case.procedure != "given":
        return []
    from tests.proof.plant.procedures import plan_of  # late: a plan's segments know no weather

    plan = plan_of(case)
    return [
        (float(begins), segment.chamber)
        for segment, begins in zip(plan.segments, plan.bounds, strict=False)
        if segment.chamber is not None
    ]


def heating(
    case: Case, t: np.ndarray, settings: list[tuple[float, float]], room: float, warm_up: float
) -> Heating:
    """At times t (n,) s.

    settings: (s, °C). room: °C before the first. warm_up: s, time constant of the unit's
    warming by its own heat; it follows the air in about the same, and the chamber is not quite as
    fast as it is said to be.
    """
    if not settings:
        return Heating(*np.zeros((3, len(t))))
    rng = generator(case.seed, "chamber")
    fastest, lag = STATED_K_S * rng.uniform(0.85, 1.1), warm_up * rng.uniform(0.8, 1.25)
    times = np.arange(0.0, float(t[-1]) + 2.0 * STEP, STEP)
    air, unit = np.zeros(len(times)), np.zeros(len(times))
    goals = np.zeros(len(times))
    for at, degc in settings:
        goals[times >= at] = degc - room
    for k in range(1, len(times)):
        air[k] = air[k - 1] + np.clip(goals[k] - air[k - 1], -fastest * STEP, fastest * STEP)
        unit[k] = unit[k - 1] + (air[k - 1] - unit[k - 1]) * STEP / lag
    change = (air - unit) / lag
    return Heating(*(np.interp(t, times, each) for each in (air, unit, change)))


# The room and the unit's own temperature over the run, as smooth functions of time.

REFERENCE = 25.0  # °C, where temperature coefficients count from


@dataclass(frozen=True)
class Weather:
    """At each time: °C, K/s, °C, %RH, V, hPa; `temperature` is the unit's own."""

    temperature: np.ndarray
    temperature_rate: np.ndarray
    air: np.ndarray
    humidity: np.ndarray
    supply: np.ndarray
    pressure: np.ndarray


def weather(case: Case, t: np.ndarray) -> Weather:
    """What the room does at times t (n,) s; the same for every set of effects."""
    rng = generator(case.seed, "weather")
    cycling = case.climate == "cycling"
    swing = rng.uniform(2.5, 4.0) if cycling else rng.uniform(0.3, 0.9)
    period = rng.uniform(400.0, 700.0) if cycling else rng.uniform(2500.0, 5000.0)
    mean = rng.uniform(19.8, 20.6)
    lag = rng.uniform(60.0, 120.0)  # s, of the unit behind the air
    turned = 2.0 * np.pi * lag / period
    phase = rng.uniform(0.0, 2.0 * np.pi)
    air, _ = _wave(t, swing, period, phase)
    follows, slope = _wave(t, swing / np.hypot(1.0, turned), period, phase - np.arctan(turned))
    start, rise, tau = rng.uniform(2.0, 4.0), rng.uniform(7.0, 10.0), rng.uniform(330.0, 520.0)
    decay = np.exp(-np.maximum(t, 0.0) / tau)
    heated = heating(case, t, set_points(case), mean, tau)
    return Weather(
        temperature=mean + follows + start + rise * (1.0 - decay) + heated.unit,
        temperature_rate=slope + rise / tau * decay + heated.unit_rate,
        air=mean + air + heated.air,
        humidity=rng.uniform(40.0, 50.0) + _wander(rng, t, 5.0),
        supply=_supply(rng, t),
        pressure=rng.uniform(1005.0, 1022.0) + _wander(rng, t, 0.4),
    )


def _wave(t: np.ndarray, size: float, period: float, phase: float) -> tuple[np.ndarray, np.ndarray]:
    pulse = 2.0 * np.pi / period
    return size * np.sin(pulse * t + phase), size * pulse * np.cos(pulse * t + phase)


def _wander(rng: np.random.Generator, t: np.ndarray, size: float) -> np.ndarray:
    """Three slow waves of unrelated periods."""
    total = np.zeros(len(t))
    for share in (1.0, 0.5, 0.3):
        period, phase = rng.uniform(300.0, 2000.0), rng.uniform(0.0, 2.0 * np.pi)
        total += _wave(t, share * size, period, phase)[0]
    return total


def _supply(rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    """5 V that sags by some 20 mV while another load is on, and wanders a little."""
    on, off, start = rng.uniform(150.0, 280.0), rng.uniform(150.0, 280.0), rng.uniform(0.0, 100.0)
    edges = np.cumsum(np.resize([on, off], 400) * rng.uniform(0.8, 1.2, 400)) - start
    loaded = np.searchsorted(edges, t) % 2
    return 5.0 + 0.022 * loaded + _wander(rng, t, 0.004)


@dataclass(frozen=True)
class Setting:
    """What is known before the run: enough to draw an effect's parameters."""

    case: Case
    plan: Plan

    @property
    def top_rate(self) -> float:
        """The largest rate of the run in rad/s; 1 where nothing turns."""
        turned = [abs(rate) for segment in self.plan.segments for rate in segment.ramp or ()]
        return max(turned, default=0.0) or 1.0

    @cached_property
    def unit(self) -> UnitErrors:
        own = self.case.unit_seed
        return draw_unit(self.case.seed if own is None else own)


@dataclass(frozen=True)
class Motion:
    """The unit's true motion. All (…, n) on the grid `t` (n,) s of the true time.

    shaft: (axes, n) rad. attitude: quaternion (4, n), unit to n. rates: (3, n) rad/s against
    inertial space. force: (3, n) m/s², what each accelerometer feels along its axis.
    seams: times in s at which the unit was re-fixed, between two takes.
    """

    t: np.ndarray
    shaft: np.ndarray
    attitude: np.ndarray
    rates: np.ndarray
    force: np.ndarray
    seams: np.ndarray

    @property
    def step(self) -> float:
        return float(self.t[1] - self.t[0])

    def angular_acceleration(self) -> np.ndarray:
        """(3, n) rad/s², from the rates' differences."""
        return slope(self.rates, self.step)

    def into_unit(self, vector: np.ndarray) -> np.ndarray:
        """A vector (3,) of n, East-North-Up, along the unit's axes: (3, n)."""
        return turned(inverse(self.attitude), vector)


@dataclass(frozen=True)
class World:
    """Everything at once: the motion, the room, the unit and what was planned."""

    setting: Setting
    motion: Motion

    @property
    def unit(self) -> UnitErrors:
        return self.setting.unit

    @cached_property
    def weather(self) -> Weather:
        return weather(self.setting.case, self.t)

    @property
    def t(self) -> np.ndarray:
        return self.motion.t

    def sensed_rates(self) -> np.ndarray:
        """(3, n) rad/s: what each gyro's element answers to, its own scale included."""
        return np.asarray(self.unit.Kg @ self.motion.rates)

    def sensed_force(self) -> np.ndarray:
        """(3, n) m/s²: what each accelerometer's element answers to."""
        return np.asarray(self.unit.Ka @ self.motion.force)


def on_gyros(signal: np.ndarray) -> np.ndarray:
    """(3, n) or (3, 1) rad/s as six channels."""
    return np.concatenate([signal, np.zeros_like(signal)])


def on_accelerometers(signal: np.ndarray) -> np.ndarray:
    """(3, n) or (3, 1) m/s² as six channels."""
    return np.concatenate([np.zeros_like(signal), signal])
