"""A run on a sound virtual station: in simulated time, and over sockets."""

import asyncio
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from pydantic import ValidationError

from schemas.base import Unusable
from schemas.procedure import Procedure, RateRun, Refix
from schemas.recording import GYRO, Mount
from schemas.station import StationFile
from tasks.calibrate.calibrate import calibrate
from tasks.motion.whole import whole_motion
from tasks.specifications.jjf1536 import JJF1536
from tasks.station import procedures
from tasks.station import recorder as recorder_module
from tasks.station.acquisition import (
    REPEATS,
    Acquired,
    NewRecording,
    Progress,
    RunRequest,
    check_run,
)
from tasks.station.plan import check_procedure
from tasks.station.ports import TableState
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.servers import running
from tests.tasks.station.in_memory import InMemoryStation, spoils_once
from tests.tasks.station.over_sockets import (
    MEASURED,
    SPEED,
    ignore,
    let_the_watchdog_bite,
    over_sockets,
    serving,
    table_and_watchdog,
)
from tests.tasks.station.short_ahrs import bench, part, run_of, settled


@dataclass(frozen=True)
class Run:
    acquired: Acquired
    kept: Any
    progress: list[Progress]
    station: StationFile
    left: tuple[TableState, int] | None = None


@pytest.fixture(scope="module")
def exact(short, new_sink) -> Run:
    """A run on a sound station in simulated time."""
    sink, progress = new_sink(), []
    station = InMemoryStation(VirtualStation())
    acquired = station.acquire(short, sink, progress.append)
    return Run(acquired, sink, progress, station.file)


@pytest.fixture(scope="module")
def real(short, new_sink) -> Run:
    """A run over sockets on a sound station in another process, after one that was killed."""
    sink, progress = new_sink(), []
    with running(VirtualStation(), SPEED) as station:
        asyncio.run(let_the_watchdog_bite(station))
        acquired = over_sockets(station, short, sink, progress.append)
        return Run(acquired, sink, progress, station, table_and_watchdog(station))


@pytest.fixture(params=["exact", pytest.param("real", marks=pytest.mark.real_time)])
def run(request) -> Run:
    return request.getfixturevalue(request.param)


def test_streams_have_no_gap(run):
    for name in ("imu", "table"):
        assert np.diff(run.kept.stream(name).t) == pytest.approx(0.01, abs=1e-9)


def test_streams_have_the_columns_of_the_format(run):
    table = run.kept.stream("table").columns
    assert list(table) == ["outer_angle", "middle_angle", "inner_angle"]
    environment = run.kept.stream("environment").columns
    assert list(environment) == ["temperature", "humidity", "supply_voltage", "pressure"]
    assert len(run.kept.stream("imu").columns) == 7


def test_labels_cover_the_run_without_holes(run):
    segments = run.acquired.manifest.segments
    for one, other in pairwise(segments):
        assert other.t_start == one.t_end
    assert [s.name for s in segments if s.kind in ("static", "rate")] == MEASURED
    for name in ("imu", "table"):
        t = run.kept.stream(name).t
        assert t[0] < segments[0].t_end
        assert t[-1] >= segments[-1].t_end - 0.02


def test_a_rest_sets_the_chamber_and_the_unit_warms(short, new_sink):
    sink = new_sink()
    first = short.steps[0].model_copy(update={"dwell_s": 30.0, "chamber_degc": 28.0})
    InMemoryStation(VirtualStation()).acquire(short.model_copy(update={"steps": (first,)}), sink)
    (hot,) = (each for each in sink.manifests[-1].segments if each.kind == "static")
    air = sink.stream("environment")
    before, after = air.t < hot.t_start, air.t > hot.t_end - 2.0
    assert air.columns["temperature"][before].max() == pytest.approx(20.0, abs=0.01)
    assert air.columns["temperature"][after].min() == pytest.approx(22.0, abs=0.2)


def test_the_chamber_is_read_from_the_beginning_to_the_end(exact):
    segments, t = exact.acquired.manifest.segments, exact.kept.stream("environment").t
    assert t[0] < segments[0].t_end
    assert t[-1] >= segments[-1].t_end - 1.0


def test_manifest_is_written_after_every_measured_segment(run):
    finished = [
        sum(s.kind in ("static", "rate") for s in manifest.segments)
        for manifest in run.kept.manifests
    ]
    assert finished == [0, 1, 2, 3, 4, 4]
    assert run.kept.manifests[-1] == run.acquired.manifest


