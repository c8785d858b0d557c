"""A run on the virtual station: in simulated time, and the few real ones over sockets."""

import asyncio
import signal
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.station import StationFile
from tasks.station import sequencer as sequencer_module
from tasks.station.acquisition import Acquired, RunRequest, acquire
from tasks.station.drivers.devices import Devices
from tasks.station.drivers.modbus import ModbusLink
from tasks.station.ports import TableState
from tasks.station.progress import Progress
from tasks.station.sequencer import GUARD_WALL_S, REPEATS, Sequencer
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.process import running
from tests.tasks.station.in_memory import InMemoryStation

SPEED = 20.0
WATCHDOG = 8  # its register
MEASURED = ["position_+x_000", "position_-x_000", "rate_x_-50", "rate_x_+100"]


@dataclass(frozen=True)
class Run:
    acquired: Acquired
    kept: Any
    progress: list[Progress]
    station: StationFile
    left: tuple[TableState, int] | None = None


def ignore(progress: Progress) -> None:
    pass


def over_sockets(
    station: StationFile,
    procedure: Procedure,
    sink: Any,
    report: Callable[[Progress], None] = ignore,
) -> Acquired:
    return acquire(RunRequest(station, procedure, sink, report, "over sockets"))


def table_and_watchdog(station: StationFile) -> tuple[TableState, int]:
    """The table's state once it is at rest, and its watchdog, by a connection of its own."""

    async def read() -> tuple[TableState, int]:
        devices = Devices(tuple(axis.name for axis in station.station.table_axes))
        link = ModbusLink(station.table)
        try:
            (watchdog,) = await link.read(1, "holding", WATCHDOG, 1)
            table = await devices.table(station.table)
            for _ in range(1000):
                state = await table.state()
                if not any(axis.is_moving for axis in state.axes):
                    break
                await asyncio.sleep(0.02)
            return state, watchdog
        finally:
            link.close()
            await devices.hang_up()

    return asyncio.run(read())


async def _let_the_watchdog_bite(station: StationFile) -> None:
    """As a run does that is killed: polls for a while, then no more."""
    link = ModbusLink(station.table)
    try:
        await link.write(1, "holding", WATCHDOG, [50])
        await asyncio.sleep(0.3)
    finally:
        link.close()


@pytest.fixture(scope="module")
def exact(short: Procedure, new_sink: Any) -> Run:
    """A run on a sound station in simulated time."""
    sink, progress = new_sink(), []
    station = InMemoryStation(VirtualStation())
    acquired = station.acquire(short, sink, progress.append)
    return Run(acquired, sink, progress, station.file)


@pytest.fixture(scope="module")
def real(short: Procedure, new_sink: Any) -> Run:
    """A run over sockets on a sound station in another process, after one that was killed."""
    sink, progress = new_sink(), []
    with running(VirtualStation(), SPEED) as station:
        asyncio.run(_let_the_watchdog_bite(station))
        acquired = over_sockets(station, short, sink, progress.append)
        return Run(acquired, sink, progress, station, table_and_watchdog(station))


@pytest.fixture(params=["exact", pytest.param("real", marks=pytest.mark.real_time)])
def run(request: pytest.FixtureRequest) -> Run:
    return request.getfixturevalue(request.param)


def test_sound_station_gives_no_warning(run):
    assert run.acquired.warnings == ()
    assert (run.acquired.bad_frames, run.acquired.lost_samples) == (0, 0)


def test_streams_have_no_gap(run):
    for name in ("imu", "table"):
        assert np.diff(run.kept.stream(name).t) == pytest.approx(0.01, abs=1e-9)


def test_the_chamber_is_read_about_once_a_station_second(exact):
    assert np.diff(exact.kept.stream("environment").t).max() < 2.0


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


def test_a_unit_on_the_stations_clock_is_not_moved(exact):
    assert "unit_clock_shift_s" not in exact.acquired.manifest.model_extra


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


STOPS = {
    "table_fault": "axis outer of the table reports fault: read the fault",
    "emergency_stop": "axis outer of the table reports emergency_stop: .* release",
    "interlock": "axis outer of the table reports interlock: close the guard",
    "never_settles": r"axis \w+ of the table has not settled at -?\d+ deg(/s)? within \d+ s",
    "unit_silent": r"the unit on socket://in-memory:1 has sent nothing for 3 s",
}
LINK_STOPS = {
    "modbus_silent": r"the station at 127\.0\.0\.1:\d+ does not answer",
    "modbus_exception": r"127\.0\.0\.1:\d+ refused .* exception 4 \(device failure\)",
}


