import math
import struct
from collections import Counter
from math import cos, radians, sin

import pytest

from schemas.base import Unusable
from schemas.laboratory import Limits
from schemas.procedure import Position, Procedure, RateRun
from schemas.recording import Mount, Station, TableAxis, Unit
from schemas.station import StationFile
from tasks.station import procedures
from tasks.station.check_devices import check_climate, check_state, check_station, check_unit
from tasks.station.plan import check_limits, check_procedure
from tasks.station.ports import AxisState, Climate, TableState
from tasks.station.virtual.config import VirtualStation, station_file
from tests.tasks.station.makers import modbus_maker
from tests.tasks.station.sample_stations import rates_link, sample

# A procedure against the limits of table, fixture and chamber.

JJF2003 = procedures.load("jjf2003")


def limited(limits: dict[str, object]) -> StationFile:
    station = station_file(VirtualStation(), 1.0, "nowhere", 1, 2)
    return station.model_copy(update={"limits": Limits.model_validate(limits)})


def outer(**limits: object) -> dict[str, object]:
    return {"axes": {"outer": limits}}


@pytest.mark.parametrize(
    "limits",
    [
        {},
        outer(rate_deg_s=1000.0, acceleration_deg_s2=2000.0),
        {"axes": {"middle": {"angle_deg": (-180.0, 270.0)}}},
    ],
)
def test_a_procedure_within_the_limits_is_let_through(limits):
    check_limits(JJF2003, limited(limits))


@pytest.mark.parametrize(
    ("limits", "sentence"),
    [
        (outer(rate_deg_s=5.0), r"needs \d+ deg/s \(limit 5\) about axis outer, and axis outer"),
        (outer(acceleration_deg_s2=1.0), r"needs \d+ deg/s2 \(limit 1\) about axis outer"),
        (outer(angle_deg=(-400.0, 400.0)), r"turns without end \(limit -400 to 400 deg\)"),
        (
            {"axes": {"middle": {"angle_deg": (-10.0, 10.0)}}},
            r"needs 90 deg \(limit -10 to 10 deg\) about",
        ),
        ({"fixture": {"rate_deg_s": 200.0}}, r"segment rate_x_\S+ .* and the fixture of station"),
        ({"axes": {"roll": {}}}, "names roll, and the table has the axes outer, middle, inner"),
    ],
)
def test_what_is_too_much_is_named_with_its_segment_and_limit(limits, sentence):
    with pytest.raises(Unusable, match=sentence):
        check_limits(JJF2003, limited(limits))


def heated(degc: float) -> Procedure:
    steps = JJF2003.steps[:2]
    hot = steps[1].model_copy(update={"chamber_degc": degc})
    return JJF2003.model_copy(update={"steps": (steps[0], hot)})


@pytest.mark.parametrize(
    ("limits", "sentence"),
    [
        ({}, r"position_\+x_\S+ .* sets the chamber to 45 °C, and .* has no limits.chamber"),
        (
            {"chamber": {"temperature_degc": (5.0, 40.0), "rate_k_min": 3.0}},
            r"sets the chamber to 45 °C, and limits.chamber of station \S+ allows 5 to 40 °C",
        ),
    ],
)
def test_a_temperature_that_the_chamber_may_not_have_is_refused(limits, sentence):
    with pytest.raises(Unusable, match=sentence):
        check_limits(heated(45.0), limited(limits))


def test_limits_of_a_chamber_that_cannot_be_set_are_refused():
    fields = sample()
    del fields["chamber"]["commands"]
    with pytest.raises(ValueError, match=r"chamber\.commands has no set_temperature"):
        StationFile.model_validate(fields)


def test_turns_count_from_where_they_begin_to_where_they_end():
    values = procedures.load("jjf1536").model_dump()
    turns = next(step for step in values["steps"] if step["kind"] == "turns")
    only = Procedure.model_validate(values | {"steps": [turns]})
    axes = len(turns["angles_deg"])
    assert axes == 1
    station = station_file(VirtualStation(), 1.0, "nowhere", 1, 2)
    end = turns["angles_deg"][0] + 360.0 * turns["turns"]
    name = station.station.table_axes[0].name

    def check(most_deg: float) -> None:
        limits = Limits.model_validate({"axes": {name: {"angle_deg": (-end, most_deg)}}})
        check_limits(only, station.model_copy(update={"limits": limits}))

    check(end)
    with pytest.raises(Unusable, match=f"needs {end:g} deg"):
        check(end - 1.0)


Z, X = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)


def station(*directions: tuple[float, float, float], mount: Mount | None = None) -> StationFile:
    axes = [TableAxis(name=f"axis{n}", direction=way) for n, way in enumerate(directions)]
    return StationFile(
        table=sample()["table"],
        chamber=sample()["chamber"],
        unit_link=rates_link(),
        station=Station(id="T3", table_axes=tuple(axes) or None),
        mount=mount or Mount(),
        unit=Unit(manufacturer="m", model="m", serial="s"),
    )


