"""Kinds of behaviour as random functions of their own drive: forms that no publication lists.

A hysteresis is a sum of plays and relays of several widths, which remember rate, angle or specific
force; a non-linearity a function of the own input that bends at many places; a rectification one
of the vibration and of the speeds that make it; a late temperature, or the heat of turning, a
distribution of lags. Each weight is normal about zero, of one variance in a kind: a Gaussian
process of the drive, whose weights the evidence integrates out (Preisach's and Prandtl's operators
with random weights; C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine
Learning, 2006, 2.7).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from tasks.explain.channels import ACCELS, EVERY, GYROS
from tasks.explain.explanation import UNNAMED
from tasks.explain.search.empirical_terms import regression_term
from tasks.model.hysteresis_states import faded, last_peak, last_sign, stopped
from tasks.model.parameters import STILL, G, turned
from tasks.model.term import Inputs, SensorTerm
from tasks.motion.lag import first_order_lag
from tasks.motion.samples import bridged
from tasks.motion.whole import Motion
from tasks.words import message

SHARES = (0.02, 0.05, 0.1, 0.2, 0.4, 0.7)  # of the largest drive: radii of plays
# Of the largest rate: slower turns are not remembered.
FAST = (0.0, 0.05, 0.15, 0.25, 0.4, 0.55, 0.7, 0.85)
ANGLES = (0.03, 0.1, 0.3, 1.0, 3.0)  # rad
FORGOTTEN = (6.0, 20.0, 60.0)  # s
LEVELS = (-0.75, -0.3, 0.3, 0.75)  # of the largest specific force: thresholds of relays
BENDS = np.arange(-0.9, 0.95, 0.15)  # of the largest input
SPEEDS = (0.0, 0.1, 0.2, 0.35, 0.5, 0.7)  # of the largest rate: where a rectification bends
OWN_SPEEDS = (0.0, 0.3, 0.6)
LAGS = (8.0, 20.0, 45.0, 90.0, 180.0, 400.0, 900.0)  # s
HEAT_LAGS = (20.0, 45.0, 90.0, 180.0, 400.0)  # s
FAST_HEATS = 0.4  # of the largest rate
BENT_LAGS = (45.0, 180.0)  # s
GIVING_WAY = (0.3, 1.0, 2.5)  # K: radii of plays
# A table shakes more the faster it turns; the air is warmer before the unit is.
OF_SHAKING, OF_HEATING = ("ω_i²", "|ω_j|", "ω⁴"), ("lag(ω²)", "lag(|ω|)")
OF_TEMPERATURE = ("air_temperature",)
FEW = 0.5  # K: a smaller change of temperature shows no lag
Bank = Callable[[Motion, Inputs, int], list[np.ndarray]]


@dataclass(frozen=True)
class Behaviour:
    """A kind of behaviour in the channels of a triad, or of both.

    name: of the catalogue, for all of its forms. bank: the columns of a channel. empirical: what an
    empirical term follows that is a form of it, in these channels.
    """

    kind: str
    name: str
    family: str
    channels: tuple[int, ...]
    bank: Bank
    empirical: tuple[str, ...] = ()


def behaviours(motion: Motion) -> Iterator["UnlistedForm"]:
    """A term for each kind of behaviour that a recording can show."""
    inputs = Inputs.of(motion)
    for one in _possible(motion):
        yield _term(one, len(one.bank(motion, inputs, one.channels[0])))


def _possible(motion: Motion) -> Iterator[Behaviour]:
    if turned(motion):
        yield Behaviour("hysteresis", "hysteresis", "memory", GYROS, _memories_of_rate)
        yield Behaviour("hysteresis", "hysteresis", "memory", ACCELS, _memories_of_force)
        yield Behaviour("non-linearity", "gyro_scale_nonlinearity", "gyro", GYROS, _bent)
        yield Behaviour(
            "rectification", "vibration_rectification", "accelerometer", ACCELS, _shaken, OF_SHAKING
        )
        yield Behaviour("heating", UNNAMED, UNNAMED, EVERY, _heated, OF_HEATING)
    yield Behaviour("non-linearity", "accel_nonlinearity", "accelerometer", ACCELS, _bent)
    temperature = motion.recorded.get("temperature")
    if temperature is not None and np.nanmax(temperature) - np.nanmin(temperature) > FEW:
        yield Behaviour(
            "late temperature", "temperature_bias", "environment", EVERY, _late, OF_TEMPERATURE
        )


def _term(one: Behaviour, count: int) -> "UnlistedForm":
    title = message(f"explain-unlisted-{one.kind.replace(' ', '-')}")
    shared = one.channels == EVERY
    term = regression_term(one.kind, title, one.channels, count, one.bank, shared)
    return UnlistedForm(
        one.name, one.family, "sensor", "Σₖ wₖ·sₖ, wₖ normal", "random function of its own drive",
        term.parameters, own_title=title, reads=term.reads, form_of=one, per_channel=count,
    )  # fmt: skip


@dataclass(frozen=True)
class UnlistedForm(SensorTerm):
    """A kind of behaviour in a form that no publication lists. per_channel: number of columns."""

    form_of: Behaviour = field(kw_only=True)
    per_channel: int = field(kw_only=True)


def _share(values: np.ndarray) -> np.ndarray:
    """(n, …) of the largest; zero where it is not known."""
    known = np.nan_to_num(values)
    return np.asarray(known / max(float(np.abs(known).max(initial=0.0)), 1e-9))


def _memories_of_rate(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    rate = motion.rate[:, channel]
    top = float(np.abs(np.nan_to_num(motion.rate)).max())
    angle = np.cumsum(np.nan_to_num(rate)) * motion.interval
    return [
        *(stopped(rate, share * top) for share in SHARES),
        *(stopped(angle, radius) for radius in ANGLES),
        *(last_sign(rate, max(STILL, share * top)) for share in FAST),
        *(faded(rate, motion.t, seconds, STILL) for seconds in FORGOTTEN),
        last_peak(rate, STILL),
    ]


def _memories_of_force(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    force = inputs.force[:, channel % 3]
    change, still = np.gradient(force, motion.t), 1e-3 * G
    levels = [G * level for level in LEVELS]
    return [
        *(stopped(force, share * G) for share in SHARES[1:]),
        *(_relay(force, up, down) for up in levels for down in levels if up > down),
        last_sign(change, still),
        *(faded(change, motion.t, seconds, still) for seconds in FORGOTTEN),
    ]


def _relay(drive: np.ndarray, up: float, down: float) -> np.ndarray:
    """(n,) 1 since the drive last rose above `up`, −1 since it last fell below `down`; 0 before."""
    rows = np.arange(len(drive))
    raised = np.maximum.accumulate(np.where(drive > up, rows, -1))
    fell = np.maximum.accumulate(np.where(drive < down, rows, -1))
    return np.sign(raised - fell).astype(float)


def _bent(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    x = _share(inputs.rate if channel in GYROS else inputs.force)[:, channel % 3]
    return [np.abs(x - bend) for bend in BENDS]


def _shaken(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    shares = np.abs(_share(motion.rate))
    speed = _share(np.linalg.norm(shares, axis=1))
    power = _share(motion.recorded.get("vibration", np.zeros(len(speed))))
    return [
        *(np.maximum(speed - least, 0.0) for least in SPEEDS),
        *(np.maximum(shares[:, j] - least, 0.0) for j in range(3) for least in OWN_SPEEDS),
        power, np.sqrt(power), power / (power + 0.2),
    ]  # fmt: skip


def _heated(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    """Of what turning heats: of its power, and of that of fast turns alone."""
    speed = _share(np.linalg.norm(np.nan_to_num(motion.rate), axis=1))
    loads = speed**2, np.maximum(speed - FAST_HEATS, 0.0)
    return [first_order_lag(load, motion.interval, tau) for load in loads for tau in HEAT_LAGS]


def _late(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    """Deviations from the first temperature, K: what was in balance before."""
    known = bridged(motion.recorded["temperature"][:, None])[:, 0]
    above = known - known[0]
    late = partial(first_order_lag, above, motion.interval)
    return [
        *(late(seconds) for seconds in LAGS),
        *(late(seconds) ** 2 / 10.0 for seconds in BENT_LAGS),
        *(radius * stopped(late(LAGS[0]), radius) for radius in GIVING_WAY),
    ]
