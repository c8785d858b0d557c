"""The chamber: air temperature and humidity, supply voltage and pressure."""

from dataclasses import dataclass

from schemas.station import CHAMBER_DEVICE, CHAMBER_REGISTERS
from tasks.station.modbus import Link

COLUMNS = ("temperature", "humidity", "supply_voltage", "pressure")


@dataclass(frozen=True)
class Climate:
    """One reading: station time in s, and the values of COLUMNS in °C, %RH, V and hPa."""

    t: float
    values: tuple[float, ...]


async def read_climate(link: Link) -> Climate:
    """Read the chamber once. Raises Unusable as Link does."""
    values = await link.read(CHAMBER_DEVICE, CHAMBER_REGISTERS)
    return Climate(values["station_time"] / 1e6, tuple(values[name] for name in COLUMNS))
