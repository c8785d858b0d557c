"""Settings of a virtual station, its station file, and the truth that the file omits."""

import math
import struct
import tomllib
from datetime import date
from importlib.resources import files
from typing import Any, Literal

import numpy as np
from pydantic import Field

from schemas.base import Finite, Frozen
from schemas.laboratory import ChamberLimits, ErrorBound, LimitName, MeasurementStandard
from schemas.recording import ACCEL, ANGLE, GYRO, Mount, TableAxis, Vector
from schemas.station import StationFile
from schemas.text import CONTRACTED, text_fields
from tasks.station import stations
from tasks.words import Message, message, statement

# The protocol of the virtual station: register maps, and the layout of the unit's frames.
#
# `python -m deploy.station_protocol` prints it as deploy/station.md. A client knows it from a
# station file alone (tasks/station/stations/mimucal.toml), and never from here.

TABLE_DEVICE = 1
CHAMBER_DEVICE = 2
FIXTURE_DEVICE = 3

RegisterType = Literal["uint16", "uint32", "int32", "uint64", "float32"]
WORDS: dict[str, int] = {"uint16": 1, "uint32": 2, "int32": 2, "uint64": 4, "float32": 2}


class Register(Frozen):
    """One named value in holding registers, high word first."""

    name: str
    address: int = Field(ge=0)
    type: RegisterType
    unit: str
    writable: bool
    meaning: str

    @property
    def words(self) -> int:
        return WORDS[self.type]


def _register(
    name: str, address: int, kind: RegisterType, unit: str, meaning: str, writable: bool = False
) -> Register:
    return Register(
        name=name, address=address, type=kind, unit=unit, writable=writable, meaning=meaning
    )


TABLE_IDENT = 0x4D54
MAP_VERSION = 1
TABLE_REGISTERS = (
    _register("ident", 0, "uint16", "1", "0x4D54: a mimucal table"),
    _register("map_version", 1, "uint16", "1", "1"),
    _register("axes", 2, "uint16", "1", "number of axes, outer first"),
    _register("status", 3, "uint16", "1", "bits of TABLE_STATUS"),
    _register("station_time", 4, "uint64", "us", "time since the station was switched on"),
    _register("watchdog", 8, "uint16", "ms", "wall time without a poll of the client that set it "
              "after which the table stops; 0 switches it off", writable=True),
    _register("command", 9, "uint16", "1", "1 resets faults, 2 stops every axis, "
              "3 stops every axis as quickly as the table may", writable=True),
    _register("capture_period", 10, "uint32", "us", "time between two captured encoder samples"),
)  # fmt: skip

AXIS_BASE = 16
AXIS_STRIDE = 16
AXIS_REGISTERS = (
    _register("mode", 0, "uint16", "1", "0 off, 1 go to angle, 2 hold rate, 3 ramp to rest",
              writable=True),
    _register("status", 1, "uint16", "1", "bits of AXIS_STATUS"),
    _register("target_angle", 2, "float32", "deg", "where mode 1 goes", writable=True),
    _register("target_rate", 4, "float32", "deg/s", "the rate of mode 2, the speed of mode 1",
              writable=True),
    _register("acceleration_limit", 6, "float32", "deg/s2", "of every ramp", writable=True),
    _register("angle", 8, "int32", "counts", "encoder, runs on past whole turns"),
    _register("rate", 10, "float32", "deg/s", "rate of the axis"),
    _register("counts_per_turn", 12, "uint32", "1", "encoder counts in a turn"),
)  # fmt: skip

CAPTURE_VALUES = 57  # a block holds as many samples of every axis as these allow
CAPTURE_REGISTERS = (
    _register("capture_from", 100, "uint32", "1", "number of the first sample wanted; the block "
              "then starts there, or at the oldest sample kept", writable=True),
    _register("capture_count", 102, "uint16", "1", "samples in the block, as many as "
              "57 values hold: at most 57 of one axis, 19 of three"),
    _register("capture_first", 103, "uint32", "1", "number of the block's first sample; sample n "
              "was taken at station time n × capture_period"),
    _register("capture_samples", 105, "int32", "counts", "the encoders, axis after axis, sample "
              "after sample: 19 × 3 values"),
)  # fmt: skip

CHAMBER_REGISTERS = (
    _register("temperature", 0, "float32", "degC", "air in the chamber"),
    _register("humidity", 2, "float32", "%RH", "relative humidity"),
    _register("supply_voltage", 4, "float32", "V", "supply of the unit under test"),
    _register("pressure", 6, "float32", "hPa", "air pressure"),
    _register("station_time", 8, "uint64", "us", "when these were measured"),
    _register("target", 12, "float32", "degC", "where the air goes", writable=True),
)

