"""A run on a virtual station: its name, and what is left when it breaks off."""

import os
import resource
import time
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from schemas.base import BrokenOff, Unusable
from schemas.procedure import Procedure
from schemas.recording import MEASURED, Recording, Stream
from schemas.station import StationFile
from storage.catalogue import runs
from storage.formats.mcap import writer
from storage.formats.mcap.reader import has_readings, read_mcap
from storage.formats.mcap.writer import RawWriter
from storage.home import Home
from storage.stations import statuses
from tasks.stages import acquire
from tasks.stages.acquire import acquire_run, status_file
from tasks.stages.store import ready_to_acquire
from tasks.station import procedures
from tasks.station.acquisition import Progress
from tasks.station.connected_station import StopSwitch
from tasks.station.virtual.config import VirtualStation, draw_unit, station_file
from tasks.station.virtual.faults import StationFault
from tests.tasks.station.in_memory import InMemoryStation

POSITION_ACQUIRE = {"kind": "position", "item": "twelve_position", "turn_deg": 0, "dwell_s": 6.0}
PROCEDURE_ACQUIRE = Procedure.model_validate({
    "format": "mimu-procedure/1", "name": "short", "title": "two positions", "title_zh": "两位置",
    "standard": "JJF 2003-2022", "warm_up_s": 1.0, "settle_s": 0.5, "move_rate_deg_s": 90.0,
    "acceleration_deg_s2": 120.0,
    "environment": {"temperature_degc": [15.0, 25.0], "humidity_percent": [20.0, 85.0]},
    "steps": [
        POSITION_ACQUIRE | {"name": "position_+z_000", "up": "+z", "angles_deg": [0, 0, 0]},
        POSITION_ACQUIRE | {"name": "position_-z_000", "up": "-z", "angles_deg": [0, 180, 0]},
    ],
})  # fmt: skip


@pytest.fixture
def station(monkeypatch) -> StationFile:
    """A station in this process, acquired from in simulated time."""
    station = InMemoryStation(VirtualStation(unit=draw_unit(7)))
    monkeypatch.setattr(acquire, "acquire", station.run)
    return station.file


def named(station: StationFile, serial: str) -> StationFile:
    return station.model_copy(update={"unit": station.unit.model_copy(update={"serial": serial})})


def left_over(home: Home) -> list[Path]:
    return [path for path in home.acquiring.rglob("*") if path.is_file()]


def test_a_file_of_a_run_killed_before_its_readings_is_removed_by_the_next_one_and_no_other_is(
    station, fresh
):
    fresh.acquiring.mkdir(parents=True)
    ages = {"killed": 2 * acquire.EMPTY_S, "begins": 1.0}
    for name, age_s in ages.items():
        file = fresh.acquiring / f"{name}.mcap"
        file.touch()
        os.utime(file, (time.time() - age_s,) * 2)
    acquire_run(station, PROCEDURE_ACQUIRE, fresh, lambda _: None)
    assert [path.stem for path in left_over(fresh)] == ["begins"]


@pytest.mark.parametrize("serial", ["SN/1", "../../SN"])
def test_serial_is_in_the_recordings_name_and_in_no_files_name(station, fresh, serial):
    acquired = acquire_run(
        named(station, serial), PROCEDURE_ACQUIRE, fresh, lambda _: None, operator="Sun"
    )
    ((run, _),) = acquired.kept
    assert run.recording_id.startswith(f"{serial}-short-")
    assert run.serial == serial
    assert left_over(fresh) == []
    stated = runs.load(run, fresh).manifest.model_extra or {}
    assert stated["recorded_at"][-6] in "+-"  # the station's own day, with its offset
    assert stated["operator"] == "Sun"


def test_run_that_recorded_nothing_leaves_no_file_and_says_why(station, fresh, monkeypatch):
    monkeypatch.undo()  # it is looked for on the network
    table = station.table.model_copy(update={"url": "socket://127.0.0.1:1"})
    closed = station.model_copy(update={"table": table})
    with pytest.raises(Unusable) as refusal:
        acquire_run(closed, PROCEDURE_ACQUIRE, fresh, lambda _: None)
    assert "recorded so far" not in str(refusal.value)
    assert left_over(fresh) == []


def test_run_that_is_broken_off_says_where_its_recording_lies(station, fresh):
    stop = StopSwitch()

    def report(progress: object) -> None:
        if getattr(progress, "station_s_done", 0.0) > 8.0:
            stop.press("its worker")

    with pytest.raises(BrokenOff, match="stopped by its worker") as end:
        acquire_run(station, PROCEDURE_ACQUIRE, fresh, report, stop=stop)
    (left,) = fresh.acquiring.iterdir()
    assert str(left) in str(end.value)
    assert "\n" not in str(end.value)
    assert len(read_mcap(left, salvage=True).imu)


