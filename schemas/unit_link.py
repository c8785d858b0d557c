"""The unit's data link and its frames: binary with a checksum, or lines of text."""

from collections.abc import Mapping
from math import pi
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, field_validator, model_validator

from schemas.base import Finite, Frozen
from schemas.described import SERIAL_SCHEMES, check_url
from schemas.recording import ACCEL, ANGLE, GYRO

SIZES: Mapping[str, int] = {
    "uint8": 1, "int8": 1, "uint16": 2, "int16": 2, "uint32": 4, "int32": 4, "uint64": 8,
    "int64": 8, "float32": 4, "float64": 8,
}  # fmt: skip
FieldType = Literal[
    "uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64"
]
UNITS: Mapping[str, float] = {
    "1": 1.0, "rad/s": 1.0, "deg/s": pi / 180.0, "m/s2": 1.0, "g": 9.80665, "rad": 1.0,
    "deg": pi / 180.0, "degC": 1.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9,
}  # fmt: skip
FieldUnit = Literal[
    "1", "rad/s", "deg/s", "m/s2", "g", "rad", "deg", "degC", "s", "ms", "us", "ns"
]  # fmt: skip
Check = Literal["crc16_xmodem", "crc16_ccitt_false", "crc16_modbus", "crc32", "sum8", "xor8"]
CHECK_BYTES: Mapping[str, int] = {
    "crc16_xmodem": 2, "crc16_ccitt_false": 2, "crc16_modbus": 2, "crc32": 4, "sum8": 1, "xor8": 1
}  # fmt: skip
CHANNELS = (*GYRO, *ANGLE, *ACCEL, "temperature")
LINE_SCHEMES = (*SERIAL_SCHEMES, "udp", "file")
PLACES = ("counter", "time", "skip", *CHANNELS)


class ClockComparison(Frozen):
    """Table time minus unit time = offset_s + skew · (unit time − at_s).

    `half_width_s`: how far the minimum delays of the line and of the table's answers may have
    shifted the offset either way; comparison at one end of a line cannot show them. `u_offset_s`,
    `u_skew`: standard uncertainties. That of the offset contains this half-width and the scatter of
    the delays; that of the skew only the scatter, since the minimum delays are constant. The delay
    between a unit's measurement and its time stamp is not included.
    """

    at_s: Finite
    offset_s: Finite
    half_width_s: Finite
    u_offset_s: Finite
    skew: Finite
    u_skew: Finite


class FrameField(Frozen):
    """One field of a frame: what it is, and the value of one count, as `scale` of a unit.

    name: a channel, `counter`, `time` (since power-on), or `skip` for an unused field.
    """

    name: str
    scale: Finite = 1.0
    unit: FieldUnit = "1"

    @field_validator("name")
    @classmethod
    def _is_known(cls, name: str) -> str:
        if name not in PLACES:
            raise ValueError(f"there is no field {name}: the fields are {', '.join(PLACES)}")
        return name

    @property
    def factor(self) -> float:
        """The value of one count in SI units, or in °C."""
        return self.scale * UNITS[self.unit]


class BinaryField(FrameField):
    """A field of a binary frame."""

    type: FieldType


class TextField(FrameField):
    """A field of a line; prefix: the text before its number."""

    prefix: str = ""


class _Frame(Frozen):
    @property
    def channels(self) -> dict[str, float]:
        """The channels in the order of the frame, and the value of one count of each."""
        return {f.name: f.factor for f in self._fields if f.name in CHANNELS}

    @property
    def _fields(self) -> tuple[FrameField, ...]:
        return getattr(self, "fields")  # noqa: B009 (declared by either kind)

    def has(self, name: str) -> bool:
        """Whether a field is in the frame."""
        return any(field.name == name for field in self._fields)

    @model_validator(mode="after")
    def _holds_whole_triads_once(self) -> Self:
        names = [field.name for field in self._fields if field.name != "skip"]
        if twice := [name for name in names if names.count(name) > 1]:
            raise ValueError(f"fields names {twice[0]} twice")
        for triad in (GYRO, ANGLE, ACCEL):
            missing = [name for name in triad if name not in names]
            if 0 < len(missing) < len(triad):
                raise ValueError(f"fields has no {missing[0]}")
        if not any(name in names for name in (*GYRO, *ANGLE, *ACCEL)):
            raise ValueError("fields has neither gyro_x, angle_x nor accel_x")
        return self