FIXTURE_REGISTERS = (
    _register("qw", 0, "float32", "1", "attitude of the fixture on the payload, as quaternion",
              writable=True),
    _register("qx", 2, "float32", "1", "", writable=True),
    _register("qy", 4, "float32", "1", "", writable=True),
    _register("qz", 6, "float32", "1", "", writable=True),
    _register("turn", 8, "uint16", "1", "1 turns the fixture to that attitude", writable=True),
    _register("status", 9, "uint16", "1", "bits of FIXTURE_STATUS"),
    _register("supply", 10, "uint16", "1", "supply of the unit: 0 off, 1 on", writable=True),
    _register("supply_on_time", 11, "uint64", "us", "station time at which the supply was last "
              "switched on"),
)  # fmt: skip

AXIS_STATUS = {"ready": 1, "moving": 2, "settled": 4, "fault": 8, "emergency_stop": 16,
               "interlock": 32}  # fmt: skip
TABLE_STATUS = {"ready": 1, "fault": 8, "emergency_stop": 16, "interlock": 32, "watchdog": 64}
MODES = {"off": 0, "angle": 1, "rate": 2, "stop": 3}
COMMANDS = {"reset": 1, "stop": 2, "quick_stop": 3}
FIXTURE_STATUS = {"ready": 1, "turning": 2}

TRIADS = {"gyro": GYRO, "accel": ACCEL, "angle": ANGLE}


class Frame(Frozen):
    """What a unit sends for each sample, little-endian.

    Sync, counter, time stamp (us since the unit's power-on), counts of each triad (x, y, z),
    temperature in 0.01 degC, CRC-16/XMODEM (binascii.crc_hqx, start 0) over everything before it.
    """

    sync: int
    triads: tuple[tuple[Literal["gyro", "accel", "angle"], Literal["i", "q"]], ...]

    @property
    def format(self) -> str:
        """The format of the frame for the module struct."""
        return "<HIQ" + "".join(f"3{code}" for _, code in self.triads) + "hH"

    @property
    def size(self) -> int:
        """Bytes of a whole frame."""
        return struct.calcsize(self.format)


FRAMES = {
    "rates": Frame(sync=0x55AA, triads=(("gyro", "i"), ("accel", "i"))),
    "angles": Frame(sync=0x55AB, triads=(("angle", "q"), ("accel", "i"))),
}

# Lines of text on a unit's connection, each ended by CR LF; answers come among the frames.
SERIAL_REQUEST, SERIAL_ANSWER = "$SERIAL?", "$SERIAL,"
MOUNT_REQUEST, MOUNT_ANSWER, REFUSAL = "$MOUNT,", "$MOUNTED,", "$REFUSED,"


# The true errors of a unit under test: drawn from a seed and hidden from its calibration.

Matrix = tuple[Vector, Vector, Vector]
DEGREE = float(np.pi / 180.0)
G = 9.80665  # m/s², the standard value: a unit for drawing sizes, not the gravity at the station


class TriadTruth(Frozen):
    """Three like sensors. In units of the triad's quantity: rad/s or m/s²."""

    scale: Matrix
    bias: Vector
    bias_per_kelvin: Vector
    bandwidth_hz: Finite = Field(gt=0)
    white: Finite = Field(ge=0, description="random walk: density, per √Hz")
    flicker: Finite = Field(ge=0, description="standard deviation of each relaxation")
    full_scale: Finite = Field(gt=0)
    lsb: Finite = Field(gt=0)


