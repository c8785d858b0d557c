"""Bags as ROS 2 keeps them: split, in SQLite, compressed, with stamps that were never set."""

import sqlite3
from pathlib import Path

import numpy as np
import pytest
import zstandard

from schemas.base import Unusable
from storage.formats import recordings
from storage.formats.mcap.messages import IMU, encode
from tests.shared import shared_path

NANO = 1_000_000_000


def database(path: Path, rows: int, *, packed: bool = False) -> None:
    """A bag as rosbag2_storage_sqlite3 lays it out, with 100 messages a second."""
    stamps = 1_700_000_000 * NANO + np.arange(rows) * NANO // 100
    numbers = {
        "sec": stamps[:, None] // NANO, "nanosec": stamps[:, None] % NANO,
        "angular_velocity": np.arange(3.0 * rows).reshape(rows, 3),
        "linear_acceleration": np.full((rows, 3), 9.8),
    }  # fmt: skip
    block = encode(IMU, numbers, {"frame_id": ("imu",)})
    pack = zstandard.ZstdCompressor().compress if packed else bytes
    with sqlite3.connect(path) as store:
        store.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, "
                      "serialization_format TEXT, offered_qos_profiles TEXT)")  # fmt: skip
        store.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, "
                      "timestamp INTEGER, data BLOB)")  # fmt: skip
        store.execute("INSERT INTO topics VALUES(1, '/imu', 'sensor_msgs/msg/Imu', 'cdr', '')")
        store.executemany(
            "INSERT INTO messages(topic_id, timestamp, data) VALUES(1, ?, ?)",
            [(int(t), pack(row.tobytes())) for t, row in zip(stamps, block, strict=True)],
        )
    store.close()


@pytest.mark.parametrize("packed", [False, True])
def test_a_database_is_read_with_messages_packed_or_not(tmp_path, packed):
    database(tmp_path / "bag_0.db3", 300, packed=packed)
    imu = recordings.read(tmp_path / "bag_0.db3").imu
    np.testing.assert_allclose(imu.t, np.arange(300) / 100)
    np.testing.assert_allclose(imu.columns["gyro_y"], 3.0 * np.arange(300) + 1.0)


def test_a_database_without_a_bags_tables_is_one_sentence(tmp_path):
    with sqlite3.connect(tmp_path / "other.db3") as store:
        store.execute("CREATE TABLE notes(id INTEGER)")
    store.close()
    with pytest.raises(Unusable, match="ros2 bag convert"):
        recordings.read(tmp_path / "other.db3")


def test_a_bag_that_lacks_a_part_names_it(tmp_path):
    database(tmp_path / "bag_0.db3", 10)
    (tmp_path / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  relative_file_paths: [bag_0.db3, bag_1.db3]\n"
    )
    with pytest.raises(Unusable, match=r"bag_1\.db3, which is not there"):
        recordings.read(tmp_path)


@pytest.mark.parametrize(
    ("name", "rows"), [("split", 6000), ("sqlite3", 2000), ("file_zstd", 2000)]
)
def test_bags_from_the_field_are_one_run(name, rows):
    imu = recordings.read(shared_path(f"data/field/bags/{name}")).imu
    assert len(imu) == rows
    np.testing.assert_allclose(np.diff(imu.t), 0.01, atol=1e-6)


def test_stamps_that_were_never_set_are_named_and_the_times_of_recording_offered():
    bag = shared_path("data/field/bags/stamps_never_set.mcap")
    with pytest.raises(Unusable, match=r"never set.*--stamps log"):
        recordings.read(bag)
    assert len(recordings.read(bag, by_log_time=True).imu) == 3000
