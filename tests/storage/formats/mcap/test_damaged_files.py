"""A raw file that is cut off or damaged is refused, and gives what is whole when asked."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from schemas.base import Unusable
from storage.formats.folder import read_folder
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import write_mcap
from tests.shared import shared_path

FOLDER = "data/real/vn200_57630_six_position"


@pytest.fixture
def long_file(tmp_path) -> Path:
    """Eight minutes, so that there are several chunks of each topic."""
    write_mcap(read_folder(shared_path(FOLDER)), tmp_path / "long.mcap")
    return tmp_path / "long.mcap"


@pytest.mark.parametrize("share", [0.4, 0.7, 0.95])
def test_file_that_is_cut_off_gives_what_is_whole(long_file, share):
    whole = read_mcap(long_file)
    data = long_file.read_bytes()
    long_file.write_bytes(data[: int(share * len(data))])
    with pytest.raises(Unusable, match="cut off") as refusal:
        read_mcap(long_file)
    saved = read_mcap(long_file, salvage=True)
    assert 0 < len(saved.imu) <= len(whole.imu)
    assert "--salvage" in str(refusal.value)
    assert saved.manifest == whole.manifest
    rows = np.searchsorted(whole.imu.t, saved.imu.t)
    for column, values in saved.imu.columns.items():
        assert (values == whole.imu.columns[column][rows]).all()


def test_flipped_byte_is_found_wherever_it_is_and_the_rest_is_saved(long_file):
    data = long_file.read_bytes()
    with long_file.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    for chunk in summary.chunk_indexes[::3]:
        flipped = bytearray(data)
        flipped[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 0x10
        long_file.write_bytes(flipped)
        with pytest.raises(Unusable, match="damaged"):
            read_mcap(long_file)
        assert len(read_mcap(long_file, salvage=True).imu) > 4_000


def test_changed_manifest_is_found(long_file):
    data = long_file.read_bytes()
    long_file.write_bytes(data.replace(b'"serial":"0100057630"', b'"serial":"0100057631"', 1))
    with pytest.raises(Unusable, match="damaged"):
        read_mcap(long_file)


def test_last_manifest_that_is_whole_is_taken(long_file):
    data = long_file.read_bytes()
    long_file.write_bytes(data.replace(b'{"format":"mimu', b'("format":"mimu', 1))
    with pytest.raises(Unusable, match="damaged"):
        read_mcap(long_file)
    saved = read_mcap(long_file, salvage=True)
    assert saved.manifest.recording_id == "long"
    assert len(saved.imu) == 9006


@pytest.mark.parametrize("content", [b"", b"not MCAP at all", b"\x89MCAP0\r\n"])
def test_file_without_any_message_is_refused(content, tmp_path):
    path = tmp_path / "raw.mcap"
    path.write_bytes(content)
    for salvage in (False, True):
        with pytest.raises(Unusable, match=r"raw\.mcap") as refusal:
            read_mcap(path, salvage=salvage)
        assert "\n" not in str(refusal.value)


def test_file_that_is_cut_off_before_its_first_chunk_says_the_way_out(long_file):
    content = long_file.read_bytes()
    long_file.write_bytes(content[:60])
    for salvage in (False, True):
        assert "copy it again" in refusal_of(long_file, salvage)


def test_missing_file_and_folder_are_refused(tmp_path):
    for path in (tmp_path, tmp_path / "nowhere.mcap"):
        with pytest.raises(Unusable, match=str(path)):
            read_mcap(path)


def refusal_of(path: Path, salvage: bool) -> str:
    """What the reader says against a file, or nothing."""
    try:
        read_mcap(path, salvage=salvage)
    except Unusable as refusal:
        return str(refusal)
    return ""


@pytest.fixture(scope="module")
def content(tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("whole") / "raw.mcap"
    write_mcap(read_folder(shared_path(FOLDER)), path)
    return path.read_bytes()


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_no_damage_ends_in_a_traceback(content, tmp_path_factory, data):
    path = tmp_path_factory.mktemp("damage") / "raw.mcap"
    damaged = bytearray(content)
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(damaged[: data.draw(st.integers(1, len(damaged)))])
    for salvage in (False, True):
        assert "\n" not in refusal_of(path, salvage)
