"""What `station check` takes for no value: what no chamber, table or unit can have."""

import math
import struct

import pytest

from schemas.base import Unusable
from schemas.station import StationFile
from tasks.station.check_devices import check_station
from tasks.station.ports import AxisState, Climate, TableState
from tasks.station.possible import check_climate, check_state, check_unit
from tests.tasks.station.makers import modbus_maker
from tests.tasks.station.sample_stations import sample

READ = frozenset(("temperature", "humidity", "supply_voltage", "pressure"))
USUAL = {"temperature": 20.5, "humidity": 45.0, "supply_voltage": 5.0, "pressure": 1013.0}


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("temperature", -1.7e16, r"temperature is -1.7e\+16 °C where -100 to 200 °C is possible"),
        ("temperature", math.nan, r"temperature is no number \(nan\)"),
        ("humidity", math.nan, "humidity is no number"),
        ("humidity", 450.0, "humidity is 450 %RH"),
        ("supply_voltage", math.inf, "supply_voltage is no number"),
        ("pressure", 1.013, "pressure is 1.013 hPa"),
    ],
)
def test_a_value_of_the_air_that_is_none_is_said(name, value, says):
    with pytest.raises(Unusable, match=says):
        check_climate(Climate(0.0, **USUAL | {name: value}), READ)


def test_every_impossible_value_is_in_one_sentence_and_what_is_not_read_is_in_none():
    climate = Climate(0.0, math.nan, 450.0, math.nan, math.nan)
    with pytest.raises(Unusable, match=r"temperature is no number \(nan\); humidity is 450 %RH"):
        check_climate(climate, ("temperature", "humidity"))
    check_climate(Climate(math.nan, 20.0, math.nan, math.nan, math.nan), ("temperature",))
    check_climate(Climate(0.0, **USUAL), READ)


@pytest.mark.parametrize(("angle", "rate"), [(1e20, 0.0), (math.nan, 0.0), (0.0, -6e7)])
def test_an_angle_or_a_rate_that_no_table_has_is_said(angle, rate):
    axes = (AxisState(0.0, 0.0, False, True), AxisState(angle, rate, False, True))
    with pytest.raises(Unusable, match=r"(angle|rate) of axis inner is"):
        check_state(TableState(0.0, 0.0, axes), ("outer", "inner"))


REST = {f"gyro_{axis}": 1e-3 for axis in "xyz"} | {"accel_x": 0.1, "accel_y": 0.0, "accel_z": 9.8}


@pytest.mark.parametrize(
    ("change", "rate_hz", "says"),
    [
        ({"accel_z": 0.0}, 100.0, "gravity by the accelerometers is 0.1 m/s²"),
        ({"accel_z": 96.1}, 100.0, "gravity by the accelerometers is 96.1 m/s²"),
        ({"gyro_x": 1e9}, 100.0, "gyro_x is 1e\\+09 rad/s"),
        ({"gyro_x": math.nan}, 100.0, "gyro_x is no number"),
        ({"temperature": -1.7e16}, 100.0, "temperature is -1.7e\\+16"),
        ({}, 50.0, "rate_hz is 50 Hz where 80 to 120 Hz is possible"),
    ],
)
def test_a_mean_that_no_unit_at_rest_has_is_said(change, rate_hz, says):
    station = StationFile.model_validate(sample())
    check_unit(station, 100.0, REST | {"temperature": 25.0})
    with pytest.raises(Unusable, match=says):
        check_unit(station, rate_hz, REST | change)


@pytest.mark.real_time
def test_a_chamber_whose_words_are_read_in_another_order_does_not_work():
    class OtherOrder(modbus_maker.ModbusMaker):
        def answer(self, device: int, request: bytes) -> bytes:
            if device != 9:
                return super().answer(device, request)
            count = struct.unpack(">H", request[3:5])[0]
            octets = struct.pack(">f", 21.5)
            low_first = octets[2:] + octets[:2]
            return struct.pack(">BB", 4, 2 * count) + (low_first + b"\x00" * 8)[: 2 * count]

    fields, server = sample("modbus_polled"), modbus_maker.over_tcp(OtherOrder())
    fields["table"]["url"] = f"socket://127.0.0.1:{server.server_address[1]}"
    fields["chamber"] |= {"url": fields["table"]["url"], "word_order": "big"}
    fields["chamber"]["registers"] = {
        "temperature": {"address": 0, "bank": "input", "type": "float32"}
    }
    works = {}
    for order in ("big", "little"):
        fields["chamber"]["word_order"] = order
        fields["unit_link"]["url"] = "socket://127.0.0.1:1"
        trials = check_station(StationFile.model_validate(fields), move=False)
        works[order] = next(each.works for each in trials if each.device == "chamber")
    server.shutdown()
    server.server_close()
    assert works == {"big": False, "little": True}
