"""Settings of a virtual station, its station file, and the truth that the file omits."""

import math
import tomllib
from datetime import date
from importlib.resources import files
from typing import Any

import numpy as np
from pydantic import Field

from schemas.base import Finite, Frozen
from schemas.equipment import ErrorBound, LimitName, MeasurementStandard
from schemas.limits import ChamberLimits
from schemas.recording import Mount, TableAxis
from schemas.station import StationFile
from schemas.text import CONTRACTED, text_fields
from tasks.station import stations
from tasks.station.virtual.protocol import FRAMES, SERIAL_ANSWER, SERIAL_REQUEST, TRIADS
from tasks.station.virtual.unit import G, UnitTruth, draw_ahrs, draw_unit
from tasks.words import Message, message, statement

STEP_S = 1e-3  # of the plant, station time
STEP_US = 1000
ARCSECOND = math.radians(1.0 / 3600.0)
# What the certificate of the virtual table says, as one of a real table would.
LIMITS: dict[LimitName, float] = {
    "rate": 2e-5,
    "ripple": 2e-4,
    "position": 2 * ARCSECOND,
    "repeatability": ARCSECOND,
}
LIMITS_BETWEEN_AXES: dict[LimitName, float] = {"axes": 3 * ARCSECOND}
EARTH_RATE_RAD_S = 7.292115e-5  # WGS 84

THREE_AXES = (
    TableAxis(name="outer", direction=(0.0, 0.0, 1.0)),
    TableAxis(name="middle", direction=(1.0, 0.0, 0.0)),
    TableAxis(name="inner", direction=(0.0, 0.0, 1.0)),
)


class TableDesign(Frozen):
    """The turntable: axes outer first, encoders, servo, and what it can do at most."""

    axes: tuple[TableAxis, ...] = Field(default=THREE_AXES, min_length=1, max_length=5)
    counts_per_turn: int = Field(default=3_600_000, gt=0)
    capture_ms: int = Field(default=10, gt=0, description="between two captured encoder samples")
    capture_kept: int = Field(default=8192, gt=0, description="captured samples: 82 s")
    servo_hz: Finite = Field(default=8.0, gt=0, lt=100)
    servo_damping: Finite = Field(default=0.7, gt=0)
    most_rate_deg_s: Finite = Field(default=1000.0, gt=0)
    most_acceleration_deg_s2: Finite = Field(default=2000.0, gt=0)
    quick_stop_deg_s2: Finite = Field(default=400.0, gt=0, description="a stop in distress")


class Air(Frozen):
    """What the chamber keeps until it is set to another temperature."""

    temperature_degc: Finite = 20.0
    humidity_percent: Finite = 45.0
    supply_v: Finite = 5.0
    pressure_hpa: Finite = 1005.0


class VirtualStation(Frozen):
    """Everything that is so at the station, whether the program knows it or not.

    id: null is one made of the port. neighbours: further units on the table, seated as `unit` is;
    faults are of `unit` alone.
    """

    id: str | None = "VIRTUAL-1"
    latitude_deg: Finite = Field(default=39.9, ge=-90, le=90)
    gravity_m_s2: Finite = Field(default=9.8015, gt=9.7, lt=9.9)
    heading_deg: Finite = 0.0
    table: TableDesign = TableDesign()
    chamber: ChamberLimits = ChamberLimits(temperature_degc=(0.0, 50.0), rate_k_min=4.0)
    air: Air = Air()
    mount: Mount = Mount()
    unit: UnitTruth = Field(default_factory=lambda: draw_unit(1))
    neighbours: tuple[UnitTruth, ...] = ()


def virtual_station(seed: int, ahrs: bool) -> VirtualStation:
    """Three axes with a MIMU, as JJF 2003-2022 has them, or one axis with an AHRS (JJF 1536-2015).

    seed: draws the unit.
    """
    if not ahrs:
        return VirtualStation(unit=draw_unit(seed))
    vertical = TableAxis(name="table", direction=(0.0, 0.0, 1.0))
    table = TableDesign(axes=(vertical,), capture_ms=100, capture_kept=2**16)
    return VirtualStation(id="VIRTUAL-2", table=table, unit=draw_ahrs(seed))


def station_file(
    config: VirtualStation, speed: float, host: str, modbus_port: int, *unit_ports: int
) -> StationFile:
    """What a client needs; `clock_speed` of its station part is station time over wall time.

    unit_ports: of the unit, then of its neighbours.
    """
    units = [
        _unit(truth, config.mount, f"socket://{host}:{port}")
        for truth, port in zip((config.unit, *config.neighbours), unit_ports, strict=True)
    ]
    name = config.id or f"VIRTUAL-{modbus_port}"
    devices = tomllib.loads((files(stations) / "mimucal.toml").read_text(encoding="utf-8"))
    devices = {name: devices[name] for name in ("table", "chamber", "fixture")}
    for device in devices.values():
        device["url"] = f"socket://{host}:{modbus_port}"
    _describe(config.table, devices["table"])
    return StationFile.model_validate(devices | {
        **units[0],
        "other_units": units[1:],
        "station": {
            "id": name,
            "latitude_deg": config.latitude_deg,
            "gravity_m_s2": config.gravity_m_s2,
            "heading_deg": config.heading_deg,
            "table_axes": config.table.axes,
            "clock_speed": speed,
        },
        "limits": {"chamber": config.chamber},
        "equipment": _equipment(name, len(config.table.axes)),
    })  # fmt: skip


