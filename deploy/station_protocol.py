"""The station's protocol as a document: `python -m deploy.station_protocol > deploy/station.md`."""

import struct
from collections.abc import Iterable

from tasks.station.virtual.config import (
    AXIS_BASE,
    AXIS_REGISTERS,
    AXIS_STATUS,
    AXIS_STRIDE,
    CAPTURE_REGISTERS,
    CAPTURE_VALUES,
    CHAMBER_DEVICE,
    CHAMBER_REGISTERS,
    COMMANDS,
    FIXTURE_DEVICE,
    FIXTURE_REGISTERS,
    FIXTURE_STATUS,
    FRAMES,
    MODES,
    MOUNT_ANSWER,
    MOUNT_REQUEST,
    REFUSAL,
    SERIAL_ANSWER,
    SERIAL_REQUEST,
    TABLE_DEVICE,
    TABLE_REGISTERS,
    TABLE_STATUS,
    Frame,
    Register,
)
from tasks.station.virtual.faults import FAULTS

KINDS = {
    "H": "uint16",
    "I": "uint32",
    "Q": "uint64",
    "i": "int32",
    "q": "int64",
    "h": "int16",
}
TRIADS = {
    "gyro": ("gyro x, y, z", "counts of the field's `scale`"),
    "accel": ("accelerometer x, y, z", "counts of the field's `scale`"),
    "angle": (
        "angle x, y, z",
        "accumulated about each axis of the unit since power-on, counts of the field's `scale`",
    ),
}


def frame_fields(frame: Frame) -> list[tuple[str, str, str]]:
    """Code for the module struct, name and content of each field of a frame."""
    return [
        ("H", "sync", f"{frame.sync:#06x}"),
        ("I", "counter", "counts frames from 0 and turns over at 2³²"),
        ("Q", "time stamp", "µs since the unit's power-on, on the unit's own clock"),
        *((f"3{code}", *TRIADS[name]) for name, code in frame.triads),
        ("h", "temperature", "0.01 °C, the unit's own sensor"),
        ("H", "check", "CRC-16/XMODEM (polynomial 0x1021, start 0) over all bytes before it"),
    ]


HEAD = """\
# The station's protocol

Printed by `python -m deploy.station_protocol`; do not edit. The virtual station speaks it, and a
controller that speaks it is described by `tasks/station/stations/mimucal.toml`.
"""

BEHAVIOUR = """\
## How the table behaves

- Writing `mode` takes the targets as they stand and sets the axis going; a target written alone
  waits for the next `mode`. A write covers whole writable registers: one that does not, or that
  touches another address, is refused with exception 2, a value that means nothing with
  exception 3, and then nothing of it is taken.
- Addresses of the table that no register takes read as 0, so that its state and all axes can be
  read in one request. What one request reads is of one moment.
- `settled` is set when the axis has been within 2″ of its target angle, or within 1e-4 of its
  target rate, for 0.5 s of station time. In mode `off` it is never set.
- `fault`, `emergency_stop` and `interlock` ramp every axis to rest. Until command `reset` a new
  `mode` is accepted, falls back to `stop`, and the bit stays.
- Whoever sets the `watchdog` holds the table: until that client sets it to 0, ends its connection
  or lets it bite, every write of another is refused with exception 6, but to stop (`command` or
  `mode`) and to fetch (`capture_from`). A stop is taken from anybody, at any time.
- Command `quick_stop` ramps every axis to rest with the deceleration that the controller keeps for
  it (the virtual table's `quick_stop_deg_s2`, 400 deg/s²), `stop` with that of the last motion.
- `watchdog`: when the client that holds the table asked nothing of device 1 for that long (wall
  time), every axis ramps to rest and the bit is set until `reset`. It does not forbid a new motion.
  Fetching captured encoders is no sign of life, nor is anything that another client asks.
- The encoders are captured at whole multiples of `capture_period` and kept for at least 60 s of
  station time. Write `capture_from`, then read the block from `capture_count` on (or both at once
  with function 23). The virtual station's time stands still rather than overwrite what a client
  that has written `capture_from` has not fetched yet, until the table is let go, the watchdog
  bites or nothing was fetched for 30 s (wall time).
- The encoder count turns over at ±2³¹.
- Station time is the time of everything here but the watchdog. The virtual station runs it at
  `station.clock_speed` × wall time, or slower where the machine cannot keep up.
"""