def changed(place: int, **fields: object) -> Procedure:
    steps = list(JJF2003.steps)
    steps[place] = steps[place].model_copy(update=fields)
    return JJF2003.model_copy(update={"steps": tuple(steps)})


def test_unit_mounted_a_quarter_turn_off_is_refused():
    quarter = 0.5**0.5  # body y lies along payload x
    turned = station(Z, X, Z, mount=Mount(quaternion_wxyz=(quarter, 0.0, 0.0, -quarter)))
    with pytest.raises(Unusable, match=r"position_\+x_000 .* says \+x up, .* bring \+y up"):
        check_procedure(JJF2003, turned)


@pytest.mark.parametrize(
    ("procedure", "bench", "sentence"),
    [
        (JJF2003, station(), "lists no station.table_axes"),
        (JJF2003, station(Z), "gives 3 angles and station T3 has 1 axes"),
        (JJF2003, station(Z, Z, Z), r"says \+x up, and its angles_deg bring \+z up"),
        (JJF2003, station((0.0, 0.0, -1.0), X, Z), "says it turns about x, .* about -x there"),
        (changed(1, name="position_+x_000"), station(Z, X, Z), "2 segments named"),
        (changed(13, spin_axis=3), station(Z, X, Z), "spins axis 3 and the table has axes 0 to 2"),
        (changed(13, rates_deg_s=(-1.0, 0.0)), station(Z, X, Z), "has a rate of 0"),
        (changed(13, axis="y"), station(Z, X, Z), r"says it turns about y, .* about \+x there"),
    ],
)
def test_what_the_station_cannot_do_is_refused_with_the_step(procedure, bench, sentence):
    with pytest.raises(Unusable, match=sentence):
        check_procedure(procedure, bench)


# What `station check` takes for no value: what no chamber, table or unit can have.

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


POSITIONS = [step for step in JJF2003.steps if isinstance(step, Position)]
RUNS = [step for step in JJF2003.steps if isinstance(step, RateRun)]


def payload_axes_in_navigation(outer, middle, inner):
    """Rz(outer)·Rx(middle)·Rz(inner) multiplied out; rows E, N, U, columns payload x, y, z."""
    co, so = cos(radians(outer)), sin(radians(outer))
    cm, sm = cos(radians(middle)), sin(radians(middle))
    ci, si = cos(radians(inner)), sin(radians(inner))
    return [
        [co * ci - so * cm * si, -co * si - so * cm * ci, so * sm],
        [so * ci + co * cm * si, -so * si + co * cm * ci, -co * sm],
        [sm * si, sm * ci, cm],
    ]


@pytest.mark.parametrize("step", JJF2003.steps, ids=lambda step: step.name)
def test_angles_bring_the_axis_up_that_the_step_names(step):
    upwards = payload_axes_in_navigation(*step.angles_deg)[2]
    wanted = [0.0, 0.0, 0.0]
    wanted["xyz".index(step.up[1])] = 1.0 if step.up[0] == "+" else -1.0
    assert upwards == pytest.approx(wanted, abs=1e-12)


def test_twelve_positions_are_each_axis_up_and_down_at_two_opposite_headings():
    twelve = [step for step in POSITIONS if step.item == "twelve_position"]
    assert Counter(step.up for step in twelve) == dict.fromkeys(
        ("+x", "-x", "+y", "-y", "+z", "-z"), 2
    )
    for first, second in zip(twelve[::2], twelve[1::2], strict=True):
        assert (first.turn_deg, second.turn_deg) == (0, 180)
        one = payload_axes_in_navigation(*first.angles_deg)
        other = payload_axes_in_navigation(*second.angles_deg)
        assert other[2] == pytest.approx(one[2], abs=1e-12)
        for row in (0, 1):  # what pointed east or north points the other way
            assert other[row] == pytest.approx([-value for value in one[row]], abs=1e-12)


def test_every_axis_has_seven_to_eleven_rates_of_both_signs():
    assert [run.axis for run in RUNS] == ["x", "y", "z"]
    for run in RUNS:
        rates = run.rates_deg_s
        assert 7 <= len(set(rates)) == len(rates) <= 11
        assert sorted(rates) == sorted(-rate for rate in rates)
        assert max(rates) == 300
        assert run.up == f"+{run.axis}"
        assert run.spin_axis == 0


def test_each_rate_run_stands_between_two_rests_in_the_same_attitude():
    for place, step in enumerate(JJF2003.steps):
        if isinstance(step, RateRun):
            for rest in (JJF2003.steps[place - 1], JJF2003.steps[place + 1]):
                assert rest.item == "rate_sensitivity"
                assert rest.angles_deg == step.angles_deg


def test_limits_are_those_of_clause_6():
    assert JJF2003.environment.temperature_degc == (15.0, 25.0)
    assert JJF2003.environment.humidity_percent == (20.0, 85.0)


def test_unknown_procedure_is_refused_with_the_known_names():
    with pytest.raises(Unusable, match=r"jjf1999.*jjf2003"):
        procedures.load("jjf1999")
