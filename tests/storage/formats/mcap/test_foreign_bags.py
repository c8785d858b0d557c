"""ROS 2 bags of others, and the kinds of files that bags come in."""

import sqlite3
from pathlib import Path

import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType, Writer

from schemas.base import Unusable
from schemas.recording import Station
from storage.formats import recordings
from storage.formats.mcap.messages import IMU, JOINTS, TEMPERATURE, encode, schema_text
from storage.formats.mcap.reader import read_mcap
from tests.manifests import manifest_of
from tests.shared import shared_path

# ROS 2 bags of others: what they say is read, what they leave open is not guessed.

EPOCH = 1_700_000_000_123_456_789  # ns


class Bag:
    """A ROS 2 bag as others write it: the mcap package's own writer, message by message."""

    def __init__(self, path: Path, compression: CompressionType, chunked: bool) -> None:
        self.path = path
        self._file = path.open("wb")
        self._writer = Writer(self._file, 4096, compression, use_chunking=chunked)
        self._writer.start("ros2")
        self._channels: dict[str, int] = {}

    def add(self, topic: str, kind: str, stamp: int, frame: str = "link", **numbers: list) -> None:
        if topic not in self._channels:
            schema = self._writer.register_schema(kind, "ros2msg", schema_text(kind).encode())
            self._channels[topic] = self._writer.register_channel(topic, "cdr", schema)
        names = numbers.pop("name", None)
        texts = {"frame_id": (frame,)} | ({"name": tuple(names)} if names else {})
        clock = {"sec": [stamp // 10**9], "nanosec": [stamp % 10**9]}
        fields = {n: np.array([v]) for n, v in (numbers | clock).items()}
        message = encode(kind, fields, texts)[0].tobytes()
        self._writer.add_message(self._channels[topic], stamp + 5, message, stamp + 5)

    def imu(self, stamp: int, value: float, topic: str = "/imu", frame: str = "link") -> None:
        gyro, accel = [value, 0.0, 0.5], [0.0, value, 9.8]
        self.add(topic, IMU, stamp, frame, angular_velocity=gyro, linear_acceleration=accel)

    def close(self) -> Path:
        self._writer.finish()
        self._file.close()
        return self.path


@pytest.fixture
def bag(tmp_path) -> Bag:
    return Bag(tmp_path / "drive.mcap", CompressionType.ZSTD, chunked=True)


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunked", [True, False])
def test_bag_of_others_is_read(compression, chunked, tmp_path):
    bag = Bag(tmp_path / "drive.mcap", compression, chunked)
    for k in range(200):
        stamp = EPOCH + 10_000_001 * k
        bag.imu(stamp, k / 7, frame="link" if k % 3 else "another_link")
        bag.add("/joints", JOINTS, stamp + 3, name=["a", "b"], position=[k, 2.0 * k])
    back = read_mcap(bag.close())
    assert (np.rint(back.imu.t * 1e9) == 10_000_001 * np.arange(200)).all()
    assert (back.imu.columns["gyro_x"] == np.arange(200) / 7).all()
    assert (back.imu.columns["accel_z"] == 9.8).all()
    assert back.extra["left_out"] == ("/joints",)
    made = back.manifest
    assert (made.recording_id, made.standard, made.unit.serial) == ("drive", "other", "-")
    assert made.station == Station(id="unknown")


def test_given_manifest_names_the_joints_that_are_table_axes(bag):
    for k in range(9):
        bag.imu(EPOCH + 1000 * k, 1.0)
        bag.add("/joints", JOINTS, EPOCH + 1000 * k + 7, name=["z", "outer"], position=[9.0, k])
    table = read_mcap(bag.close(), manifest=manifest_of("small", axes={"outer": (0, 0, 1)})).table
    assert table is not None
    assert table.columns["outer_angle"].tolist() == list(range(9))
    assert table.t[0] == 7e-9


def test_temperature_at_the_stamps_of_the_imu_is_the_units_own(bag):
    for k in range(9):
        bag.imu(EPOCH + 1000 * k, 1.0)
        bag.add("/warm", TEMPERATURE, EPOCH + 1000 * k, temperature=[20.0 + k])
        bag.add("/room", TEMPERATURE, EPOCH + 1000 * k + 1, temperature=[20.0])
    back = read_mcap(bag.close())
    assert back.imu.columns["temperature"].tolist() == [20.0 + k for k in range(9)]
    assert back.extra["left_out"] == ("/room",)


def test_messages_are_put_in_the_order_of_their_stamps(bag):
    for k in (3, 1, 2, 0):
        bag.imu(EPOCH + k * 10**9, float(k))
    assert read_mcap(bag.close()).imu.columns["gyro_x"].tolist() == [0, 1, 2, 3]


def test_bag_that_counts_from_zero_keeps_its_time(bag):
    bag.imu(20_000_000, 1.0)
    bag.imu(30_000_000, 1.0)
    assert read_mcap(bag.close()).imu.t.tolist() == [0.02, 0.03]


def test_messages_with_one_stamp_are_refused(bag):
    for _ in range(2):
        bag.imu(EPOCH, 1.0)
    with pytest.raises(Unusable, match=r"/imu.*1700000000\.123456789"):
        read_mcap(bag.close())


def test_two_imu_topics_are_refused_by_name(bag):
    bag.imu(EPOCH, 1.0, "/left")
    bag.imu(EPOCH, 1.0, "/right")
    with pytest.raises(Unusable, match="/left, /right"):
        read_mcap(bag.close())


def test_bag_without_imu_is_refused_with_what_it_has(bag):
    bag.add("/warm", TEMPERATURE, EPOCH, temperature=[20.0])
    with pytest.raises(Unusable, match=r"/warm \(sensor_msgs/msg/Temperature\)"):
        read_mcap(bag.close())


def test_value_that_is_no_number_is_refused_with_its_row(bag):
    for k in range(3):
        bag.imu(EPOCH + k, np.inf if k == 1 else 1.0)
    with pytest.raises(Unusable, match=r"column gyro_x, row 2: the value is inf"):
        read_mcap(bag.close())


# Bags as ROS 2 keeps them: split, in SQLite, compressed, with stamps that were never set.

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
