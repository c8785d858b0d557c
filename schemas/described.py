"""A device described as data: how it is read and commanded, by registers or lines of text.

Both kinds name what they read: `time` (s), `angle` (deg) and `rate` (deg/s) of a table, the
columns of the environment stream of a chamber, and whatever the flags ask for. Commands are lists
of steps with the values given: an axis's `angle` (deg, past whole turns) or `angle_in_turn` (from 0
up to the turnover, reached the short way), `rate`, `speed` (its amount), `direction` (1 or -1) and
`acceleration`, a sinusoid's `amplitude` (deg), `frequency` (Hz) and `cycles`, a fixture's attitude
`qw` to `qz`, and a chamber's `temperature`.
"""

import string
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from schemas.base import Finite, Frozen

RegisterType = Literal[
    "bit", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64"
]
WORDS: Mapping[str, int] = {
    "bit": 1, "uint16": 1, "int16": 1, "uint32": 2, "int32": 2, "uint64": 4, "int64": 4,
    "float32": 2, "float64": 4,
}  # fmt: skip
Bank = Literal["holding", "input", "coil", "discrete"]
BIT_BANKS = ("coil", "discrete")
Given = Literal[
    "angle", "angle_in_turn", "rate", "speed", "direction", "acceleration", "amplitude",
    "frequency", "cycles", "qw", "qx", "qy", "qz", "temperature",
]  # fmt: skip
OF_AN_AXIS = ("move_to", "turn_at", "stop", "oscillate")  # commands
TRIPS = ("fault", "emergency_stop", "interlock", "watchdog")
FLAGS = (*TRIPS, "moving", "settled", "homed", "arrived")


SERIAL_SCHEMES = ("socket", "rfc2217", "loop", "hwgrep", "spy", "alt")  # that pyserial opens


def check_url(url: str, schemes: tuple[str, ...] = SERIAL_SCHEMES) -> str:
    """The url; raises ValueError, without repeating it, for one that no line can be opened by."""
    scheme, is_url, rest = url.partition("://")
    if not is_url:
        return url
    if scheme not in schemes:
        raise ValueError(
            f"there is no scheme {scheme}:// ({', '.join(schemes)} are known): write "
            f"socket://host:port for TCP, or a serial device such as /dev/ttyUSB0 or COM3"
        )
    if scheme in ("socket", "udp"):
        host, _, port = rest.rstrip("/").rpartition(":")
        if "@" in rest:
            raise ValueError("a socket takes no user and no password: write socket://host:port")
        if not host or not port.isdigit() or not 0 < int(port) < 65536:
            raise ValueError(f"there is no host and port: write {scheme}://host:502")
    return url


class Connection(Frozen):
    """url: `socket://host:port`, or a serial device such as `/dev/ttyUSB0` or `COM3`."""

    url: Annotated[str, AfterValidator(check_url)] = Field(min_length=1)
    baudrate: int = Field(default=115200, gt=0)
    parity: Literal["N", "E", "O"] = "N"
    stopbits: Literal[1, 2] = 1
    timeout_s: Finite = Field(default=1.0, gt=0, le=30)


class ModbusConnection(Connection):
    """framing: of a socket; a serial server that passes frames of a serial line through has rtu."""

    framing: Literal["tcp", "rtu"] = "tcp"


class Register(Frozen):
    """One value: what its words hold, times `scale` plus `offset`.

    stride: addresses from one axis to the next; without it, the value belongs to the whole device.
    byte_order: of the bytes within each word; null: the device's.
    """

    address: int = Field(ge=0, le=65535)
    type: RegisterType = "uint16"
    bank: Bank = "holding"
    stride: int | None = Field(default=None, ge=0)
    byte_order: Literal["big", "little"] | None = None
    scale: Finite = 1.0
    offset: Finite = 0.0

    @model_validator(mode="after")
    def _fits_its_bank(self) -> Self:
        if (self.type == "bit") != (self.bank in BIT_BANKS):
            raise ValueError("a coil or discrete input is of type bit, and nothing else is")
        if self.scale == 0:
            raise ValueError("scale is 0: give what one count is")
        return self

    @property
    def words(self) -> int:
        return WORDS[self.type]


class Write(Frozen):
    """A write of one register, with a fixed number or a value of the command."""

    write: str
    value: Finite | Given


class Query(Frozen):
    """A line sent and its answer, with `{name}` in place of each number.

    `{name:x}` accepts a hexadecimal number and `{name:w}` a text. With `{axis}` in `ask` the line
    is sent for each axis; without it, `{angle[0]}`, `{angle[1]}` … are the axes in one answer.
    """

    ask: str = Field(min_length=1)
    answer: str = Field(min_length=1)


class ErrorQuery(Frozen):
    """Asked after each line of a command that has no answer; `none`: the answer if all is well."""

    ask: str = Field(min_length=1)
    none: str


class Flag(Frozen):
    """A condition of the device, derived from a value that was read.

    It holds if the value, under the mask if given, is `equals`, or, if `equals` is not given, is
    not zero.
    """

    of: str
    mask: int | None = Field(default=None, gt=0)
    equals: int | str | None = None

    def is_set(self, value: Any) -> bool:
        """Whether a value that was read fulfils the condition."""
        if self.mask is not None:
            value = int(value) & self.mask
        return bool(value) if self.equals is None else bool(value == self.equals)


