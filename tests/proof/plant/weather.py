"""The room and the unit's own temperature over the run, as smooth functions of time."""

from dataclasses import dataclass

import numpy as np

from tests.proof.plant.case import Case
from tests.proof.plant.chamber import heating, set_points
from tests.proof.plant.seeds import generator

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
