"""Values that a device can possibly read: what lies beyond was read wrongly."""

import math
from collections.abc import Iterable, Mapping

from schemas.base import Unusable
from schemas.recording import ACCEL, ANGLE, GYRO
from schemas.station import StationFile
from tasks.station.ports import Climate, TableState

# Wider than any chamber, room or supply of a laboratory.
CLIMATE = {
    "temperature": (-100.0, 200.0, "°C"),
    "humidity": (0.0, 100.0, "%RH"),
    "supply_voltage": (-1000.0, 1000.0, "V"),
    "pressure": (100.0, 1300.0, "hPa"),
}
TEMPERATURE = CLIMATE["temperature"]
NEARLY_NOTHING = 1e-12  # but not 0: what words in the wrong order make of a round number
ROUNDED = 5.0  # %RH: a sensor of moist or dry air reads a little beyond
MOST_ANGLE_DEG, MOST_RATE_DEG_S = 1e8, 1e4
RATE_RAD_S, FORCE_M_S2 = 200.0, 2000.0  # of a unit whose ranges are not stated
G = 9.80665
AT_REST_M_S2 = (0.5 * G, 2.0 * G)  # of gravity, by the worst unit
SAMPLING = 0.2  # of unit_link.rate_hz
READ_WRONGLY = "check address, type, orders and scale, or the query's answer"


def check_climate(climate: Climate, read: Iterable[str]) -> None:
    """Raises Unusable, naming every value that is none or is impossible, of those that are read."""
    faults = []
    for name in CLIMATE:
        low, high, unit = CLIMATE[name]
        slack = ROUNDED if name == "humidity" else 0.0
        if name in read:
            value = getattr(climate, name)
            faults += _fault(name, value, (low - slack, high + slack), unit)
            if 0.0 < abs(value) < NEARLY_NOTHING:
                faults.append(f"{name} is {value:.2g} {unit}, which no sensor tells from 0")
    _raise("chamber", faults, READ_WRONGLY)


def check_state(state: TableState, names: tuple[str, ...]) -> None:
    """Raises Unusable, naming every angle, rate or time that is none or is impossible."""
    faults = _fault("time", state.station_s, (-1e-6, 1e12), "s")
    for name, axis in zip(names, state.axes, strict=True):
        angles = (-MOST_ANGLE_DEG, MOST_ANGLE_DEG)
        faults += _fault(f"angle of axis {name}", axis.angle_deg, angles, "deg")
        rates = (-MOST_RATE_DEG_S, MOST_RATE_DEG_S)
        faults += _fault(f"rate of axis {name}", axis.rate_deg_s, rates, "deg/s")
    _raise("table", faults, READ_WRONGLY)


def check_unit(station: StationFile, rate_hz: float, means: Mapping[str, float]) -> None:
    """Raises Unusable, naming every mean that is none or is impossible of a unit on a table at
    rest, and a sampling rate that is not the stated one.

    means: by channel, SI.
    """
    unit, stated_hz = station.unit.model_extra or {}, station.unit_link.rate_hz
    rate = math.radians(unit.get("rate_range_deg_s") or math.degrees(RATE_RAD_S))
    force = G * (unit.get("accel_range_g") or FORCE_M_S2 / G)
    faults = []
    for name, mean in means.items():
        if name in GYRO:
            faults += _fault(name, mean, (-rate, rate), "rad/s")
        elif name in ACCEL:
            faults += _fault(name, mean, (-force, force), "m/s²")
        elif name == "temperature":
            faults += _fault(name, mean, TEMPERATURE[:2], TEMPERATURE[2])
        elif name in ANGLE:
            faults += _fault(name, mean, (-math.inf, math.inf), "rad")
    if not faults and set(ACCEL) <= means.keys():
        felt = math.hypot(*(means[name] for name in ACCEL))
        faults += _fault("gravity by the accelerometers", felt, AT_REST_M_S2, "m/s²")
    sampled = ((1.0 - SAMPLING) * stated_hz, (1.0 + SAMPLING) * stated_hz)
    faults += _fault("rate_hz", rate_hz, sampled, "Hz")
    _raise("unit", faults, "check fields, units and scale, and rate_hz of unit_link")


def _fault(name: str, value: float, possible: tuple[float, float], unit: str) -> list[str]:
    low, high = possible
    if not math.isfinite(value):
        return [f"{name} is no number ({value})"]
    if low <= value <= high:
        return []
    return [f"{name} is {value:.4g} {unit} where {low:.4g} to {high:.4g} {unit} is possible"]


def _raise(what: str, faults: list[str], way_out: str) -> None:
    if faults:
        raise Unusable(f"of the {what}, {'; '.join(faults)}: {way_out} in the station file")
