"""A station file: the devices of a station, and what the manifest says about it."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import AwareDatetime, Field, ValidationError, model_validator

from schemas.base import Finite, Frozen, Unusable, first_fault
from schemas.described import ModbusDevice, TextDevice
from schemas.laboratory import ErrorBound, Limits, MeasurementStandard
from schemas.recording import Mount, Station, Unit
from schemas.text import Statement
from schemas.unit_link import UnitLink

# Table, chamber and fixture as data: their abilities, and how they are read and commanded.


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
        """Returns the turnover by the scale of the register `angle`."""
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
        """Returns the turnover by the scale of `angle`."""
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


SET_TEMPERATURE = "set_temperature"  # of a chamber's commands


class UnitOnTable(Frozen):
    """A further unit on the same table: data link, mount in the fixture, and identity."""

    unit_link: UnitLink
    mount: Mount = Mount()
    unit: Unit


class StationFile(Frozen):
    """A station to acquire from: its devices, the manifest's station part, unit and fixture.

    mount: of the unit in its fixture. fixture: who turns the fixture over, a person or a device.
    limits: of table, fixture and chamber. other_units: units measured in the same run.
    """

    format: Literal["mimu-station/2"] = "mimu-station/2"
    table: TableDevice
    chamber: ChamberDevice
    unit_link: UnitLink
    station: Station
    mount: Mount = Mount()
    fixture: Literal["by_hand"] | FixtureDevice = "by_hand"
    unit: Unit
    limits: Limits = Limits()
    equipment: tuple[MeasurementStandard, ...] = ()
    other_units: tuple[UnitOnTable, ...] = ()

    @model_validator(mode="after")
    def _a_chamber_with_limits_can_be_set(self) -> Self:
        commands = getattr(self.chamber, "commands", None)
        if self.limits.chamber and commands is not None and SET_TEMPERATURE not in commands:
            raise ValueError(
                f"limits.chamber allows temperatures, and chamber.commands has no {SET_TEMPERATURE}"
            )
        return self

    @model_validator(mode="after")
    def _table_is_described_for_each_axis(self) -> Self:
        axes = len(self.station.table_axes or ())
        table = self.table
        fault = None if isinstance(table, PythonDevice) else table.not_of_each_axis(axes)
        if axes and fault:
            raise ValueError(f"station.table_axes has {axes} axes, and in table {fault}")
        return self

    @model_validator(mode="after")
    def _units_are_apart(self) -> Self:
        """Two readers of one data link would each receive half of the data, and two runs of one
        unit would get the same name.
        """
        every = self.per_unit()
        for what, each in (
            ("unit.serial", [one.unit.serial for one in every]),
            ("unit_link.url", [one.unit_link.url for one in every]),
        ):
            if twice := [name for name in each if each.count(name) > 1]:
                raise ValueError(f"two units have the same {what}: {twice[0]}")
        return self

    def per_unit(self) -> tuple[Self, ...]:
        """The station once for each of its units, as if that were the only one on the table."""
        alone = (
            {name: getattr(one, name) for name in UnitOnTable.model_fields}
            for one in (self, *self.other_units)
        )
        return tuple(self.model_copy(update=fields | {"other_units": ()}) for fields in alone)

    def with_units(self, units: tuple[Unit, ...]) -> Self:
        """The station with these units mounted, in the order of its places.

        Raises ValueError for another number of units than the station has places.
        """
        places = 1 + len(self.other_units)
        if len(units) != places:
            raise ValueError(f"station {self.station.id} has {places} places, not {len(units)}")
        others = zip(self.other_units, units[1:], strict=True)
        moved = tuple(place.model_copy(update={"unit": unit}) for place, unit in others)
        return self.model_validate(
            self.model_copy(update={"unit": units[0], "other_units": moved}).model_dump()
        )


# The configuration of a unit during calibration, from its manifest or the client's order.

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Configuration(Frozen):
    """Ranges, output rate, bandwidth and firmware of a unit; null if unknown.

    rate_range_deg_s, accel_range_g: the largest input in either direction. condition: of the unit
    when it was received.
    """

    rate_range_deg_s: Positive | None = None
    accel_range_g: Positive | None = None
    output_rate_hz: Positive | None = None
    bandwidth_hz: Positive | None = None
    firmware: str | None = None
    condition: str | None = None
    condition_zh: str | None = None


def configuration_of(unit: Unit, ordered: Configuration | None) -> Configuration:
    """The configuration in the manifest's `unit`, completed by the order.

    Raises Unusable for an impossible value, and where the two contradict each other.
    """
    extra = unit.model_extra or {}
    named = {n: extra[n] for n in Configuration.model_fields if extra.get(n) is not None}
    try:
        recorded = Configuration.model_validate(named, strict=True).model_dump(exclude_none=True)
    except ValidationError as error:
        raise Unusable(
            f"the manifest's unit: {first_fault(error)}; correct it there and import the "
            "recording again"
        ) from error
    added = ordered.model_dump(exclude_none=True) if ordered else {}
    for name, value in added.items():
        if recorded.get(name, value) != value:
            raise Unusable(
                f"the order says configuration.{name} = {value}, but the manifest says "
                f"{recorded[name]}: correct the order"
            )
    return Configuration.model_validate(recorded | added)


# A stop of a station: the request, the answer of the run, and the outcome.


class StopRequest(Frozen):
    """Somebody wants a station to stop. key: identifies this request."""

    format: Literal["mimu-stop/1"] = "mimu-stop/1"
    key: str = Field(min_length=1)
    station: str
    by: str = Field(min_length=1)
    at: AwareDatetime


class AxisReading(Frozen):
    """An axis as it was read last: angle (deg) and rate (deg/s)."""

    name: str
    angle_deg: Finite
    rate_deg_s: Finite


class StopAnswer(Frozen):
    """The answer of a run's process to the request with this key: every axis was commanded to stop.

    at_rest: null while the axes still turn and are being read.
    """

    key: str
    process: int
    at_rest: bool | None = None
    axes: tuple[AxisReading, ...] = ()


class Stopped(Frozen):
    """What came of a stop.

    at_rest: whether the table was read to be at rest. axes: as read last. way: whether the run's
    own process stopped the table, or the stop itself on a connection of its own. recordings: what
    the run had recorded. fault: why it could not be confirmed; cause: the same for the
    pages. seconds: since the button was pressed.
    """

    format: Literal["mimu-stopped/1"] = "mimu-stopped/1"
    station: str
    by: str
    at_rest: bool
    axes: tuple[AxisReading, ...] = ()
    way: Literal["run", "directly"]
    recordings: tuple[str, ...] = ()
    fault: str = ""
    cause: Statement | None = None
    seconds: Finite
