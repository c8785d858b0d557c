"""The protocol of the virtual station: register maps, and the layout of the unit's frames.

`python -m deploy.station_protocol` prints it as deploy/station.md. A client knows it from a station
file alone (tasks/station/stations/mimucal.toml), and never from here.
"""

import struct
from typing import Literal

from pydantic import Field

from schemas.base import Frozen
from schemas.recording import ACCEL, ANGLE, GYRO

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
)  # fmt: skip

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

# Lines of text on a unit's connection, each ended by CR LF; answers come among the frames.
SERIAL_REQUEST, SERIAL_ANSWER = "$SERIAL?", "$SERIAL,"
MOUNT_REQUEST, MOUNT_ANSWER, REFUSAL = "$MOUNT,", "$MOUNTED,", "$REFUSED,"
