"""Table, chamber and fixture as data: their abilities, and how they are read and commanded."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from schemas.base import Finite, Frozen
from schemas.described import ModbusDevice, TextDevice
from schemas.equipment import ErrorBound


class Capture(Frozen):
    """Encoders sampled by the controller itself: the registers of a block of samples, by name.

    Written: `wanted`, the number of the first sample wanted. Read, next to each other: `count`,
    `first` (the block's first number) and `samples`: axis after axis, sample after sample, as many
    as `values` hold. Sample n was taken at time n × period_us.
    """

    period_us: int = Field(gt=0)
    values: int = Field(gt=0, le=120)
    wanted: str
    count: str
    first: str
    samples: str


class _TableAbilities(Frozen):
    """Abilities of a table beside what it reads.

    turnover_deg: the angle at which its encoder wraps, or counter_bits: the width of its counter.
    poll_period_ms: how often the angles are read if the controller does not capture them.
    commanded_rate: how far a rate that it holds may be from the one commanded, relative; that one
    is then the reference where the times of polled angles tell the rate worse. settled_deg,
    settled_rate: how close (deg, and as a share of the rate), and settled_s: for how long, if the
    table has no flag for it.
    """

    turnover_deg: Finite | None = Field(default=None, gt=0)
    counter_bits: int | None = Field(default=None, gt=0, le=64)
    commanded_rate: ErrorBound | None = None
    poll_period_ms: int = Field(default=20, gt=0)
    settled_deg: Finite = Field(default=0.002, gt=0)
    settled_rate: Finite = Field(default=2e-3, gt=0)
    settled_s: Finite = Field(default=0.5, gt=0)
    home_timeout_s: Finite = Field(default=120.0, gt=0)

    @model_validator(mode="after")
    def _wraps_in_one_way(self) -> Self:
        if self.turnover_deg is not None and self.counter_bits is not None:
            raise ValueError("turnover_deg and counter_bits: give the one that is known")
        return self

    def turnover_of(self, scale: float) -> float | None:
        """The angle (deg) at which the encoder wraps, with one count of its counter in deg."""
        if self.counter_bits is not None:
            return 2.0**self.counter_bits * scale
        return self.turnover_deg

    @property
    def turnover(self) -> float | None:
        """The angle (deg) at which the encoder wraps; None: it does not."""
        raise NotImplementedError


class _Kind(Frozen):
    """What a device of a kind is asked for: the commands that it has, the values that it reads."""

    needed: ClassVar[tuple[str, ...]] = ()
    read: ClassVar[tuple[str, ...]] = ()

    @model_validator(mode="after")
    def _is_of_its_kind(self) -> Self:
        device: Any = self
        for name in self.needed:
            if name not in device.commands:
                raise ValueError(f"commands.{name} is missing")
        for name in self.read:
            if name not in device.readings:
                raise ValueError(f"nothing reads {name}")
        return self


class _Table(_Kind):
    needed = ("move_to", "turn_at", "stop")
    read = ("angle",)

    @model_validator(mode="after")
    def _knows_a_turn_that_it_asks_for(self) -> Self:
        table: Any = self
        if table.asks_within_a_turn and table.turnover is None:
            raise ValueError("move_to asks for angle_in_turn: give turnover_deg, as 360.0")
        return self


class _Chamber(_Kind):
    read = ("temperature",)


class _Fixture(_Kind):
    needed = ("turn",)


class ModbusTable(_Table, ModbusDevice, _TableAbilities):
    """A table behind registers."""

    capture: Capture | None = None

    @property
    def turnover(self) -> float | None:
        """By the scale of the register `angle`."""
        return self.turnover_of(self.registers["angle"].scale)

    @property
    def asks_within_a_turn(self) -> bool:
        """Whether it is sent to angles within a turn, and turns the short way."""
        return any(write.value == "angle_in_turn" for write in self.commands["move_to"])

    @model_validator(mode="after")
    def _captures_into_registers(self) -> Self:
        named = self.capture and (
            self.capture.wanted, self.capture.count, self.capture.first, self.capture.samples
        )  # fmt: skip
        for name in named or ():
            if name not in self.registers:
                raise ValueError(f"capture names {name}, which is no register")
        return self


class TextTable(_Table, TextDevice, _TableAbilities):
    """A table that takes lines of text; its angles are polled."""

    @property
    def turnover(self) -> float | None:
        """By the scale of `angle`."""
        return self.turnover_of(self.scale.get("angle", 1.0))

    @property
    def asks_within_a_turn(self) -> bool:
        """Whether it is sent to angles within a turn, and turns the short way."""
        return any("{angle_in_turn" in line for line in self.commands["move_to"])


class ModbusChamber(_Chamber, ModbusDevice):
    """A chamber behind registers."""


class TextChamber(_Chamber, TextDevice):
    """A chamber or a thermometer that takes lines of text."""


class ModbusFixture(_Fixture, ModbusDevice):
    """A fixture behind registers that turns the unit over, and may switch its supply."""


class TextFixture(_Fixture, TextDevice):
    """A fixture that takes lines of text."""


class PythonDevice(Frozen):
    """A class of another package, found by its entry point in the group of the device."""

    driver: Literal["python"]
    name: str = Field(min_length=1)
    options: Mapping[str, Any] = {}


_BY_DRIVER = Field(discriminator="driver")
TableDevice = Annotated[ModbusTable | TextTable | PythonDevice, _BY_DRIVER]
ChamberDevice = Annotated[ModbusChamber | TextChamber | PythonDevice, _BY_DRIVER]
FixtureDevice = Annotated[ModbusFixture | TextFixture | PythonDevice, _BY_DRIVER]
