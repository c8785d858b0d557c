"""What follows the unit's surroundings: temperature, supply."""

from dataclasses import dataclass, field

import numpy as np

from schemas.recording import Recording
from tasks.model.parameters import DEG, Printed, each_channel, same, triads
from tasks.model.term import Column, Inputs, Parameter, Term
from tasks.motion.whole import Motion

REFERENCE = 25.0  # °C
TIME_CONSTANTS = tuple(np.geomspace(30.0, 400.0, 5).tolist())  # s


@dataclass(frozen=True)
class RecordedBias(Term):
    """A bias that follows something recorded, from its reference; None: from its mean."""

    signal: str = field(kw_only=True)
    reference: float | None = field(kw_only=True)

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        signal = motion.recorded[self.signal]
        reference = np.nanmean(signal) if self.reference is None else self.reference
        return same(signal - reference)


@dataclass(frozen=True)
class TemperatureScale(Term):
    """A scale factor that follows the unit's own temperature."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        warmer = (motion.recorded["temperature"] - REFERENCE)[:, None]
        return triads(inputs.rate * warmer, inputs.force * warmer)


@dataclass(frozen=True)
class ThermalTransient(Term):
    """A bias that fades since power-on; shapes: its time constant."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        return same(np.exp(-motion.t / self.at[0]))


def _per(unit: str, largest_gyro: float, largest_accel: float) -> tuple[Printed, Printed]:
    """How biases per a unit are printed; largest plausible in rad/s and m/s² per it."""
    return (f"(deg/s)/{unit}", DEG, largest_gyro), (f"(m/s2)/{unit}", 1.0, largest_accel)


TEMPERATURE_BIAS = RecordedBias(
    "temperature_bias", "environment", "sensor", "bᵢ = cᵢ·(T − 25 °C)",
    "IEEE Std 1293; IEEE Std 1431", each_channel("c", *_per("K", 0.01, 0.1)),
    signal="temperature", reference=REFERENCE,
    confused_with=("thermal_transient", "thermal_gradient", "bias_random_walk"),
    time_course="drift",
)  # fmt: skip
TEMPERATURE_SCALE = TemperatureScale(
    "temperature_scale", "environment", "sensor",
    "ω′ᵢ = cᵢ·ωᵢ·(T − 25 °C); a′ᵢ = cᵢ·fᵢ·(T − 25 °C)", "IEEE Std 1293; IEEE Std 1431",
    each_channel("c", ("1/K", 1.0, 2e-3), ("1/K", 1.0, 2e-3)),
    confused_with=("temperature_bias", "gyro_scale_nonlinearity", "clock_skew"),
)  # fmt: skip
THERMAL_GRADIENT = RecordedBias(
    "thermal_gradient", "environment", "sensor", "bᵢ = cᵢ·dT/dt", "IEEE Std 952",
    each_channel("c", *_per("(K/s)", 1.0, 10.0)), signal="temperature_rate", reference=0.0,
    rarity=2.0, time_course="drift",
    confused_with=("temperature_bias", "thermal_transient", "bias_random_walk"),
)  # fmt: skip
SUPPLY_SENSITIVITY = RecordedBias(
    "supply_sensitivity", "environment", "sensor", "bᵢ = cᵢ·(V − V̄)", "IEEE Std 1293; IEEE Std 952",
    each_channel("c", *_per("V", 0.1, 1.0)), signal="supply_voltage", reference=None,
    confused_with=("temperature_bias", "bias_random_walk"),
)  # fmt: skip


def thermal_transient(seconds: float) -> ThermalTransient:
    """A warm-up with a time constant."""
    return ThermalTransient(
        "thermal_transient", "environment", "sensor", "bᵢ = cᵢ·e^(−t/τ)", "IEEE Std 1293",
        each_channel("c", ("deg/s", DEG, 0.1), ("m/s2", 1.0, 1.0)),
        (Parameter("time_constant", "τ", "s", 1.0, (5.0, 600.0)),), (seconds,),
        confused_with=("temperature_bias", "thermal_gradient", "bias_random_walk"),
        time_course="drift",
    )  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Biases and scale factors that follow a recorded signal; a warm-up always."""
    by_course: tuple[tuple[str, tuple[Term, ...]], ...] = (
        ("temperature", (TEMPERATURE_BIAS, TEMPERATURE_SCALE)),
        ("temperature_rate", (THERMAL_GRADIENT,)),
        ("supply_voltage", (SUPPLY_SENSITIVITY,)),
    )
    recorded = (term for signal, terms in by_course if signal in motion.recorded for term in terms)
    return (*recorded, *(thermal_transient(seconds) for seconds in TIME_CONSTANTS))
