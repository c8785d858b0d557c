"""A station file: the devices of a station, and what the manifest says of it."""

from datetime import date
from typing import Literal

from schemas.base import Frozen
from schemas.devices import ChamberDevice, FixtureDevice, TableDevice
from schemas.limits import Limits
from schemas.recording import Mount, Station, Unit
from schemas.unit_link import UnitLink

LimitShape = Literal["normal", "rectangular", "triangular", "arcsine"]


class MeasurementStandard(Frozen):
    """A measurement standard, as clause 8 h) wants it on the certificate."""

    name: str
    name_zh: str
    serial: str
    accuracy: str
    certificate: str
    valid_until: date | None = None


class StationFile(Frozen):
    """A station to acquire from: its devices, the manifest's station part, unit and fixture.

    mount: how the unit sits in its fixture. fixture: who turns the fixture over, a person or a
    device. limits: what a procedure may ask of table and fixture.
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
