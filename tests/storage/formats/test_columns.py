"""Columns keep a recording exactly; what cannot be a reading is refused."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from schemas.base import Unusable
from schemas.recording import ANGLE, Stream
from storage.formats.content import digest, read_columns, write_columns
from storage.formats.folder import read_folder
from storage.formats.manifest import check_columns, check_stream
from tests.manifests import manifest_of
from tests.shared import shared_path

# Columns keep a recording exactly, and appear whole or not at all.


@pytest.mark.parametrize(
    "name", ["real/vn200_imu0_rate_table", "plant/plant_clean", "plant/ahrs_clean"]
)
def test_columns_keep_every_number_and_the_digest(name, tmp_path):
    recording = read_folder(shared_path(f"data/{name}"))
    write_columns(recording, tmp_path / "columns")
    back = read_columns(tmp_path / "columns")
    assert back.digest == recording.digest == digest(back)
    assert back.streams().keys() == recording.streams().keys()
    for key, stream in recording.streams().items():
        assert stream.t.tobytes() == back.streams()[key].t.tobytes()
        for column, values in stream.columns.items():
            assert values.tobytes() == back.streams()[key].columns[column].tobytes()


def test_columns_are_a_recording_that_can_be_imported(tmp_path):
    recording = read_folder(shared_path("data/real/vn200_imu0_rate_table"))
    write_columns(recording, tmp_path / "columns")
    assert read_folder(tmp_path / "columns").digest == recording.digest


def test_columns_that_are_there_are_not_overwritten(tmp_path):
    recording = read_folder(shared_path("data/real/ferraris_session"))
    write_columns(recording, tmp_path / "columns")
    with pytest.raises(FileExistsError):
        write_columns(recording, tmp_path / "columns")
    assert [path.name for path in tmp_path.iterdir()] == ["columns"]


@pytest.mark.parametrize("missing", ["manifest.json", "imu.parquet"])
def test_columns_with_a_file_missing_are_refused(missing, tmp_path):
    write_columns(read_folder(shared_path("data/real/ferraris_session")), tmp_path / "columns")
    (tmp_path / "columns" / missing).unlink()
    with pytest.raises(Unusable, match="not whole"):
        read_columns(tmp_path / "columns")


def flipped(column: np.ndarray) -> np.ndarray:
    bits = column.copy().view(np.uint64)
    bits[777] ^= 1
    return bits.view(float)


def pages_swapped(column: np.ndarray) -> np.ndarray:
    return np.concatenate([column[512:1024], column[:512], column[1024:]])


@pytest.mark.parametrize("damage", [flipped, pages_swapped])
def test_columns_that_were_changed_since_are_refused(damage, tmp_path):
    write_columns(read_folder(shared_path("data/plant/plant_clean")), tmp_path / "columns")
    path = tmp_path / "columns" / "imu.parquet"
    table = pq.read_table(path)
    place = table.column_names.index("gyro_x")
    changed = pa.chunked_array([damage(table.column(place).to_numpy())])
    pq.write_table(table.set_column(place, table.field(place), changed), path)
    with pytest.raises(Unusable, match="not what was written"):
        read_columns(tmp_path / "columns")


def test_columns_of_two_recordings_are_refused(tmp_path):
    write_columns(read_folder(shared_path("data/plant/plant_clean")), tmp_path / "one")
    write_columns(read_folder(shared_path("data/plant/plant_unlisted")), tmp_path / "two")
    (tmp_path / "one" / "table.parquet").replace(tmp_path / "two" / "table.parquet")
    with pytest.raises(Unusable, match="different recordings"):
        read_columns(tmp_path / "two")


# What no sensor can have read is refused, with the file, the column and the row.

MANIFEST = manifest_of("r")


@pytest.mark.parametrize("value", [1.1e9, -1e300])
def test_a_reading_beyond_every_sensor_is_refused(value):
    columns = {name: np.zeros(5) for name in ANGLE}
    columns["angle_y"][3] = value
    with pytest.raises(Unusable, match=r"here: column angle_y, row 4: .* no sensor reads"):
        check_stream("here", "imu", Stream(np.arange(5.0), columns))


def test_large_turns_and_pressures_are_readings():
    columns = {name: np.full(5, 1e6) for name in ANGLE}
    check_stream("here", "imu", Stream(np.arange(5.0), columns))
    check_stream("here", "environment", Stream(np.arange(5.0), {"pressure": np.full(5, 1.1e5)}))


def test_the_angle_that_is_missing_is_named():
    with pytest.raises(Unusable, match="column angle_z is missing"):
        check_columns("here", "imu", MANIFEST, {"angle_x", "angle_y"})
