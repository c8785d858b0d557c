"""A run on a virtual station: its name, and what is left when it breaks off."""

import os
import resource
import time
from pathlib import Path

import pytest

from schemas.base import BrokenOff, Unusable
from schemas.procedure import Procedure
from schemas.recording import Stream
from schemas.station import StationFile
from storage.catalogue import runs
from storage.formats.mcap import writer
from storage.formats.mcap.reader import read_mcap
from storage.home import Home
from tasks.stages import acquire, left_run
from tasks.stages.acquire import acquire_run
from tasks.stages.ready import ready_to_acquire
from tasks.station.stopping import StopSwitch
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.unit import draw_unit
from tests.tasks.station.in_memory import InMemoryStation

POSITION = {"kind": "position", "item": "twelve_position", "turn_deg": 0, "dwell_s": 6.0}
PROCEDURE = Procedure.model_validate({
    "format": "mimu-procedure/1", "name": "short", "title": "two positions", "title_zh": "两位置",
    "standard": "JJF 2003-2022", "warm_up_s": 1.0, "settle_s": 0.5, "move_rate_deg_s": 90.0,
    "acceleration_deg_s2": 120.0,
    "environment": {"temperature_degc": [15.0, 25.0], "humidity_percent": [20.0, 85.0]},
    "steps": [
        POSITION | {"name": "position_+z_000", "up": "+z", "angles_deg": [0, 0, 0]},
        POSITION | {"name": "position_-z_000", "up": "-z", "angles_deg": [0, 180, 0]},
    ],
})  # fmt: skip


@pytest.fixture
def station(monkeypatch: pytest.MonkeyPatch) -> StationFile:
    """A station in this process, acquired from in simulated time."""
    station = InMemoryStation(VirtualStation(unit=draw_unit(7)))
    monkeypatch.setattr(acquire, "acquire", station.run)
    return station.file


def named(station: StationFile, serial: str) -> StationFile:
    return station.model_copy(update={"unit": station.unit.model_copy(update={"serial": serial})})


def left_over(home: Home) -> list[Path]:
    return [path for path in home.acquiring.rglob("*") if path.is_file()]


def test_a_file_of_a_run_killed_before_its_readings_is_removed_by_the_next_one_and_no_other_is(
    station: StationFile, fresh: Home
) -> None:
    fresh.acquiring.mkdir(parents=True)
    ages = {"killed": 2 * left_run.EMPTY_S, "begins": 1.0}
    for name, age_s in ages.items():
        file = fresh.acquiring / f"{name}.mcap"
        file.touch()
        os.utime(file, (time.time() - age_s,) * 2)
    acquire_run(station, PROCEDURE, fresh, lambda _: None)
    assert [path.stem for path in left_over(fresh)] == ["begins"]


@pytest.mark.parametrize("serial", ["SN/1", "../../SN"])
def test_serial_is_in_the_recordings_name_and_in_no_files_name(
    station: StationFile, fresh: Home, serial: str
) -> None:
    acquired = acquire_run(named(station, serial), PROCEDURE, fresh, lambda _: None, operator="Sun")
    ((run, _),) = acquired.kept
    assert run.recording_id.startswith(f"{serial}-short-")
    assert run.serial == serial
    assert left_over(fresh) == []
    stated = runs.load(run, fresh).manifest.model_extra or {}
    assert stated["recorded_at"][-6] in "+-"  # the station's own day, with its offset
    assert stated["operator"] == "Sun"


def test_run_that_recorded_nothing_leaves_no_file_and_says_why(
    station: StationFile, fresh: Home, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.undo()  # it is looked for on the network
    table = station.table.model_copy(update={"url": "socket://127.0.0.1:1"})
    closed = station.model_copy(update={"table": table})
    with pytest.raises(Unusable) as refusal:
        acquire_run(closed, PROCEDURE, fresh, lambda _: None)
    assert "recorded so far" not in str(refusal.value)
    assert left_over(fresh) == []


def test_run_that_is_broken_off_says_where_its_recording_lies(
    station: StationFile, fresh: Home
) -> None:
    stop = StopSwitch()

    def report(progress: object) -> None:
        if getattr(progress, "station_s_done", 0.0) > 8.0:
            stop.press("its worker")

    with pytest.raises(BrokenOff, match="stopped by its worker") as end:
        acquire_run(station, PROCEDURE, fresh, report, stop=stop)
    (left,) = fresh.acquiring.iterdir()
    assert str(left) in str(end.value)
    assert "\n" not in str(end.value)
    assert len(read_mcap(left, salvage=True).imu)


def test_a_reader_of_the_progress_that_is_gone_costs_the_progress_alone(
    station: StationFile, fresh: Home
) -> None:
    def report(progress: object) -> None:
        raise BrokenPipeError(32, "Broken pipe")

    assert len(acquire_run(station, PROCEDURE, fresh, report).kept) == 1


def test_what_fails_beside_the_recording_is_not_called_a_recording_that_cannot_be_written(
    station: StationFile, fresh: Home, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(request: object) -> None:
        raise TimeoutError(110, "Connection timed out")

    monkeypatch.setattr(acquire, "acquire", away)
    with pytest.raises(BrokenOff, match=r"the run broke off \(Connection timed out\)"):
        acquire_run(station, PROCEDURE, fresh, lambda _: None)


def test_disk_that_is_full_is_one_sentence_and_keeps_what_was_written(
    station: StationFile, fresh: Home, monkeypatch: pytest.MonkeyPatch
) -> None:
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
            acquire_run(station, PROCEDURE, fresh, lambda _: None)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    (left,) = fresh.acquiring.iterdir()
    assert str(left) in str(end.value)
    assert len(read_mcap(left, salvage=True).imu)