class UnitTruth(Frozen):
    """A strapdown unit. Matrix rows are the sensors that read, columns the body axes.

    gyro, accel: the two triads. g_sensitivity: (rad/s) per (m/s²). places_m: where each
    accelerometer sits, from the intersection of the table's axes, in the body frame. The
    biases hold at `settled_degc`; the unit warms up toward the air plus `self_heating_k`.
    angle_lsb: rad in a count, of a unit that accumulates angles (an AHRS). label: its serial number
    where that is not made of the seed.
    """

    seed: int
    label: str | None = None
    gyro: TriadTruth
    accel: TriadTruth
    g_sensitivity: Matrix
    places_m: Matrix
    angle_lsb: Finite | None = Field(default=None, gt=0)
    rate_hz: Finite = Field(default=100.0, gt=0, le=1000)
    clock_offset_s: Finite = Field(default=0.0, ge=0, description="station time at power-on")
    clock_skew: Finite = Field(default=0.0, description="the unit's clock runs 1 + skew")
    self_heating_k: Finite = 8.0
    heating_time_s: Finite = Field(default=120.0, gt=0)
    settled_degc: Finite = 28.0

    @property
    def frame(self) -> Literal["rates", "angles"]:
        """The frame that it sends, of tasks.station.virtual.config.FRAMES."""
        return "rates" if self.angle_lsb is None else "angles"

    @property
    def serial(self) -> str:
        """Its serial number, which it tells whoever asks."""
        return self.label or f"{'V' if self.angle_lsb is None else 'A'}{self.seed:05d}"

    @property
    def rate_sensitivity_m(self) -> np.ndarray:
        """The P of model (2) of JJF 2003 that the places imply: (3, 3), m.

        A turn ω about body axis j gives the point r the acceleration −ω²·(r − (r·e_j)·e_j);
        accelerometer i takes it through its row of the scale matrix.
        """
        parts = np.array(self.accel.scale) * np.array(self.places_m)
        return parts - parts.sum(axis=1, keepdims=True)


def draw_ahrs(seed: int) -> UnitTruth:
    """A unit that accumulates angles, with better gyros; the same for the same seed."""
    unit = draw_unit(seed)
    rng = np.random.default_rng(np.random.SeedSequence((seed, 2)))
    errors = rng.normal(0.0, 1.0, (3, 3)) * np.where(np.eye(3, dtype=bool), 3e-4, 8e-4)
    better = {
        "scale": (np.eye(3) + errors).tolist(),
        "bias": rng.normal(0.0, 2e-3 * DEGREE, 3).tolist(),
        "bias_per_kelvin": rng.normal(0.0, 2e-5 * DEGREE, 3).tolist(),
        "white": 1e-5,
        "flicker": 5e-7,
    }
    level = {"bias": rng.normal(0.0, 3e-3 * G, 3).tolist()}
    values = unit.model_dump() | {
        "gyro": unit.gyro.model_dump() | better,
        "accel": unit.accel.model_dump() | level,
        "g_sensitivity": np.zeros((3, 3)).tolist(),
        "angle_lsb": 1e-5 * DEGREE,
        "rate_hz": 10.0,
    }
    return UnitTruth.model_validate(values)


def draw_unit(seed: int) -> UnitTruth:
    """An industrial MEMS unit, the same for the same seed."""
    rng = np.random.default_rng(seed)

    def vector(size: float) -> Any:
        return rng.normal(0.0, size, 3).tolist()

    def square(diagonal: float, rest: float) -> np.ndarray:
        drawn = rng.normal(0.0, 1.0, (3, 3))
        return drawn * np.where(np.eye(3, dtype=bool), diagonal, rest)

    gyro = TriadTruth(
        scale=(np.eye(3) + square(3e-3, 2e-3)).tolist(),
        bias=vector(0.2 * DEGREE),
        bias_per_kelvin=vector(5e-4 * DEGREE),
        bandwidth_hz=40.0,
        white=5e-5,
        flicker=5e-6,
        full_scale=500.0 * DEGREE,
        lsb=500.0 * DEGREE / 2**19,
    )
    accel = TriadTruth(
        scale=(np.eye(3) + square(3e-3, 2e-3)).tolist(),
        bias=vector(0.03 * G),
        bias_per_kelvin=vector(5e-5 * G),
        bandwidth_hz=50.0,
        white=100e-6 * G,
        flicker=1e-5 * G,
        full_scale=10.0 * G,
        lsb=10.0 * G / 2**19,
    )
    sensitivity = square(1e-3, 1e-3) * DEGREE / G
    places = rng.uniform(-1e-3, 1e-3, (3, 3))
    return UnitTruth(
        seed=seed,
        gyro=gyro,
        accel=accel,
        g_sensitivity=sensitivity.tolist(),
        places_m=places.tolist(),
    )


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
    axes, degrees = len(design.axes), 360.0 / design.counts_per_turn
    table["expect"] |= {"axes": axes, "counts_per_turn": design.counts_per_turn}
    table["expect"]["capture_period"] = design.capture_ms * 1000
    table["capture"]["period_us"] = design.capture_ms * 1000
    for name in ("angle", "capture_samples"):
        table["registers"][name]["scale"] = degrees
    table["turnover_deg"] = 2**32 * degrees


def _frame(unit: UnitTruth) -> dict[str, Any]:
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
