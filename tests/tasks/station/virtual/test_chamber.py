"""The chamber's air goes where it is set, no faster than it can."""

import pytest

from schemas.limits import ChamberLimits
from tasks.station.drivers.modbus import encode
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.fixture import VirtualChamber
from tasks.station.virtual.protocol import CHAMBER_REGISTERS
from tasks.station.virtual.registers import ChamberRegisters, RefusedWrite
from tasks.station.virtual.simulation import Simulation

ROOM = 20.0


@pytest.fixture
def chamber() -> VirtualChamber:
    return VirtualChamber(ChamberLimits(temperature_degc=(0.0, 50.0), rate_k_min=6.0), ROOM)


@pytest.mark.parametrize(("target", "sign"), [(30.0, 1.0), (10.0, -1.0)])
def test_it_goes_at_its_rate_and_stays(chamber, target, sign):
    chamber.go_to(100.0, target)
    assert chamber.degc(100.0) == ROOM
    assert chamber.degc(150.0) == pytest.approx(ROOM + sign * 5.0)
    assert chamber.degc(500.0) == target


def test_it_turns_back_from_where_it_got(chamber):
    chamber.go_to(0.0, 40.0)
    chamber.go_to(60.0, ROOM)
    assert chamber.degc(60.0) == pytest.approx(26.0)
    assert chamber.degc(90.0) == pytest.approx(23.0)


def test_its_set_point_is_a_register_that_takes_what_it_can_keep():
    simulation = Simulation(VirtualStation())
    registers = ChamberRegisters(simulation)
    place = next(each for each in CHAMBER_REGISTERS if each.name == "target")
    registers.write(place.address, encode(30.0, place.type))
    assert registers.values(None)["target"] == 30.0
    with pytest.raises(RefusedWrite):
        registers.write(place.address, encode(80.0, place.type))
    for _ in range(300):
        simulation.advance(100)
    assert registers.values(None)["temperature"] == pytest.approx(22.0, abs=0.01)
