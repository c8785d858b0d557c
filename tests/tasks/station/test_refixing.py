"""A unit that is turned over in its fixture: by the station, by a person, or by nobody."""

import asyncio

import pytest
from short_ahrs import SPEED, bench, ignore, part, run_of, settled

from schemas.base import Unusable
from schemas.procedure import Procedure, Refix
from schemas.recording import Mount
from schemas.station import StationFile
from tasks.specifications import jjf1536
from tasks.station import procedures
from tasks.station.fixture import Commanded
from tasks.station.modbus import Link
from tasks.station.sequence import acquire
from tasks.station.suits import check_suits
from tasks.station.virtual.config import ahrs_station
from tasks.station.virtual.faults import Fault
from tasks.station.virtual.process import running


def test_a_fixture_that_did_not_turn_is_flagged_by_gravity_and_by_the_rates(tmp_path):
    procedure = part("fix_x_up", "rest_x", "scale_x", "rest2_x")
    made = run_of(tmp_path, procedure, (Fault("fixture_stays"),))
    result = jjf1536.calibrate(made.recording, run="r", code_version="test")
    blocking = {(r.code, *r.segments) for r in result.remarks if r.blocks_pass}
    assert {("position_contradicted", "rest_x"), ("position_contradicted", "rest2_x")} <= blocking
    assert sum(code == "rate_not_read" for code, *_ in blocking) == 10
    assert result.items["ahrs_scale_factor"].value["x"] is None


def test_frames_of_the_wrong_kind_are_said_in_one_sentence(new_sink):
    with running(ahrs_station(1), SPEED) as station:
        told = station.model_dump(mode="json")
        told["unit_link"] = {
            "url": station.unit_link.url, "rate_hz": 10, "gyro_lsb_rad_s": 1e-6,
            "accel_lsb_m_s2": 1e-5,
        }  # fmt: skip
        wrong = StationFile.model_validate(told)
        slow = part("fix_x_up", "rest_x").model_copy(update={"warm_up_s": 3600.0})
        with pytest.raises(Unusable) as stop:
            acquire(wrong, slow, new_sink(), ignore, recording_id="wrong")
    assert "sends frames of angles where unit_link.frame of the station file says rates" in str(
        stop.value
    )
    assert "\n" not in str(stop.value)


def test_a_person_is_asked_once_for_each_refixing_and_the_unit_may_restart(new_sink):
    """The person turns the virtual fixture through a line of their own."""
    procedure, asked = part("fix_x_up", "rest_x", "fix_y_up", "rest_y"), []
    with running(settled(), 20.0) as station:

        async def person(refix: Refix) -> None:
            asked.append(refix.instruction)
            link = Link(station.modbus_host, station.modbus_port)
            try:
                await Commanded(link).turn(refix)
                await asyncio.sleep(0.2)
            finally:
                link.close()

        by_hand = station.model_copy(update={"fixture": "by_hand"})
        sink = new_sink()
        acquired = acquire(by_hand, procedure, sink, ignore, recording_id="hand", ask=person)
    assert asked == [step.instruction for step in procedure.steps if isinstance(step, Refix)]
    imu = sink.stream("imu")
    for segment in acquired.manifest.segments:
        if segment.kind == "static":
            rows = imu.rows(segment.t_start, segment.t_end)
            assert imu.columns[f"accel_{segment.up[1]}"][rows].mean() == pytest.approx(9.8, abs=0.5)
            assert rows.stop - rows.start == pytest.approx(100, abs=1)


def test_nobody_to_ask_is_said_before_anything_moves(new_sink):
    sink = new_sink()
    with pytest.raises(Unusable, match=r"turned over by hand 8 times, and nobody is at a"):
        acquire(bench("by_hand"), procedures.load("jjf1536"), sink, ignore, recording_id="alone")
    assert sink.manifests == []


def test_a_refix_with_nothing_behind_it_is_refused():
    told = part("fix_x_up", "rest_x").model_dump()
    with pytest.raises(ValueError, match="nothing is measured after refix fix_x_up"):
        Procedure.model_validate(told | {"steps": told["steps"][:1]})


def test_the_units_seat_in_the_fixture_turns_with_it():
    """Seated a quarter turn about z, the fixture's X up brings the unit's −Y up."""
    half = 0.5**0.5
    seat = Mount(quaternion_wxyz=(half, 0.0, 0.0, half))
    with pytest.raises(Unusable, match=r"rest_x .* says \+x up, .* bring -y up"):
        check_suits(part("fix_x_up", "rest_x"), bench("commanded", seat))


def test_a_unit_that_was_switched_off_where_it_should_not_be_is_said(new_sink):
    procedure = part("fix_x_up", "rest_x")
    with running(settled(), 20.0) as station:

        async def careless(refix: Refix) -> None:
            link = Link(station.modbus_host, station.modbus_port)
            try:
                await Commanded(link).turn(refix.model_copy(update={"power_off": True}))
            finally:
                link.close()

        by_hand = station.model_copy(update={"fixture": "by_hand"})
        with pytest.raises(Unusable, match=r"stamp went back .* as after a restart: check its"):
            acquire(by_hand, procedure, new_sink(), ignore, recording_id="cut", ask=careless)
