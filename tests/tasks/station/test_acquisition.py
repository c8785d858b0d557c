"""A run on a sound virtual station: in simulated time, and over sockets."""

import asyncio
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.station import StationFile
from tasks.station.acquisition import Acquired
from tasks.station.ports import TableState
from tasks.station.progress import Progress
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.process import running
from tests.tasks.station.in_memory import InMemoryStation
from tests.tasks.station.in_thread import serving
from tests.tasks.station.over_sockets import (
    MEASURED,
    SPEED,
    let_the_watchdog_bite,
    over_sockets,
    table_and_watchdog,
)


@dataclass(frozen=True)
class Run:
    acquired: Acquired
    kept: Any
    progress: list[Progress]
    station: StationFile
    left: tuple[TableState, int] | None = None


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
        asyncio.run(let_the_watchdog_bite(station))
        acquired = over_sockets(station, short, sink, progress.append)
        return Run(acquired, sink, progress, station, table_and_watchdog(station))


@pytest.fixture(params=["exact", pytest.param("real", marks=pytest.mark.real_time)])
def run(request: pytest.FixtureRequest) -> Run:
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


def test_a_rest_sets_the_chamber_and_the_unit_warms(short: Procedure, new_sink: Any) -> None:
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