@pytest.fixture
def long(short: Procedure) -> Procedure:
    """Still in its rates at 60 s of station time."""
    update = {"rates_deg_s": (-50, 100, -30, 60), "dwell_s": 60.0}
    return short.model_copy(
        update={"steps": (*short.steps[:2], short.steps[2].model_copy(update=update))}
    )


def kept_until(stop: pytest.ExceptionInfo[Unusable], kept: Any, seconds: float) -> None:
    sentence = str(stop.value)
    assert "the run stopped during «rate x " in sentence
    assert f"is kept (finished segments: {len(kept.measured())})" in sentence
    assert kept.measured()[:2] == MEASURED[:2]
    for stream in ("imu", "table", "environment"):
        assert kept.stream(stream).t[-1] > seconds


@pytest.mark.parametrize("name", STOPS)
def test_fault_stops_the_run_with_its_sentence_and_keeps_what_was_recorded(name, long, kept):
    station = InMemoryStation(VirtualStation(), faults=[StationFault(name, 60.0)])
    with pytest.raises(Unusable, match=STOPS[name]) as stop:
        station.acquire(long, kept)
    kept_until(stop, kept, 56.0)  # 60 s of the station, which began with the run; a flush is 4 s
    assert station.table.has_been_left


@pytest.mark.real_time
@pytest.mark.parametrize("name", LINK_STOPS)
def test_fault_of_the_link_stops_the_run_and_keeps_what_was_recorded(name, long, kept):
    with (
        running(VirtualStation(), SPEED, (StationFault(name, 40.0),)) as station,
        pytest.raises(Unusable, match=LINK_STOPS[name]) as stop,
    ):
        over_sockets(station, long, kept)
    # On a busy machine the run begins some seconds after the station was switched on.
    kept_until(stop, kept, 10.0)


WARNS = {
    "unit_garbage": ("unit_bad_frames", "unit_lost_samples"),
    "unit_drops": ("unit_lost_samples",),
    "stuck_channel": ("stuck_channel",),
    "spike": ("spikes",),
    "chamber_hot": ("air_temperature",),
    "table_rate_wrong": ("table_rate",),
}


@pytest.mark.parametrize("name", WARNS)
def test_fault_that_lets_the_run_end_is_a_warning_with_its_segments(name, short, kept):
    steps = [step.model_copy(update={"dwell_s": 16.0}) for step in short.steps[::2]]
    patient = short.model_copy(update={"steps": tuple(steps)})
    acquired = InMemoryStation(VirtualStation(), faults=[StationFault(name)]).acquire(patient, kept)
    remarks = [each for each in acquired.warnings if each.code != "segment_repeated"]
    assert {remark.code for remark in remarks} == set(WARNS[name])
    rates = {"rate_x_-50", "rate_x_+100"}
    for remark in remarks:
        assert rates <= set(remark.segments)
        assert remark.blocks_pass == (name == "chamber_hot")
        assert "rate_x_-50" in remark.en
        assert "rate_x_-50" in remark.zh
    assert (acquired.lost_samples > 0) == (name in ("unit_garbage", "unit_drops"))
    assert (acquired.bad_frames > 0) == (name == "unit_garbage")


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

    request = RunRequest(
        station.file, short, kept, ignore, "paused", is_paused=until_a_minute_has_passed
    )
    station.run(request)
    assert rates[-1] == pytest.approx(0.0, abs=1e-6)
    assert kept.measured() == MEASURED
    assert any(s.name.startswith("pause") for s in kept.manifests[-1].segments)
    assert np.diff(kept.stream("imu").t) == pytest.approx(0.01, abs=1e-9)


def test_a_segment_that_a_moment_spoiled_is_measured_again_and_said_so(short, kept):
    station = InMemoryStation(VirtualStation())
    begun: list[str] = []

    def spoil_once(progress: Progress) -> None:
        begun.append(progress.now)
        first = progress.now == "rate x -50 deg/s" and "rate x +100 deg/s" not in begun
        station.simulation.faults = (StationFault("unit_drops"),) if first else ()

    acquired = station.acquire(short, kept, spoil_once)
    assert sorted(kept.measured()) == sorted(MEASURED)
    assert kept.measured()[-1] == "rate_x_-50"
    assert ["rate_x_-50" in sentence for sentence in repeats(acquired)] == [True]
    lost = next(each for each in acquired.warnings if each.code == "unit_lost_samples")
    assert lost.segments == ()
    again = kept.manifests[-1].segments[-1]
    rows = kept.stream("imu").rows(again.t_start, again.t_end)
    assert np.diff(kept.stream("imu").t[rows]) == pytest.approx(0.01, abs=1e-9)


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
    with patch.object(sequencer_module, "MOST_REPEATED", 3):
        acquired = station.acquire(short, kept)
    assert repeats(acquired) == []
    assert kept.measured() == MEASURED