def test_manifest_tells_unit_station_procedure_and_equipment(run):
    manifest = run.acquired.manifest
    assert manifest.recording_id in ("in memory", "over sockets")
    assert manifest.standard == "JJF 2003-2022"
    assert manifest.unit == run.station.unit
    assert manifest.station == run.station.station
    assert manifest.model_extra["procedure"] == "jjf2003"
    assert len(manifest.model_extra["equipment"]) == len(run.station.equipment)


def test_each_label_says_what_unit_and_encoders_did(run):
    imu, table = run.kept.stream("imu"), run.kept.stream("table")
    for segment in run.acquired.manifest.segments:
        rows = imu.rows(segment.t_start, segment.t_end)
        if segment.kind == "rate":
            gyro = np.degrees(imu.columns["gyro_x"][rows].mean())
            assert gyro == pytest.approx(segment.rate_deg_s, rel=0.02)
            at = table.rows(segment.t_start, segment.t_end)
            turned = np.degrees(table.columns["outer_angle"][at])
            slope = np.polyfit(table.t[at], turned, 1)[0]
            assert slope == pytest.approx(segment.rate_deg_s, rel=1e-4)


def test_gravity_is_on_the_axis_that_a_position_says_is_up(run):
    imu = run.kept.stream("imu")
    up, down = (
        imu.columns["accel_x"][imu.rows(segment.t_start, segment.t_end)].mean()
        for segment in run.acquired.manifest.segments
        if segment.kind == "static"
    )
    assert (up - down) / 2 == pytest.approx(9.8, abs=0.1)


def test_unit_and_encoders_are_on_one_clock(exact):
    """While the table moves, the gyros' length is the encoders' rate, at the same time."""
    imu, table = exact.kept.stream("imu"), exact.kept.stream("table")
    ramp = exact.acquired.manifest.segments[-3]
    rows = imu.rows(ramp.t_start, ramp.t_end)
    rate = np.gradient(table.columns["outer_angle"], table.t)
    expected = np.interp(imu.t[rows], table.t, rate)
    assert np.abs(imu.columns["gyro_x"][rows] - expected).max() < 0.1


def test_progress_never_runs_back_and_ends_at_its_total(run):
    done = [progress.station_s_done for progress in run.progress]
    assert done == sorted(done)
    assert done[-1] == run.progress[-1].station_s_total
    assert {"warm-up", "position +x 000", "rate x +100 deg/s"} <= {p.now for p in run.progress}


@pytest.mark.real_time
def test_table_is_left_at_rest_with_the_watchdog_off(real):
    state, watchdog = real.left
    assert [axis.rate_deg_s for axis in state.axes] == pytest.approx([0.0] * 3, abs=1e-6)
    assert watchdog == 0


def test_unit_with_a_clock_of_its_own_is_put_on_station_time(short, kept):
    sound = VirtualStation()
    late = sound.unit.model_copy(update={"clock_offset_s": 4.0})
    station = InMemoryStation(sound.model_copy(update={"unit": late}), speed=20.0)
    acquired = station.acquire(short, kept)
    shift = acquired.manifest.model_extra["unit_clock_shift_s"]
    assert shift == pytest.approx(4.0, abs=1.0)
    assert kept.stream("imu").t[-1] >= acquired.manifest.segments[-1].t_end


@pytest.mark.real_time
def test_run_after_one_that_was_killed_needs_no_reset(real):
    assert real.kept.measured() == MEASURED


@pytest.mark.real_time
def test_station_that_is_not_there_is_named(short, kept, real):
    with pytest.raises(Unusable, match=r"127\.0\.0\.1:\d+ does not answer"):
        over_sockets(real.station, short, kept)
    assert kept.pieces == {}
    assert kept.manifests == []


@pytest.mark.real_time
def test_unit_line_that_is_not_there_is_named(short, kept):
    with serving(VirtualStation(), SPEED) as station:
        link = station.unit_link.model_copy(update={"url": "socket://127.0.0.1:1"})
        with pytest.raises(Unusable, match=r"socket://127\.0\.0\.1:1 cannot be opened"):
            over_sockets(station.model_copy(update={"unit_link": link}), short, kept)
    assert kept.manifests == []


# A unit that is turned over in its fixture: by the station, by a person, or by nobody.


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


# Segments that wait for the operator, and those that are measured again.


def repeats(acquired: Acquired) -> list[str]:
    return [each.en for each in acquired.warnings if each.code == "segment_repeated"]


