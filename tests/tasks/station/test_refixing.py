"""A unit that is turned over in its fixture: by the station, by a person, or by nobody."""

import asyncio

import pytest

from schemas.base import Unusable
from schemas.procedure import Procedure, Refix
from schemas.recording import Mount
from schemas.station import StationFile
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf1536 import JJF1536
from tasks.station import procedures
from tasks.station.acquisition import check_run
from tasks.station.requirements import check_procedure
from tasks.station.virtual.faults import StationFault
from tests.tasks.station.in_memory import InMemoryStation
from tests.tasks.station.in_thread import serving
from tests.tasks.station.over_sockets import over_sockets
from tests.tasks.station.short_ahrs import bench, part, run_of, settled


def test_a_fixture_that_did_not_turn_is_flagged_by_gravity_and_by_the_rates(tmp_path):
    procedure = part("fix_x_up", "rest_x", "scale_x", "rest2_x")
    made = run_of(tmp_path, procedure, (StationFault("fixture_stays"),))
    result = calibrate(JJF1536, made.recording, run="r", code_version="test")
    blocking = {(r.code, *r.segments) for r in result.remarks if r.blocks_pass}
    assert ("axes",) in blocking  # one sentence for all that lies otherwise than its labels say
    assert sum(code == "rate_not_read" for code, *_ in blocking) == 10
    assert result.items["ahrs_scale_factor"].value["x"] is None


def by_hand(station: InMemoryStation) -> StationFile:
    return station.file.model_copy(update={"fixture": "by_hand"})


def test_a_person_is_asked_once_for_each_refixing_and_the_unit_may_restart(new_sink):
    """The person turns the virtual fixture."""
    procedure, asked = part("fix_x_up", "rest_x", "fix_y_up", "rest_y"), []
    station, sink = InMemoryStation(settled()), new_sink()

    async def person(refix: Refix) -> None:
        asked.append(refix.instruction)
        await station.fixture.turn(refix)
        await asyncio.sleep(0.2)

    acquired = station.acquire(procedure, sink, file=by_hand(station), ask=person)
    assert asked == [step.instruction for step in procedure.steps if isinstance(step, Refix)]
    imu = sink.stream("imu")
    for segment in acquired.manifest.segments:
        if segment.kind == "static":
            rows = imu.rows(segment.t_start, segment.t_end)
            assert imu.columns[f"accel_{segment.up[1]}"][rows].mean() == pytest.approx(9.8, abs=0.5)
            assert rows.stop - rows.start == pytest.approx(100, abs=1)


def test_while_it_is_turned_over_no_attitude_is_claimed(tmp_path):
    made = run_of(tmp_path, part("fix_x_up", "rest_x", "fix_y_up", "rest_y"))
    manifest = made.recording.manifest
    mounts = {segment.name[:5]: segment.mount for segment in manifest.segments}
    assert mounts["refix"] is None
    assert mounts["rest_"] is not None


@pytest.mark.real_time
def test_a_fixture_is_turned_and_the_supply_switched_through_its_registers(new_sink):
    sink = new_sink()
    with serving(settled(), 20.0) as station:  # faster, a busy machine loses whole rests
        procedure = part("fix_x_up", "rest_x", "fix_y_up", "rest_y")
        acquired = over_sockets(station, procedure, sink)
    imu = sink.stream("imu")
    for segment in acquired.manifest.segments:
        if segment.kind == "static":
            rows = imu.rows(segment.t_start, segment.t_end)
            assert imu.columns[f"accel_{segment.up[1]}"][rows].mean() == pytest.approx(9.8, abs=0.5)
    assert len(acquired.manifest.model_extra["unit_power_on_s"]) == 1


def test_nobody_to_ask_is_said_before_anything_moves():
    with pytest.raises(Unusable, match=r"turned over by hand 8 times, and nobody is at a"):
        check_run(procedures.load("jjf1536"), bench("by_hand"), None)


def test_a_refix_with_nothing_behind_it_is_refused():
    document = part("fix_x_up", "rest_x").model_dump()
    with pytest.raises(ValueError, match="nothing is measured after refix fix_x_up"):
        Procedure.model_validate(document | {"steps": document["steps"][:1]})


def test_the_units_seat_in_the_fixture_turns_with_it():
    """Seated a quarter turn about z, the fixture's X up brings the unit's −Y up."""
    half = 0.5**0.5
    seat = Mount(quaternion_wxyz=(half, 0.0, 0.0, half))
    with pytest.raises(Unusable, match=r"rest_x .* says \+x up, .* bring -y up"):
        check_procedure(part("fix_x_up", "rest_x"), bench("commanded", seat))


def test_a_unit_that_was_switched_off_where_it_should_not_be_is_said(new_sink):
    procedure, station = part("fix_x_up", "rest_x"), InMemoryStation(settled())

    async def careless(refix: Refix) -> None:
        await station.fixture.turn(refix.model_copy(update={"power_off": True}))

    with pytest.raises(Unusable, match=r"stamp went back .* as after a restart: check its"):
        station.acquire(procedure, new_sink(), file=by_hand(station), ask=careless)