@pytest.mark.real_time
def test_interrupt_stops_the_table_and_keeps_what_was_recorded(short, kept):
    def interrupt(progress: Progress) -> None:
        if progress.now.startswith("rate"):
            signal.raise_signal(signal.SIGINT)

    with running(VirtualStation(), SPEED) as station:
        with pytest.raises(KeyboardInterrupt):
            over_sockets(station, short, kept, interrupt)
        state, watchdog = table_and_watchdog(station)
    assert [axis.rate_deg_s for axis in state.axes] == pytest.approx([0.0] * 3, abs=1e-6)
    assert watchdog == 0
    assert kept.measured() == MEASURED[:2]
    assert len(kept.stream("imu"))


def test_what_is_on_the_line_when_a_run_is_interrupted_is_kept(short, kept):
    def interrupt(progress: Progress) -> None:
        if progress.now.startswith("rate"):
            raise KeyboardInterrupt

    station = InMemoryStation(VirtualStation())
    with pytest.raises(KeyboardInterrupt):
        station.acquire(short, kept, interrupt)
    assert station.table.has_been_left
    assert kept.measured() == MEASURED[:2]
    assert kept.stream("imu").t[-1] >= kept.manifests[-1].segments[-1].t_end - 0.5


def test_unit_with_a_clock_of_its_own_is_put_on_station_time(short, kept):
    sound = VirtualStation()
    late = sound.unit.model_copy(update={"clock_offset_s": 4.0})
    station = InMemoryStation(sound.model_copy(update={"unit": late}))
    acquired = station.acquire(short, kept)
    shift = acquired.manifest.model_extra["unit_clock_shift_s"]
    assert shift == pytest.approx(4.0, abs=1.0)
    assert kept.stream("imu").t[-1] >= acquired.manifest.segments[-1].t_end


@pytest.mark.real_time
def test_run_after_one_that_was_killed_needs_no_reset(real):
    assert real.kept.measured() == MEASURED


@pytest.mark.real_time
def test_emergency_stop_is_never_reset_by_a_new_run(short, kept):
    with running(VirtualStation(), SPEED, (StationFault("emergency_stop"),)) as station:
        asyncio.run(_let_the_watchdog_bite(station))
        for _ in range(2):
            with pytest.raises(Unusable, match="reports emergency_stop"):
                over_sockets(station, short, kept)
    assert kept.manifests == []


def test_a_stop_is_noticed_at_once_while_nothing_else_asks_the_table(short, kept):
    """As the wait for a person who turns the unit over, in which no segment is measured."""
    patient = short.model_copy(update={"warm_up_s": 1e6})
    station = InMemoryStation(VirtualStation(), faults=[StationFault("emergency_stop", 100.0)])

    async def nobody_asks(sequencer: Any, planned: Any) -> None:
        await asyncio.sleep(1e6)

    with (
        patch.object(Sequencer, "run", nobody_asks),
        pytest.raises(Unusable, match="reports emergency_stop"),
    ):
        station.acquire(patient, kept)
    assert station.simulation.table.now - 100.0 < 2 * GUARD_WALL_S * SPEED
    assert station.table.has_been_left


def test_failing_sink_stops_the_table(short, kept):
    def full(name: str, stream: Any) -> None:
        if name == "imu":
            raise OSError(28, "No space left on device")

    kept.append = full
    station = InMemoryStation(VirtualStation())
    with pytest.raises(OSError, match="No space"):
        station.acquire(short, kept)
    assert station.table.has_been_left


@pytest.mark.real_time
def test_station_that_is_not_there_is_named(short, kept, real):
    with pytest.raises(Unusable, match=r"127\.0\.0\.1:\d+ does not answer"):
        over_sockets(real.station, short, kept)
    assert kept.pieces == {}
    assert kept.manifests == []


@pytest.mark.real_time
def test_unit_line_that_is_not_there_is_named(short, kept):
    with running(VirtualStation(), SPEED) as station:
        link = station.unit_link.model_copy(update={"url": "socket://127.0.0.1:1"})
        with pytest.raises(Unusable, match=r"socket://127\.0\.0\.1:1 cannot be opened"):
            over_sockets(station.model_copy(update={"unit_link": link}), short, kept)
    assert kept.manifests == []