def test_a_pause_rests_before_the_next_segment_and_the_run_goes_on_as_one(short, kept):
    station = InMemoryStation(VirtualStation())
    rates = []

    def until_a_minute_has_passed() -> bool:
        resting = bool(kept.manifests) and len(kept.measured()) == 3
        if resting:
            rates.append(station.simulation.table.rate[0])
        return resting and station.simulation.table.now < 120.0

    recording = NewRecording(station.file, kept, "paused")
    request = RunRequest(
        station.file, short, (recording,), ignore, is_paused=until_a_minute_has_passed
    )
    station.run(request)
    assert rates[-1] == pytest.approx(0.0, abs=1e-6)
    assert kept.measured() == MEASURED
    assert any(s.name.startswith("pause") for s in kept.manifests[-1].segments)
    assert np.diff(kept.stream("imu").t) == pytest.approx(0.01, abs=1e-9)


def test_a_segment_that_a_moment_spoiled_is_measured_again_and_said_so(short, kept):
    station = InMemoryStation(VirtualStation())
    acquired = station.acquire(short, kept, spoils_once(station))
    assert sorted(kept.measured()) == sorted(MEASURED)
    assert kept.measured()[-1] == "rate_x_-50"
    assert ["rate_x_-50" in sentence for sentence in repeats(acquired)] == [True]
    lost = next(each for each in acquired.warnings if each.code == "unit_lost_samples")
    assert lost.segments == ()
    again = kept.manifests[-1].segments[-1]
    rows = kept.stream("imu").rows(again.t_start, again.t_end)
    assert np.diff(kept.stream("imu").t[rows]) == pytest.approx(0.01, abs=1e-9)


@pytest.mark.rehearsal
def test_a_segment_that_stays_bad_is_repeated_twice_and_then_kept_with_its_remark(short, kept):
    station = InMemoryStation(VirtualStation(), faults=[StationFault("stuck_channel")])
    acquired = station.acquire(short, kept)
    assert sorted(kept.measured()) == sorted(MEASURED)
    withdrawn = [s for s in kept.manifests[-1].segments if s.name.startswith("withdrawn")]
    assert len(withdrawn) == REPEATS * len(MEASURED)
    stuck = next(each for each in acquired.warnings if each.code == "stuck_channel")
    assert set(stuck.segments) == set(MEASURED)


def test_where_everything_is_bad_nothing_is_repeated(short, kept):
    station = InMemoryStation(VirtualStation(), faults=[StationFault("stuck_channel")])
    with patch.object(recorder_module, "MOST_REPEATED", 3):
        acquired = station.acquire(short, kept)
    assert repeats(acquired) == []
    assert kept.measured() == MEASURED


# A unit that is turned about none of its axes: acquired, labelled, and refused where half said.

RATE = 60.0
ASLANT = RateRun(
    name="aslant", item="decide", spin_axis=0, angles_deg=(0, 45, 0), rates_deg_s=(RATE,),
    dwell_s=2.0,
)  # fmt: skip


def test_a_unit_is_turned_aslant_and_its_label_names_the_axis_of_the_table(short, kept):
    station = InMemoryStation(VirtualStation())
    aslant = short.model_copy(update={"steps": (*short.steps[:1], ASLANT)})
    check_procedure(aslant, station.file)
    station.acquire(aslant, kept)
    segment = next(s for s in kept.manifests[-1].segments if s.name == "aslant_+60")
    assert (segment.kind, segment.axis, segment.up, segment.table_axis) == ("rate", None, None, 0)
    imu = kept.stream("imu")
    rates = imu.stack(GYRO)[imu.rows(segment.t_start, segment.t_end)]
    turned = np.sort(np.abs(np.degrees(rates.mean(axis=0))))
    assert turned == pytest.approx([0.0, RATE / 2**0.5, RATE / 2**0.5], abs=0.5)


def test_an_axis_without_the_one_that_is_up_is_refused():
    with pytest.raises(ValidationError, match="rate_run aslant has axis alone; give axis and up"):
        RateRun.model_validate(ASLANT.model_dump() | {"axis": "x"})


def test_labels_alone_do_not_say_how_a_unit_held_aslant_moves(ideal_run):
    recording = ideal_run(dwell=1.0)
    labels = recording.manifest.segments
    spin = next(k for k, s in enumerate(labels) if s.kind == "rate")
    changed = labels[spin].model_copy(update={"axis": None, "up": None, "table_axis": 0})
    manifest = recording.manifest.model_copy(
        update={"segments": (*labels[:spin], changed, *labels[spin + 1 :])}
    )
    without = replace(recording, manifest=manifest, table=None)
    rows = recording.imu.rows(changed.t_start, changed.t_end)
    assert np.isnan(whole_motion(without).rate[rows]).all()
    assert np.isfinite(whole_motion(replace(recording, table=None)).rate[rows]).all()
