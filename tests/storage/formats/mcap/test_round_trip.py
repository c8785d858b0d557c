"""Raw recordings go to MCAP and back unchanged, also piece by piece as a run writes them."""

import os
import resource
import signal
import subprocess
import sys
import threading
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader

from schemas.base import Unusable
from schemas.recording import (
    ACCEL,
    ANGLE,
    FORMAT,
    GYRO,
    Manifest,
    Recording,
    Stream,
)
from storage.formats.content import canonical, digest
from storage.formats.folder import read_folder
from storage.formats.mcap.messages import ENVIRONMENT_TOPICS
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import RawWriter, write_mcap
from tests.shared import shared_path
from tests.storage.formats.mcap.small_recording import imu_stream, manifest, recording

# Raw recordings go to MCAP and back unchanged, and survive what happens to files.


def assert_same(one: Recording, other: Recording) -> None:
    """Bit for bit, NaN included."""
    assert one.manifest == other.manifest
    assert one.streams().keys() == other.streams().keys()
    for name, stream in one.streams().items():
        back = other.streams()[name]
        assert stream.t.tobytes() == back.t.tobytes()
        assert stream.columns.keys() == back.columns.keys()
        for column, values in stream.columns.items():
            assert values.tobytes() == back.columns[column].tobytes(), column


@pytest.mark.parametrize(
    "name", ["real/vn200_imu0_rate_table", "plant/plant_clean", "plant/ahrs_clean"]
)
def test_folder_and_its_mcap_are_the_same_recording(name, tmp_path):
    folder = read_folder(shared_path(f"data/{name}"))
    write_mcap(folder, tmp_path / "raw.mcap")
    back = read_mcap(tmp_path / "raw.mcap")
    assert folder.digest == back.digest == digest(folder)
    assert_same(folder, back)


def test_every_stream_and_column_comes_back_and_a_second_time_the_same_file(tmp_path):
    write_mcap(recording(), tmp_path / "one.mcap")
    back = read_mcap(tmp_path / "one.mcap")
    assert_same(canonical(recording()), back)
    assert back.digest == digest(recording())
    write_mcap(back, tmp_path / "two.mcap")
    assert (tmp_path / "one.mcap").read_bytes() == (tmp_path / "two.mcap").read_bytes()


@given(arrays(np.float64, 8, elements=st.floats(-1e300, 1e300, allow_subnormal=False)))
def test_conversion_to_ros_units_changes_a_number_at_most_once(values):
    for scalar in ENVIRONMENT_TOPICS:
        once = scalar.from_ros(scalar.to_ros(values))
        twice = scalar.from_ros(scalar.to_ros(once))
        assert once.tobytes() == twice.tobytes()
        assert np.allclose(once, values, rtol=1e-14, atol=0)


@given(st.decimals(0, 2000, places=4, allow_nan=False))
def test_decimal_number_comes_back_from_ros_units_as_it_was(value):
    for scalar in ENVIRONMENT_TOPICS:
        assert scalar.from_ros(scalar.to_ros(np.array([float(value)])))[0] == float(value)


@given(st.integers(0, 2**51))
def test_whole_nanoseconds_survive_as_seconds(stamp):
    stream = Stream(np.array([stamp / 1e9]), dict.fromkeys(GYRO + ACCEL, np.zeros(1)))
    assert canonical(Recording(manifest(), stream)).imu.t[0] == stamp / 1e9


def test_time_before_zero_comes_back(tmp_path):
    early = replace(recording(), imu=imu_stream(start=-0.02))
    write_mcap(early, tmp_path / "raw.mcap")
    assert_same(canonical(early), read_mcap(tmp_path / "raw.mcap"))


def test_what_is_absent_stays_absent(tmp_path):
    t = np.arange(5) / 10
    angles = Stream(t, {name: t + k for k, name in enumerate(ANGLE)})
    pose = Stream(t, dict.fromkeys(("qw", "qx", "qy", "qz"), t))
    small = Recording(manifest(), angles, Stream(t, {"outer_angle": t}), pose)
    write_mcap(small, tmp_path / "raw.mcap")
    back = read_mcap(tmp_path / "raw.mcap")
    assert set(back.imu.columns) == set(ANGLE)
    assert back.table is not None
    assert set(back.table.columns) == {"outer_angle"}
    assert back.reference is not None
    assert set(back.reference.columns) == {"qw", "qx", "qy", "qz"}
    assert back.environment is None


def test_file_is_a_ros_2_bag_with_summary_indexes_and_checksums(tmp_path):
    write_mcap(recording(), tmp_path / "raw.mcap")
    with (tmp_path / "raw.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == 300 * 2 + 100 + 100 + 4 * 100
        topics = {c.topic: summary.schemas[c.schema_id] for c in summary.channels.values()}
        assert topics["/imu/data"].name == "sensor_msgs/msg/Imu"
        assert all(schema.encoding == "ros2msg" for schema in topics.values())
        assert all(c.message_encoding == "cdr" for c in summary.channels.values())
        assert all(chunk.compression == "zstd" for chunk in summary.chunk_indexes)
        (record,) = reader.iter_metadata()
        assert record.name == FORMAT
        assert Manifest.model_validate_json(record.metadata["manifest"]) == manifest()
        times = [message.log_time for _, _, message in reader.iter_messages("/imu/data")]
        assert times == [10_000_000 * k for k in range(300)]
    with (tmp_path / "raw.mcap").open("rb") as file:
        assert len(list(StreamReader(file, validate_crcs=True).records)) > 1200


def test_nothing_is_left_beside_a_file_that_could_not_be_written(tmp_path):
    uneven = replace(recording(), table=Stream(np.arange(3.0), {"outer_angle": np.zeros(2)}))
    with pytest.raises(ValueError, match="rows"):
        write_mcap(uneven, tmp_path / "raw.mcap")
    assert not list(tmp_path.iterdir())


def test_each_row_of_a_long_recording_is_written_once_wherever_it_starts(tmp_path):
    t = np.round(0.39 + np.arange(30_000) / 10, 9)  # 2040.39 + 60 is not 0.39 + 35 × 60 in floats
    values = {name: np.sin(t + k) for k, name in enumerate(GYRO + ACCEL)}
    long = canonical(Recording(manifest(), Stream(t, values)))
    write_mcap(long, tmp_path / "raw.mcap")
    assert read_mcap(tmp_path / "raw.mcap").digest == digest(long)


# A recording that is written while it is made: on the disk soon, whatever happens then.


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
