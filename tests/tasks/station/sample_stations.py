"""Station files and unit links for tests, made from the samples that ship."""

import tomllib
from importlib.resources import files
from typing import Any

from schemas.unit_link import UnitLink
from tasks.station import stations


def sample(name: str = "mimucal") -> dict[str, Any]:
    """A shipped station file as its fields."""
    return tomllib.loads((files(stations) / f"{name}.toml").read_text(encoding="utf-8"))


def rates_link(rate_hz: float = 100) -> UnitLink:
    """Frames of rates with counts of 1e-6 rad/s and 1e-5 m/s2."""
    return _link("gyro", "int32", 1e-6, "aa55", rate_hz)


def angles_link(rate_hz: float = 10) -> UnitLink:
    """Frames of angles with counts of 1e-7 rad and 1e-5 m/s2."""
    return _link("angle", "int64", 1e-7, "ab55", rate_hz)


def _link(triad: str, kind: str, scale: float, sync: str, rate_hz: float) -> UnitLink:
    fields = [{"name": f"{triad}_{axis}", "type": kind, "scale": scale} for axis in "xyz"]
    fields += [{"name": f"accel_{axis}", "type": "int32", "scale": 1e-5} for axis in "xyz"]
    head = [{"name": "counter", "type": "uint32"}, {"name": "time", "type": "uint64", "unit": "us"}]
    temperature = {"name": "temperature", "type": "int16", "scale": 0.01}
    frame = {"kind": "binary", "sync": sync, "check": "crc16_xmodem"}
    return UnitLink.model_validate(
        {
            "url": "socket://nowhere:1",
            "rate_hz": rate_hz,
            "frame": frame | {"fields": [*head, *fields, temperature]},
        }
    )