FIXTURE = """\
Writing 1 to `turn` turns the unit over, to the attitude of `qw` to `qz` on the payload (the
quaternion's length does not count); `ready` is set when it is there. Switching the `supply` off
ends the unit's frames; switching it on starts its clock, its counter and the angles it accumulates
anew. Without this device a person turns the unit over: `fixture = "by_hand"` in the station file,
and the acquisition asks at the terminal.
"""


LINES = f"""\
## Lines of text on the unit's connection

Each ends with CR LF, and the answer comes among the frames. `station serve` describes the first in
`unit_link.identify` of its station file: by it a run confirms the unit before anything turns.

| sent | answered | what happens |
|---|---|---|
| `{SERIAL_REQUEST}` | `{SERIAL_ANSWER}V00012` | the unit tells its serial number |
| `{MOUNT_REQUEST}SERIAL,SEED` | `{MOUNT_ANSWER}SERIAL` | another unit is mounted in its place |

A unit without supply tells nothing. The unit that is mounted has the errors that the seed draws;
its clock and counter begin at 0, so that a run that is going on stops. What cannot be done is
answered with `{REFUSAL}` and the reason, and any other line with nothing.
"""


def _rows(registers: Iterable[Register]) -> list[str]:
    lines = [
        "| address | words | name | type | unit | access | meaning |",
        "|---:|---:|---|---|---|---|---|",
    ]
    for each in registers:
        access = "read, write" if each.writable else "read"
        lines.append(
            f"| {each.address} | {each.words} | `{each.name}` | {each.type} | {each.unit} "
            f"| {access} | {each.meaning} |"
        )
    return lines


def _bits(title: str, values: dict[str, int]) -> str:
    return f"{title}: " + ", ".join(f"{value} `{name}`" for name, value in values.items()) + "."


def _frame_rows(kind: str) -> list[str]:
    frame = FRAMES[kind]
    lines = [
        f"## The unit's frame of {kind}: `{frame.format}`, little-endian, {frame.size} bytes\n",
        "| byte | field | type | content |",
        "|---:|---|---|---|",
    ]
    offset = 0
    for code, name, content in frame_fields(frame):
        many = f"{code[:-1]} × " if len(code) > 1 else ""
        lines.append(f"| {offset} | {name} | {many}{KINDS[code[-1]]} | {content} |")
        offset += struct.calcsize(f"<{code}")
    return [*lines, ""]


def text() -> str:
    """The whole document, Markdown."""
    last = CAPTURE_REGISTERS[-1].address + 2 * CAPTURE_VALUES - 1
    lines = [
        HEAD,
        f"## Device {TABLE_DEVICE}, the table (Modbus/TCP, holding registers, high word first)\n",
        *_rows(TABLE_REGISTERS),
        "",
        _bits("Bits of `status`", TABLE_STATUS),
        _bits("Values of `command`", COMMANDS),
        "",
        f"### Axis i, outer first: address {AXIS_BASE} + {AXIS_STRIDE}·i + offset\n",
        *_rows(AXIS_REGISTERS),
        "",
        _bits("Values of `mode`", MODES),
        _bits("Bits of an axis's `status`", AXIS_STATUS),
        "",
        f"### Captured encoders: addresses {CAPTURE_REGISTERS[0].address} to {last}\n",
        *_rows(CAPTURE_REGISTERS),
        "",
        f"## Device {CHAMBER_DEVICE}, the chamber\n",
        *_rows(CHAMBER_REGISTERS),
        "",
        f"## Device {FIXTURE_DEVICE}, the fixture and the unit's supply\n",
        *_rows(FIXTURE_REGISTERS),
        "",
        _bits("Bits of `status`", FIXTURE_STATUS),
        "",
        FIXTURE,
        BEHAVIOUR,
        "The station file describes the frame in `unit_link.frame`.\n",
        *(row for kind in FRAMES for row in _frame_rows(kind)),
        LINES,
        "## Faults of the virtual station\n",
        "`station serve --fault NAME`, or `NAME@SECONDS` of station time, from which it holds.",
        "",
        "| name | what happens |\n|---|---|",
        *(f"| `{name}` | {meaning} |" for name, (_, meaning) in FAULTS.items()),
    ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(text(), end="")
