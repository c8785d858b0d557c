"""A station file: the devices of a station, and what the manifest says about it."""

from typing import Literal, Self

from pydantic import model_validator

from schemas.base import Frozen
from schemas.devices import ChamberDevice, FixtureDevice, PythonDevice, TableDevice
from schemas.equipment import MeasurementStandard
from schemas.limits import Limits
from schemas.recording import Mount, Station, Unit
from schemas.unit_link import UnitLink

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
