"""A station as software meets it: where it listens, its register map, the unit's frames.

The register map and the frame layout are the documented protocol of the virtual station
(deploy/station.md prints them); a real controller gets its own map in the same shape.
"""

import struct
from datetime import date
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from schemas.base import Finite, Frozen
from schemas.limits import Limits
from schemas.recording import ACCEL, ANGLE, GYRO, Mount, Station, Unit

TABLE_DEVICE = 1
CHAMBER_DEVICE = 2
FIXTURE_DEVICE = 3

LimitShape = Literal["normal", "rectangular", "triangular", "arcsine"]
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
    _register("command", 9, "uint16", "1", "1 resets faults, 2 stops every axis", writable=True),
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
COMMANDS = {"reset": 1, "stop": 2}
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
        """For the module struct."""
        return "<HIQ" + "".join(f"3{code}" for _, code in self.triads) + "hH"

    @property
    def size(self) -> int:
        """Bytes of a whole frame."""
        return struct.calcsize(self.format)


FRAMES = {
    "rates": Frame(sync=0x55AA, triads=(("gyro", "i"), ("accel", "i"))),
    "angles": Frame(sync=0x55AB, triads=(("angle", "q"), ("accel", "i"))),
}


class _Line(Frozen):
    """A serial line: a URL that pyserial opens, and how many frames come in a second."""

    url: str
    baudrate: int = Field(default=460800, gt=0)
    rate_hz: Finite = Field(gt=0)


class UnitLink(_Line):
    """A unit that sends rates and accelerations: the size of its counts."""

    frame: Literal["rates"] = "rates"
    gyro_lsb_rad_s: Finite = Field(gt=0)
    accel_lsb_m_s2: Finite = Field(gt=0)

    @property
    def counts(self) -> dict[str, float]:
        """What one count of each column is, in SI units, in the order of the frame."""
        return dict.fromkeys(GYRO, self.gyro_lsb_rad_s) | dict.fromkeys(ACCEL, self.accel_lsb_m_s2)


class AngleLink(_Line):
    """A unit that sends the angles it has accumulated (an AHRS), and accelerations."""

    frame: Literal["angles"]
    angle_lsb_rad: Finite = Field(gt=0)
    accel_lsb_m_s2: Finite = Field(gt=0)

    @property
    def counts(self) -> dict[str, float]:
        """What one count of each column is, in SI units, in the order of the frame."""
        return dict.fromkeys(ANGLE, self.angle_lsb_rad) | dict.fromkeys(ACCEL, self.accel_lsb_m_s2)


def _frame_of(link: Any) -> Any:
    """The frame that a link names; rates where it names none."""
    return link.get("frame", "rates") if isinstance(link, dict) else getattr(link, "frame", None)


AnyLink = Annotated[
    Annotated[UnitLink, Tag("rates")] | Annotated[AngleLink, Tag("angles")],
    Discriminator(_frame_of),
]


class MeasurementStandard(Frozen):
    """A measurement standard, as clause 8 h) wants it on the certificate."""

    name: str
    name_zh: str
    serial: str
    accuracy: str
    certificate: str
    valid_until: date | None = None


class StationFile(Frozen):
    """A station to acquire from: addresses, the manifest's station part, unit and fixture.

    mount: how the unit sits in its fixture. fixture: who turns the fixture over, a person or the
    registers of FIXTURE_DEVICE. limits: what a procedure may ask of table and fixture.
    """

    format: Literal["mimu-station/1"] = "mimu-station/1"
    modbus_host: str
    modbus_port: int = Field(gt=0, lt=65536)
    unit_link: AnyLink
    station: Station
    mount: Mount = Mount()
    fixture: Literal["by_hand", "commanded"] = "by_hand"
    unit: Unit
    limits: Limits = Limits()
    equipment: tuple[MeasurementStandard, ...] = ()