def test_a_reader_of_the_progress_that_is_gone_costs_the_progress_alone(station, fresh):
    def report(progress: object) -> None:
        raise BrokenPipeError(32, "Broken pipe")

    assert len(acquire_run(station, PROCEDURE_ACQUIRE, fresh, report).kept) == 1


def test_disk_that_is_full_is_one_sentence_and_keeps_what_was_written(station, fresh, monkeypatch):
    append = writer.RawWriter.append

    def and_let_it_be_written(raw: writer.RawWriter, name: str, stream: Stream) -> None:
        append(raw, name, stream)
        time.sleep(0.03)

    # Simulated time is over before the disk is given anything: it is asked after each piece.
    monkeypatch.setattr(writer, "PERIOD", 0.01)
    monkeypatch.setattr(writer.RawWriter, "append", and_let_it_be_written)
    ready_to_acquire("T1", fresh)  # the catalogue is there before the disk is full
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (150_000, before[1]))
    try:
        with pytest.raises(BrokenOff, match="could not be written") as end:
            acquire_run(station, PROCEDURE_ACQUIRE, fresh, lambda _: None)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    (left,) = fresh.acquiring.iterdir()
    assert str(left) in str(end.value)
    assert len(read_mcap(left, salvage=True).imu)


# A run that was interrupted goes on as the same run.

PLACES = {"+z": [0, 0, 0], "-z": [0, 180, 0], "+y": [0, 90, 0], "-y": [0, 270, 0]}
FOUR = PROCEDURE_ACQUIRE.model_validate(
    PROCEDURE_ACQUIRE.model_dump()
    | {
        "steps": [
            POSITION_ACQUIRE | {"name": f"position_{up}_000", "up": up, "angles_deg": angles}
            for up, angles in PLACES.items()
        ]
    }
)
LOOKS = 3
NAMES = [f"position_{up}_000" for up in PLACES]


class Bench:
    """Runs on a station in this process; `restart` switches the station off and on."""

    speed = 20.0

    def __init__(self, home: Home, monkeypatch: pytest.MonkeyPatch) -> None:
        self.home, self._monkeypatch = home, monkeypatch
        self.begun: list[str] = []
        self.restart()

    def restart(self) -> None:
        self.use(VirtualStation(unit=draw_unit(7)))

    def use(self, config: VirtualStation, faults: Iterable[StationFault] = ()) -> None:
        self.station = InMemoryStation(config, speed=self.speed, faults=faults)
        self._monkeypatch.setattr(acquire, "acquire", self.station.run)

    def acquire(self, until: str = "", resume: bool = False, by: str = "Sun") -> Recording:
        """until: the segment in which the operator ends it, when the data before it are there."""
        self.begun.clear()
        looks = 0

        def report(progress) -> None:
            nonlocal looks
            if progress.now not in self.begun:
                self.begun.append(progress.now)
            looks += bool(until) and progress.now.startswith(until)
            if looks == LOOKS:
                raise KeyboardInterrupt

        made = acquire_run(self.station.file, FOUR, self.home, report, resume=resume, operator=by)
        ((run, _),) = made.kept
        return runs.load(run, self.home)

    def interrupt(self, until: str, resume: bool = False) -> Path:
        with pytest.raises(BrokenOff, match="--resume"):
            self.acquire(until, resume)
        (left,) = self.home.acquiring.glob("*.mcap")
        return left


@pytest.fixture
def bench(tmp_path, monkeypatch) -> Bench:
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    return Bench(Home(tmp_path / "home"), monkeypatch)


def measured(recording: Recording) -> list[str]:
    return [s.name for s in recording.manifest.segments or () if s.kind in MEASURED]


def assert_whole(recording: Recording) -> None:
    """Every segment with all of its samples, and nothing twice."""
    assert (np.diff(recording.imu.t) > 0).all()
    for segment in recording.manifest.segments or ():
        if segment.kind in MEASURED:
            for stream in (recording.imu, recording.table):
                t = stream.t[stream.rows(segment.t_start, segment.t_end)]
                assert np.diff(t) == pytest.approx(0.01, abs=1e-9)
            assert segment.t_end - segment.t_start == pytest.approx(6.0)