def _unit(truth: UnitTruth, mount: Mount, url: str) -> dict[str, Any]:
    """A unit and its line, as a station file has them."""
    link = {"url": url, "rate_hz": truth.rate_hz, "frame": _frame(truth)}
    return {
        "unit_link": link | {"identify": {"request": SERIAL_REQUEST, "answer": SERIAL_ANSWER}},
        "mount": mount,
        "unit": {
            "manufacturer": "Virtual",
            "model": "V-MIMU" if truth.angle_lsb is None else "V-AHRS",
            "serial": truth.serial,
            "rate_range_deg_s": round(math.degrees(truth.gyro.full_scale), 6),
            "accel_range_g": round(truth.accel.full_scale / G, 6),
            "output_rate_hz": truth.rate_hz,
            "firmware": "virtual",
        },
    }


def _describe(design: TableDesign, table: dict[str, Any]) -> None:
    """What the description of a table says of this design."""
    axes, degrees = len(design.axes), 360.0 / design.counts_per_turn
    table["expect"] |= {"axes": axes, "counts_per_turn": design.counts_per_turn}
    table["expect"]["capture_period"] = design.capture_ms * 1000
    table["capture"]["period_us"] = design.capture_ms * 1000
    for name in ("angle", "capture_samples"):
        table["registers"][name]["scale"] = degrees
    table["turnover_deg"] = 2**32 * degrees


def _frame(unit: UnitTruth) -> dict[str, Any]:
    """The description of the frame that a unit sends."""
    frame = FRAMES[unit.frame]
    sizes = {"gyro": unit.gyro.lsb, "accel": unit.accel.lsb, "angle": unit.angle_lsb}
    types = {"i": "int32", "q": "int64"}
    triads = [
        {"name": column, "type": types[code], "scale": sizes[triad]}
        for triad, code in frame.triads
        for column in TRIADS[triad]
    ]
    return {
        "kind": "binary",
        "sync": frame.sync.to_bytes(2, "little").hex(),
        "check": "crc16_xmodem",
        "fields": [
            {"name": "counter", "type": "uint32"},
            {"name": "time", "type": "uint64", "unit": "us"},
            *triads,
            {"name": "temperature", "type": "int16", "scale": 0.01, "unit": "degC"},
        ],
    }


def _equipment(station: str, axes: int) -> tuple[MeasurementStandard, ...]:
    """The measurement standards, with made-up numbers that say so."""
    table = LIMITS if axes == 1 else LIMITS | LIMITS_BETWEEN_AXES
    rows: tuple[tuple[str, Message, str, dict[LimitName, float]], ...] = (
        ("T1", message("station-virtual-turntable", axes=axes), "", table),
        ("F1", message("station-virtual-fixture"), "", {"fixture": 3 * ARCSECOND}),
        ("C1", message("station-virtual-chamber"), "±0.5 °C, ±3 % RH", {}),
    )
    return tuple(
        MeasurementStandard(
            **text_fields("name", statement(name), CONTRACTED),
            serial=f"{station}-{serial}",
            accuracy=accuracy,
            certificate=f"VIRTUAL-{serial}",
            traceable=False,
            virtual=True,
            valid_until=date(2099, 12, 31),
            limits={
                limit: ErrorBound(half_width=half_width, distribution="rectangular")
                for limit, half_width in limits.items()
            },
        )
        for serial, name, accuracy, limits in rows
    )


def truth(config: VirtualStation) -> dict[str, Any]:
    """What a calibration of this unit should find, as JSON.

    SI units, model (1) and (2) of JJF 2003; of an AHRS also K, the ratios L and the zero offset
    of JJF 1536.
    """
    unit = config.unit
    scale = np.array(unit.gyro.scale)
    ahrs = {
        "K": np.diag(scale).tolist(),
        "L": (scale - np.diag(np.diag(scale))).tolist(),
        "B_deg_s": np.degrees(unit.gyro.bias).tolist(),
    }
    return ({} if unit.angle_lsb is None else ahrs) | {
        "Kg": unit.gyro.scale,
        "Bg": unit.gyro.bias,
        "G": unit.g_sensitivity,
        "Ka": unit.accel.scale,
        "Ba": unit.accel.bias,
        "P": unit.rate_sensitivity_m.tolist(),
        "places_m": unit.places_m,
        "unit": unit.model_dump(mode="json"),
        "station": config.model_dump(mode="json", exclude={"unit"}),
        "earth_rate_rad_s": EARTH_RATE_RAD_S,
    }
