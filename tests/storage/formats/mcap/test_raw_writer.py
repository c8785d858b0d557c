"""A recording that is written while it is made: on the disk soon, whatever happens then."""

import os
import resource
import signal
import subprocess
import sys
import threading
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest
from mcap.reader import make_reader

from schemas.base import Unusable
from storage.formats.content import digest
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import RawWriter, write_mcap
from tests.storage.formats.mcap.small_recording import imu_stream, manifest, recording


def test_rows_given_piece_by_piece_are_one_recording(tmp_path):
    whole = recording()
    with RawWriter(tmp_path / "raw.mcap") as writer:
        writer.manifest(manifest().model_copy(update={"recording_id": "not yet known"}))
        for name, stream in whole.streams().items():
            for start in range(0, len(stream), 90):
                rows = slice(start, start + 90)
                writer.append(name, stream.at(rows))
        writer.manifest(manifest())
    assert read_mcap(tmp_path / "raw.mcap").digest == digest(whole)


def test_raw_recording_is_written_only_once(tmp_path):
    RawWriter(tmp_path / "raw.mcap").close()
    with pytest.raises(FileExistsError):
        RawWriter(tmp_path / "raw.mcap")


def test_time_before_zero_is_refused_when_given_and_the_rest_is_kept(tmp_path):
    with RawWriter(tmp_path / "raw.mcap") as writer:
        writer.append("imu", imu_stream())
        with pytest.raises(Unusable, match="time before zero"):
            writer.append("imu", imu_stream(start=-5))
    assert len(read_mcap(tmp_path / "raw.mcap").imu) == 300


def test_fault_of_the_disk_is_raised_by_a_later_call(tmp_path):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    writer = RawWriter(tmp_path / "raw.mcap")
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        writer.append("imu", imu_stream(5000))
        with pytest.raises(OSError, match="File too large"):
            writer.close()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_disk_that_keeps_rows_waiting_is_said_and_nothing_given_is_lost(tmp_path, monkeypatch):
    now, is_stuck, goes_on = [0.0], threading.Event(), threading.Event()

    def stuck(descriptor: int) -> None:
        is_stuck.set()
        goes_on.wait()

    writer = RawWriter(tmp_path / "raw.mcap", clock=lambda: now[0])
    monkeypatch.setattr(os, "fsync", stuck)
    writer.append("imu", imu_stream(50))
    is_stuck.wait()
    now[0] = 9.0
    writer.append("imu", imu_stream(50, start=50))
    now[0] = 11.0
    with pytest.raises(OSError, match="has not taken what was recorded for 10 s"):
        writer.append("imu", imu_stream(50, start=100))
    goes_on.set()
    writer.close()
    assert len(read_mcap(tmp_path / "raw.mcap").imu) == 100


ACQUIRED = datetime(2026, 3, 1, 8, 30, tzinfo=UTC)


@pytest.mark.parametrize("acquired_at", ["2026-03-01T08:30:00+00:00", "2026-03-01T16:30:00+08:00"])
def test_stamps_are_of_the_day_that_the_manifest_tells(tmp_path, acquired_at):
    whole = replace(
        recording(), manifest=manifest().model_copy(update={"acquired_at": acquired_at})
    )
    with RawWriter(tmp_path / "raw.mcap") as writer:
        writer.manifest(whole.manifest)
        for name, stream in whole.streams().items():
            writer.append(name, stream)
    write_mcap(whole, tmp_path / "kept.mcap")
    for name in ("raw.mcap", "kept.mcap"):
        with (tmp_path / name).open("rb") as file:
            summary = make_reader(file).get_summary()
        assert summary.statistics.message_start_time == round(
            (ACQUIRED.timestamp() + whole.imu.t[0]) * 1e9
        )
        assert read_mcap(tmp_path / name).digest == digest(whole)


@pytest.mark.parametrize(
    "acquired_at", ["2026-03-01T08:30:00", "yesterday", 5, "9999-12-31T00:00:00Z"]
)
def test_a_day_that_is_none_leaves_the_stamps_as_they_were(tmp_path, acquired_at):
    whole = replace(
        recording(), manifest=manifest().model_copy(update={"acquired_at": acquired_at})
    )
    write_mcap(whole, tmp_path / "raw.mcap")
    read = read_mcap(tmp_path / "raw.mcap")
    assert read.digest == digest(whole)
    assert (read.imu.t == whole.imu.t).all()


KILLED = """
import sys, time
import numpy as np
from pathlib import Path
from schemas.recording import ACCEL, FORMAT, GYRO, Manifest, Station, Stream, Unit
from storage.formats.mcap.writer import RawWriter
writer = RawWriter(Path(sys.argv[1]))
unit = Unit(manufacturer="M", model="U", serial="1")
writer.manifest(Manifest(format=FORMAT, recording_id="cut", unit=unit, station=Station(id="T1")))
t = np.arange(500) / 100
writer.append("imu", Stream(t, {name: t for name in GYRO + ACCEL}))
time.sleep(1.5)
print("given", flush=True)
time.sleep(60)
"""


def test_rows_are_on_the_disk_when_the_process_is_killed(tmp_path):
    path = tmp_path / "raw.mcap"
    command = [sys.executable, "-c", KILLED, str(path)]
    here = os.environ | {"PYTHONPATH": str(Path.cwd())}
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=here) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"given\n"
        process.send_signal(signal.SIGKILL)
    with pytest.raises(Unusable, match=r"500 samples up to t = 4\.990 s are whole.*--salvage"):
        read_mcap(path)
    saved = read_mcap(path, salvage=True)
    assert len(saved.imu) == 500
    assert saved.manifest.recording_id == "cut"