class BinaryFrame(_Frame):
    """A frame of fixed length: sync bytes, fields and a checksum.

    sync: as hexadecimal, in the order of transmission. The checksum covers everything from byte
    `check_from` up to itself, and has the byte order of the fields.
    """

    kind: Literal["binary"]
    sync: str
    byte_order: Literal["little", "big"] = "little"
    check: Check
    check_from: int = Field(default=0, ge=0)
    check_byte_order: Literal["little", "big"] | None = None
    fields: tuple[BinaryField, ...] = Field(min_length=1)

    @field_validator("sync")
    @classmethod
    def _is_hexadecimal(cls, sync: str) -> str:
        if not bytes.fromhex(sync):
            raise ValueError("sync has no byte")
        return sync

    @property
    def sync_bytes(self) -> bytes:
        return bytes.fromhex(self.sync)

    @property
    def size(self) -> int:
        """Bytes of a whole frame."""
        fields = sum(SIZES[field.type] for field in self.fields)
        return len(self.sync_bytes) + fields + CHECK_BYTES[self.check]


class TextFrame(_Frame):
    """A line: its prefix, its fields, and a checksum in hexadecimal after `*`.

    The checksum covers everything between the first character, if that is `$` or `!`, and the `*`.
    """

    kind: Literal["text"]
    start: str = ""
    separator: str = Field(default=",", min_length=1, max_length=1)
    terminator: str = Field(default="\n", min_length=1)
    check: Literal["xor8", "crc16_xmodem", "none"] = "none"
    fields: tuple[TextField, ...] = Field(min_length=1)


AnyFrame = BinaryFrame | TextFrame


class CoefficientLines(Frozen):
    """The lines of text that load a correction into the unit, one after the other.

    lines: with coefficients of the correction in braces, by name and index counted from 0, as
    `$WRITE,{C_g[0][1]:.7f},{B_g[2]:.4f}`. scale: SI value of the unit's own unit of a coefficient,
    if it uses another. check: the checksum appended to each line after `*`. acknowledge: text that
    the unit's answer to each line contains.
    """

    lines: tuple[str, ...] = Field(min_length=1)
    scale: Mapping[str, Finite] = {}
    check: Literal["xor8", "none"] = "none"
    terminator: str = Field(default="\r\n", min_length=1)
    acknowledge: str = Field(min_length=1)


class SerialQuery(Frozen):
    """How a unit reports its serial number while it continues to send frames.

    request: the line that asks for it. answer: the text before the serial number in the unit's
    answer, as `$SERIAL,`; the number ends at `,`, `*` or the end of the line.
    """

    request: str = Field(min_length=1)
    terminator: str = Field(default="\r\n", min_length=1)
    answer: str = Field(min_length=1)


class UnitLink(Frozen):
    """The unit's data link: the source of the frames, their rate and their content.

    load: how the unit receives the coefficients of its correction, if it does. identify: how it
    reports its serial number, if it does; a run then begins only if that is the one ordered. url:
    `socket://host:port`, a serial device, `udp://host:port` on which to listen, or `file:///path`
    of a file that is being written.
    """

    url: Annotated[str, AfterValidator(lambda url: check_url(url, LINE_SCHEMES))] = Field(
        min_length=1
    )
    baudrate: int = Field(default=460800, gt=0)
    rate_hz: Finite = Field(gt=0)
    frame: Annotated[AnyFrame, Field(discriminator="kind")]
    load: CoefficientLines | None = None
    identify: SerialQuery | None = None

    @model_validator(mode="after")
    def _can_be_asked(self) -> Self:
        if self.identify is not None and self.url.startswith(("udp://", "file://")):
            raise ValueError(
                f"identify asks the unit, and url {self.url} can only be read from: leave it out"
            )
        return self