class Described(Connection):
    """Fields of every described device. expect: values that must be read, else it is another
    device.
    """

    expect: Mapping[str, Finite | str] = {}
    flags: Mapping[str, Flag] = {}

    @model_validator(mode="after")
    def _reads_what_is_asked_for(self) -> Self:
        for flag in self.flags:
            if flag not in FLAGS:
                raise ValueError(f"there is no flag {flag}: the flags are {', '.join(FLAGS)}")
        wanted = {*self.expect, *(flag.of for flag in self.flags.values())}
        if missing := sorted(wanted - self.readings):
            raise ValueError(f"nothing reads {missing[0]}, which expect or a flag asks for")
        return self

    @property
    def readings(self) -> frozenset[str]:
        """The names of what can be read."""
        raise NotImplementedError

    def not_of_each_axis(self, axes: int) -> str | None:
        """Which command or reading is not of each of so many axes, as a sentence; None: none."""
        raise NotImplementedError


class ModbusDevice(Described, ModbusConnection):
    """A device behind registers, over Modbus/TCP (`socket://…`) or Modbus/RTU (a serial device).

    word_order: of the words of a value; byte_order: of the bytes within each word.
    reads_across_gaps: addresses between registers may be read, so that one request suffices.
    """

    driver: Literal["modbus"] = "modbus"
    device: int = Field(default=1, ge=0, le=255)
    word_order: Literal["big", "little"] = "big"
    byte_order: Literal["big", "little"] = "big"
    reads_across_gaps: bool = False
    registers: Mapping[str, Register]
    commands: Mapping[str, tuple[Write, ...]] = {}

    @model_validator(mode="after")
    def _writes_registers_that_there_are(self) -> Self:
        for name, writes in self.commands.items():
            for write in writes:
                register = self.registers.get(write.write)
                if register is None:
                    raise ValueError(f"command {name} writes {write.write}, which is no register")
                if register.bank in ("input", "discrete"):
                    raise ValueError(f"command {name} writes {write.write}, which is read-only")
        return self

    @property
    def readings(self) -> frozenset[str]:
        """The registers by name."""
        return frozenset(self.registers)

    def not_of_each_axis(self, axes: int) -> str | None:
        """A command or an angle of one axis needs a register with a stride, of more than one."""
        for name in OF_AN_AXIS:
            writes = self.commands.get(name, ())
            if axes > 1 and writes and all(not self.registers[w.write].stride for w in writes):
                return f"commands.{name} writes no register with a stride"
        if axes > 1 and self.registers["angle"].stride is None:
            return "registers.angle has no stride"
        return None


class TextDevice(Described):
    """A device that takes lines of text, over TCP (`socket://…`) or a serial line.

    answer_terminator: what ends an answer: a prompt, where one does. answer_header: characters
    that stand before every answer and are no part of it. echoes: whether an answer begins with the
    line that it answers. axes: what `{axis}` is replaced by; 1, 2, 3 … by default. acknowledge: its
    answer to every line of a command, if it answers; empty for a prompt alone. errors: what is
    asked after a line that has no answer. pause_s: for how long nothing is sent after a line of a
    command. scale: its unit of a number, in ours.
    """

    driver: Literal["text"]
    terminator: str = Field(default="\n", min_length=1)
    answer_terminator: str = Field(default="\n", min_length=1)
    answer_header: int = Field(default=0, ge=0, le=100)
    echoes: bool = False
    acknowledge: str | None = None
    errors: ErrorQuery | None = None
    pause_s: Finite = Field(default=0.0, ge=0, le=10)
    axes: tuple[str, ...] = ()
    queries: tuple[Query, ...]
    scale: Mapping[str, Finite] = {}
    commands: Mapping[str, tuple[str, ...]] = {}

    @model_validator(mode="after")
    def _reports_errors_in_one_way(self) -> Self:
        if self.errors is not None and self.acknowledge is not None:
            raise ValueError("acknowledge and errors: give the one that the device has")
        return self

    @model_validator(mode="after")
    def _asks_and_tells_what_there_is(self) -> Self:
        for query in self.queries:
            _check_places(query.ask, ("axis",))
        for lines in self.commands.values():
            for line in lines:
                _check_places(line, ("axis", *Given.__args__))  # type: ignore[attr-defined]
        return self

    @property
    def readings(self) -> frozenset[str]:
        """What the answers hold, by name."""
        return frozenset(
            name.split("[")[0]
            for query in self.queries
            for _, name, _, _ in string.Formatter().parse(query.answer)
            if name
        )

    def not_of_each_axis(self, axes: int) -> str | None:
        """A command or an angle of one axis needs `{axis}`, of more than one."""
        if self.axes and len(self.axes) != axes:
            return f"axes lists {len(self.axes)}"
        for name in OF_AN_AXIS:
            lines = self.commands.get(name, ())
            if axes > 1 and lines and not any("{axis" in line for line in lines):
                return f"commands.{name} has no {{axis}}"
        of_each = any("{axis" in each.ask and "{angle" in each.answer for each in self.queries)
        places = [f"{{angle[{axis}]" for axis in range(axes)]
        in_one = all(any(place in each.answer for each in self.queries) for place in places)
        if axes > 1 and not of_each and not in_one:
            return f"no query reads the angle of each axis, {{angle[0]}} to {{angle[{axes - 1}]}}"
        return None


def _check_places(line: str, known: tuple[str, ...]) -> None:
    try:
        line.format(**dict.fromkeys(known, 1.0))
    except (KeyError, IndexError, ValueError) as error:
        raise ValueError(
            f"{line!r} has a place that nothing fills ({error}): use {', '.join(known)}"
        ) from error
