"""Influences of the surroundings: temperature and supply."""

import numpy as np

from schemas.recording import Recording
from tasks.model.term import Parameter, Printed, SensorTerm, Term, each_channel, same, triads
from tasks.motion.samples import bridged, first_order_lag
from tasks.motion.whole import Motion

REFERENCE = 25.0  # °C
# Where the zero of an analogue output moves with the supply, or the converter's reference does: 0.4
# to 0.5 V/V, over 9.1 mV/(deg/s) up to 1 rad/s per V (scale factor: data sheet of the InvenSense
# IDG-500; its zero at 1.35 V of a supply of 3.3 V: as users report it, not the data sheet), over
# 300 mV/g up to 16 m/s² per V (Analog Devices ADXL335: zero at half the supply).
RATIOMETRIC = (1.0, 10.0)  # rad/s and m/s² per V
LATE = 60.0  # s: a sensor behind its thermometer
TIME_CONSTANTS = tuple(np.geomspace(30.0, 400.0, 5).tolist())  # s


def _per(unit: str, largest_gyro: float, largest_accel: float) -> tuple[Printed, Printed]:
    """How biases per a unit are printed; largest plausible in rad/s and m/s² per it."""
    gyro, accel = f"(rad/s)/{unit}", f"(m/s2)/{unit}"
    return (f"(deg/s)/{unit}", gyro, largest_gyro), (accel, accel, largest_accel)


TEMPERATURE_BIAS = SensorTerm(
    "temperature_bias", "environment", "sensor", "bᵢ = cᵢ·(T − 25 °C)",
    "IEEE Std 1293; IEEE Std 1431", each_channel("c", *_per("K", 0.01, 0.1)),
    reads=lambda motion, inputs, at: same(motion.recorded["temperature"] - REFERENCE),
    confused_with=("thermal_transient", "thermal_gradient", "bias_random_walk"),
    time_course="drift",
)  # fmt: skip


def late_temperature_bias(seconds: float) -> SensorTerm:
    """A bias that follows the temperature through a lag: the sensor warms after its thermometer."""
    return SensorTerm(
        "temperature_bias", "environment", "sensor",
        "bᵢ = cᵢ·(T′ − 25 °C), τ·dT′/dt = T − T′", "IEEE Std 1293; IEEE Std 952 (thermal lag)",
        each_channel("c", *_per("K", 0.01, 0.1)),
        (Parameter("time_constant", "τ", "s", "s", (5.0, 600.0)),), (seconds,),
        reads=lambda motion, inputs, at: same(
            _late(motion.recorded["temperature"], motion.interval, at[0]) - REFERENCE
        ),
        rarity=4.0, time_course="drift",
        confused_with=("thermal_transient", "thermal_gradient", "bias_random_walk"),
    )  # fmt: skip


def _late(signal: np.ndarray, step: float, seconds: float) -> np.ndarray:
    """Signal (n,) through a lag of first order that was in balance before it began."""
    known = bridged(signal[:, None])[:, 0]
    return first_order_lag(known, step, seconds, start=known[0])


# A scale factor that follows the unit's own temperature.
TEMPERATURE_SCALE = SensorTerm(
    "temperature_scale", "environment", "sensor",
    "ω′ᵢ = cᵢ·ωᵢ·(T − 25 °C); a′ᵢ = cᵢ·fᵢ·(T − 25 °C)", "IEEE Std 1293; IEEE Std 1431",
    each_channel("c", ("1/K", "1/K", 2e-3), ("1/K", "1/K", 2e-3)),
    reads=lambda motion, inputs, at: triads(
        inputs.rate * (motion.recorded["temperature"] - REFERENCE)[:, None],
        inputs.force * (motion.recorded["temperature"] - REFERENCE)[:, None],
    ),
    confused_with=("temperature_bias", "gyro_scale_nonlinearity", "clock_skew"),
)  # fmt: skip
THERMAL_GRADIENT = SensorTerm(
    "thermal_gradient", "environment", "sensor", "bᵢ = cᵢ·dT/dt", "IEEE Std 952",
    each_channel("c", *_per("(K/s)", 1.0, 10.0)),
    reads=lambda motion, inputs, at: same(motion.recorded["temperature_rate"]),
    rarity=2.0, time_course="drift",
    confused_with=("temperature_bias", "thermal_transient", "bias_random_walk"),
)  # fmt: skip
SUPPLY_SENSITIVITY = SensorTerm(
    "supply_sensitivity", "environment", "sensor", "bᵢ = cᵢ·(V − V̄)", "IEEE Std 1293; IEEE Std 952",
    each_channel("c", *_per("V", *RATIOMETRIC)),
    reads=lambda motion, inputs, at: same(
        motion.recorded["supply_voltage"] - np.nanmean(motion.recorded["supply_voltage"])
    ),
    confused_with=("temperature_bias", "bias_random_walk"),
)  # fmt: skip


def thermal_transient(seconds: float) -> SensorTerm:
    """A bias that fades since power-on, with a time constant."""
    return SensorTerm(
        "thermal_transient", "environment", "sensor", "bᵢ = cᵢ·e^(−t/τ)", "IEEE Std 1293",
        each_channel("c", ("deg/s", "rad/s", 0.1), ("m/s2", "m/s2", 1.0)),
        (Parameter("time_constant", "τ", "s", "s", (5.0, 600.0)),), (seconds,),
        reads=lambda motion, inputs, at: same(np.exp(-motion.t / at[0])),
        confused_with=("temperature_bias", "thermal_gradient", "bias_random_walk"),
        time_course="drift", since_power_on=True,
    )  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Biases and scale factors that follow a recorded signal; a warm-up always."""
    by_course: tuple[tuple[str, tuple[Term, ...]], ...] = (
        ("temperature", (TEMPERATURE_BIAS, late_temperature_bias(LATE), TEMPERATURE_SCALE)),
        ("temperature_rate", (THERMAL_GRADIENT,)),
        ("supply_voltage", (SUPPLY_SENSITIVITY,)),
    )
    recorded = (term for signal, terms in by_course if signal in motion.recorded for term in terms)
    return (*recorded, *(thermal_transient(seconds) for seconds in TIME_CONSTANTS))
