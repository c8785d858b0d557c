"""Each fault of the virtual station shows where it should, and from when it should."""

import numpy as np
import pytest
from pymodbus.exceptions import ModbusIOException

from schemas.base import Unusable
from tasks.station.virtual.config import AXIS_STATUS, MODES, TABLE_STATUS, VirtualStation
from tasks.station.virtual.faults import FAULTS, StationFault, condition
from tasks.station.virtual.simulation import Simulation
from tests.tasks.station.over_sockets import serving

SPEED = 20.0
SETTLED = AXIS_STATUS["settled"]


def suffering(text: str):
    return serving(VirtualStation(), SPEED, [StationFault.parse(text)])


def test_a_fault_is_read_with_and_without_its_time():
    assert StationFault.parse("spike") == StationFault("spike", 0.0)
    assert StationFault.parse("spike@12.5") == StationFault("spike", 12.5)
    assert StationFault.parse(str(StationFault("spike", 12.5))) == StationFault("spike", 12.5)


def test_an_unknown_fault_is_refused_with_all_names():
    with pytest.raises(Unusable) as refusal:
        StationFault.parse("gremlins@3")
    assert all(name in str(refusal.value) for name in ("gremlins", *FAULTS))


@pytest.mark.parametrize("text", ["spike@", "spike@soon", "spike@-1", "spike@nan", "spike@inf"])
def test_a_time_that_is_none_is_refused(text):
    with pytest.raises(Unusable, match="give station seconds"):
        StationFault.parse(text)


def test_a_fault_holds_from_its_time_on_and_faults_add_up():
    faults = [StationFault("chamber_hot", 10.0), StationFault("never_settles", 20.0)]
    assert condition(faults, 9.9).air_degc is None
    assert condition(faults, 10.0).air_degc == 30.0
    assert condition(faults, 20.0).air_degc == 30.0
    assert condition(faults, 20.0).hunting_rad > 0


@pytest.mark.parametrize(
    ("name", "bit"),
    [
        ("table_fault", "fault"),
        ("emergency_stop", "emergency_stop"),
        ("interlock", "interlock"),
    ],
)
def test_a_safety_fault_stops_the_table_and_refuses_until_reset(in_memory, name, bit):
    console = in_memory(f"{name}@2")
    console.go("rate", 2, rate=20.0)
    console.until(lambda: console.has(TABLE_STATUS[bit]))
    assert 2e6 <= console.read("station_time") <= 2.02e6
    assert console.has(AXIS_STATUS[bit], 2)
    console.until(lambda: abs(console.read("rate", 2)) < 1e-3)
    console.write("mode", MODES["rate"], 2)
    assert console.read("mode", 2) == MODES["stop"]
    console.write("command", 1)
    assert not console.has(TABLE_STATUS[bit])
    console.go("rate", 2, rate=20.0)
    console.until(lambda: console.has(SETTLED, 2))


def test_a_wrong_rate_is_two_percent_off_and_says_settled(in_memory):
    console = in_memory("table_rate_wrong")
    console.go("rate", 2, rate=50.0)
    console.until(lambda: console.has(SETTLED, 2))
    assert console.read("rate", 2) == pytest.approx(51.0, rel=1e-4)
    assert console.read("target_rate", 2) == 50.0


@pytest.mark.real_time
def test_a_silent_controller_does_not_answer(consoles):
    with suffering("modbus_silent@3") as station:
        console = consoles(station, timeout=1.0)
        with pytest.raises(ModbusIOException, match="No response"):
            console.wait(5.0)


@pytest.mark.real_time
def test_a_failing_controller_answers_with_an_exception(consoles):
    with suffering("modbus_exception") as station:
        console = consoles(station)
        answer = console.client.read_holding_registers(0, count=1, device_id=1)
        assert answer.exception_code == 4


def test_a_hot_chamber_reads_thirty_degrees_and_warms_the_unit(in_memory, whole):
    console = in_memory("chamber_hot@1")
    console.wait(2.0)
    assert console.read_chamber("temperature") == 30.0
    console.wait(10.0)
    degc = [frame[9] / 100 for frame in whole(b"".join(console.sent))]
    assert degc[-1] > degc[100] > 20.0


def test_garbage_breaks_some_frames_and_leaves_the_others(in_memory, whole):
    console = in_memory("unit_garbage")
    console.wait(10.0)
    counters = np.array([frame[1] for frame in whole(b"".join(console.sent))])
    assert len(counters) > 900
    assert (counters % 20 != 0).all()
    assert set(np.diff(counters)) == {1, 2}


def test_dropped_frames_show_as_a_jump_of_the_counter(in_memory, whole):
    console = in_memory("unit_drops")
    console.wait(12.0)
    jumps = np.diff([frame[1] for frame in whole(b"".join(console.sent))])
    assert set(jumps) == {1, 11}


def counts_under(name: str, seconds: int = 40) -> np.ndarray:
    simulation = Simulation(VirtualStation(), [StationFault.parse(name)])
    sent = b"".join(b"".join(simulation.advance(1000)) for _ in range(seconds))
    rows = np.frombuffer(sent, np.dtype([("head", "V14"), ("counts", "<i4", 6), ("tail", "V4")]))
    return rows["counts"]


def test_a_stuck_channel_gives_one_value_and_only_that_channel():
    spread = counts_under("stuck_channel", 2).std(axis=0)
    assert spread[1] == 0
    assert (np.delete(spread, 1) > 0).all()