def test_it_goes_on_at_the_first_missing_segment_as_one_run(bench):
    bench.speed = 5.0  # so that little is lost while the operator ends it
    bench.restart()
    left = bench.interrupt("position +y")
    first = read_mcap(left, salvage=True)
    killed = left.with_name("killed.mcap")  # as it went on
    with RawWriter(killed) as again:
        again.manifest(first.manifest)
    killed.write_bytes(killed.read_bytes()[:-100])
    assert not has_readings(killed)
    whole = bench.acquire(resume=True, by="Qian")
    assert (whole.manifest.model_extra or {})["operator"] == "Sun; Qian"
    positions = [name for name in bench.begun if name.startswith("position")]
    assert positions == ["position +y 000", "position -y 000"]
    assert measured(whole) == NAMES
    assert_whole(whole)
    assert whole.manifest.recording_id == first.manifest.recording_id
    assert whole.imu.t[: len(first.imu)] == pytest.approx(first.imu.t, abs=0)
    assert list(bench.home.acquiring.glob("*.mcap")) == []
    parts = whole.manifest.model_extra["parts"]
    assert [part["t_start"] for part in parts] == [0.0, pytest.approx(first.imu.t[-1], abs=1.0)]


@pytest.mark.parametrize("end_s", [10.0, 18.0, 30.0])
def test_a_segment_whose_data_a_power_cut_took_is_measured_again(bench, end_s):
    left = bench.interrupt("position -y")
    recording = read_mcap(left, salvage=True)
    left.unlink()
    with RawWriter(left) as cut:
        cut.manifest(recording.manifest)
        for name, stream in recording.streams().items():
            cut.append(name, stream.at(stream.t < end_s))
    whole = bench.acquire(resume=True)
    assert sorted(measured(whole)) == sorted(NAMES)
    assert_whole(whole)


def test_the_station_may_have_been_restarted_and_the_run_broken_off_again(bench):
    bench.interrupt("position -z")
    bench.restart()
    bench.interrupt("position -y", resume=True)
    bench.restart()
    whole = bench.acquire(resume=True)
    assert measured(whole) == NAMES
    assert_whole(whole)
    assert len(whole.manifest.model_extra["parts"]) == 3


def test_where_no_run_was_interrupted_it_is_refused_with_the_way_out(bench):
    with pytest.raises(Unusable, match="without --resume"):
        bench.acquire(resume=True)


def test_a_unit_that_was_given_up_is_measured_to_the_end_later_and_alone(bench):
    config = VirtualStation(unit=draw_unit(7), neighbours=(draw_unit(8),))
    bench.use(config, [StationFault("unit_silent", 12.0)])
    made = acquire_run(bench.station.file, FOUR, bench.home, lambda _: None)
    ((run, acquired),) = made.kept
    assert measured(runs.load(run, bench.home)) == NAMES
    assert (run.serial, acquired.given_up) == ("V00008", None)
    (sentence,) = made.given_up
    (left,) = bench.home.acquiring.glob("*.mcap")
    assert "unit V00007 was given up: the unit on" in str(sentence)
    assert f"recorded so far: {left} (`mimucal acquire --resume`" in str(sentence)
    bench.use(config)
    again = acquire_run(bench.station.file, FOUR, bench.home, lambda _: None, resume=True)
    ((other, _),) = again.kept
    assert other.serial == "V00007"
    assert measured(runs.load(other, bench.home)) == NAMES
    assert_whole(runs.load(other, bench.home))
    assert list(bench.home.acquiring.glob("*.mcap")) == []


# The status that a run keeps while it is acquired.

STATION = station_file(VirtualStation(), 1.0, "nowhere", 1, 2)
PROCEDURE_RUN_STATUS = procedures.load("jjf2003")
TURNING = Progress("rate x", 10.0, 20.0, 5.0, "measuring", 3, 4, {"imu": 100.0}, {"gyro": 0.1})


def test_it_stands_as_the_run_and_then_as_its_end(tmp_path):
    home, reported = Home(tmp_path), []
    with status_file(STATION, PROCEDURE_RUN_STATUS, home, reported.append) as report:
        assert statuses(home)[0][0].state == "begun"
        report(TURNING)
        ((status, _),) = statuses(home)
    assert reported == [TURNING]
    assert (status.state, status.now, status.segment) == ("measuring", "rate x", 3)
    assert (status.rates_hz, status.noise) == ({"imu": 100.0}, {"gyro": 0.1})
    assert status.began_at <= status.at
    assert statuses(home)[0][0].state == "done"


def test_a_run_is_not_done_before_its_recording_is_in_the_store(tmp_path):
    home = Home(tmp_path)
    with status_file(STATION, PROCEDURE_RUN_STATUS, home, lambda _: None) as report:
        report(Progress("done", 20.0, 20.0, 0.0, "done", 4, 4))
        assert statuses(home)[0][0].state == "finishing"


def test_what_ends_a_run_is_its_cause(tmp_path):
    home = Home(tmp_path)
    with (
        pytest.raises(KeyboardInterrupt),
        status_file(STATION, PROCEDURE_RUN_STATUS, home, lambda _: None),
    ):
        raise KeyboardInterrupt
    ((status, is_dead),) = statuses(home)
    assert (status.state, status.cause, is_dead) == ("stopped", "KeyboardInterrupt", False)
