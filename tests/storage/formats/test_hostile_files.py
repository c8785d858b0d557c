"""Files that lie about themselves: one short sentence each, and no memory for what they claim."""

import json
import struct
import tomllib
import zlib
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import zstandard
from mcap.opcode import Opcode

from schemas.base import Unusable
from schemas.tolerance import Tolerance
from storage import settings
from storage.formats import folder, recordings
from storage.formats.mcap.chunks import MAGIC, RECORD
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import write_mcap
from storage.whole_files import MAX_TEXT_BYTES
from tests.storage.formats.mcap.small_recording import manifest, recording

PAPER = Path("flows/demo_papers/tolerance.toml")
HUGE = (2**16, 2**31, 2**32 - 1, 2**40, 2**62, 2**63, 2**64 - 1)


def refusal(path: Path, *, salvage: bool = False) -> str:
    with pytest.raises(Unusable) as caught:
        recordings.read(path, salvage=salvage)
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert len(sentence) < 1000
    return sentence


def record(opcode: int, body: bytes) -> bytes:
    return RECORD.pack(opcode, len(body)) + body


def chunk(inside: bytes, size: int, compression: bytes, packed: bytes) -> bytes:
    head = struct.pack("<QQQI", 0, 1, size, zlib.crc32(inside))
    name = struct.pack("<I", len(compression)) + compression
    return record(Opcode.CHUNK, head + name + struct.pack("<Q", len(packed)) + packed)


def kept(folder: Path, data: bytes) -> Path:
    path = folder / "raw.mcap"
    path.write_bytes(MAGIC + data)
    return path


@pytest.mark.parametrize("size", HUGE)
@pytest.mark.parametrize("opcode", [Opcode.MESSAGE, Opcode.SCHEMA, 0x80])
def test_record_in_a_chunk_that_is_longer_than_the_chunk(tmp_path, opcode, size):
    inside = RECORD.pack(opcode, size) + bytes(40)
    data = chunk(inside, len(inside), b"", inside)
    for salvage in (False, True):
        assert "raw.mcap" in refusal(kept(tmp_path, data), salvage=salvage)


@pytest.mark.parametrize("size", HUGE)
@pytest.mark.parametrize("compression", [b"", b"zstd", b"lz4", b"rar"])
def test_chunk_that_lies_about_its_size(tmp_path, compression, size):
    inside = bytes(100)
    packed = zstandard.compress(inside) if compression == b"zstd" else inside
    assert "raw.mcap" in refusal(kept(tmp_path, chunk(inside, size, compression, packed)))


@pytest.mark.parametrize("size", HUGE[1:6])
def test_compressed_data_that_lie_about_their_size(tmp_path, size):
    frame = struct.pack("<IB", 0xFD2FB528, 0xE0) + struct.pack("<Q", size) + bytes(20)
    assert "raw.mcap" in refusal(kept(tmp_path, chunk(b"", 0, b"zstd", frame)))


@pytest.mark.parametrize("size", HUGE)
@pytest.mark.parametrize("opcode", list(Opcode))
def test_record_that_is_longer_than_the_file(tmp_path, opcode, size):
    assert "raw.mcap" in refusal(kept(tmp_path, RECORD.pack(opcode, size) + bytes(30)))


@pytest.mark.parametrize("opcode", list(Opcode))
@pytest.mark.parametrize("body", [b"", b"\xff", b"\xff" * 4, b"\xff" * 60])
def test_record_that_makes_no_sense(tmp_path, opcode, body):
    assert "raw.mcap" in refusal(kept(tmp_path, record(opcode, body)))


@pytest.mark.parametrize("seed", range(60))
def test_file_with_bytes_changed_at_random_is_read_or_refused(tmp_path, seed):
    write_mcap(recording(), tmp_path / "raw.mcap")
    random = np.random.default_rng(seed)
    data = np.frombuffer((tmp_path / "raw.mcap").read_bytes(), dtype=np.uint8).copy()
    places = random.integers(len(MAGIC), len(data), random.integers(1, 30))
    data[places] = random.choice([0, 0x7F, 0x80, 0xFF], len(places))
    (tmp_path / "raw.mcap").write_bytes(data.tobytes())
    try:
        saved = read_mcap(tmp_path / "raw.mcap", salvage=True)
    except Unusable:
        assert "raw.mcap" in refusal(tmp_path / "raw.mcap", salvage=True)
    else:
        assert len(saved.imu)


@pytest.mark.parametrize("origin", ["9" * 19, "9" * 30, "9" * 5000, "-1", "1e9", "", "²", "٣"])
def test_origin_that_cannot_be(tmp_path, origin):
    path = tmp_path / "raw.mcap"
    write_mcap(recording(), path)
    whole = path.read_bytes()
    length = struct.pack("<I", 1) + b"0"
    given = struct.pack("<I", len(origin.encode())) + origin.encode()
    at = whole.index(b"origin_ns") + len("origin_ns")
    assert whole[at : at + 5] == length
    start = whole.rindex(bytes([Opcode.METADATA]), 0, whole.index(b"mimu-recording/1") - 3)
    (size,) = struct.unpack_from("<Q", whole, start + 1)
    body = whole[start + 9 : at] + given + whole[at + 5 : start + 9 + size]
    grown = struct.pack("<I", struct.unpack_from("<I", body, 20)[0] + len(given) - 5)
    body = body[:20] + grown + body[24:]
    path.write_bytes(whole[:start] + record(Opcode.METADATA, body) + whole[start + 9 + size :])
    saved = read_mcap(path, salvage=True)
    assert len(saved.imu) == len(recording().imu)


@pytest.mark.parametrize("depth", [100, 950, 5_000, 100_000])
@pytest.mark.parametrize(("opens", "closes"), [("[", "]"), ('{"a":', "}")])
def test_manifest_that_is_nested_deep(tmp_path, opens, closes, depth):
    inner = opens * depth + "1" + closes * depth
    text = manifest().model_dump_json()[:-1] + f',"more":{inner}}}'
    (tmp_path / "manifest.json").write_text(text, encoding="utf-8")
    assert "manifest.json" in refusal(tmp_path)


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/urandom", "/dev/full", "/dev/tty"])
def test_device_is_not_read(tmp_path, device):
    assert "device" in refusal(Path(device))
    (tmp_path / "manifest.json").symlink_to(device)
    assert "device" in refusal(tmp_path)
    (tmp_path / "limits.toml").symlink_to(device)
    with pytest.raises(Unusable, match="device"):
        settings.read(tmp_path / "limits.toml", Tolerance)


def test_text_that_is_far_too_long_is_not_read(tmp_path):
    with (tmp_path / "manifest.json").open("wb") as file:
        file.truncate(MAX_TEXT_BYTES * 1000)
    assert "64 MB" in refusal(tmp_path)


@pytest.mark.parametrize("value", [1e308, -1e308, 1e10, 1e200])
@pytest.mark.parametrize("field", ["magnitude", "upper", "U_max", "min_capability"])
def test_limit_that_nothing_reaches(tmp_path, field, value):
    limit = {"item": "gyro_bias", "unit": "deg/s", "lower": -1.0, field: value}
    if field == "magnitude":
        del limit["lower"]
    path = tmp_path / "limits.json"
    fields = tomllib.loads(PAPER.read_text(encoding="utf-8")) | {"limits": [limit]}
    path.write_text(json.dumps(fields, default=str), encoding="utf-8")
    with pytest.raises(Unusable, match=field):
        settings.read(path, Tolerance)


def folder_with(folder: Path, stream: str) -> Path:
    fields = manifest().model_dump(mode="json") | {"streams": {"imu": stream}}
    (folder / "manifest.json").write_text(json.dumps(fields), encoding="utf-8")
    return folder


def test_csv_that_is_larger_than_the_memory_is_refused_unread(tmp_path):
    with (tmp_path / "imu.csv").open("wb") as file:
        file.write(b"t,gyro_x\n0,0\n")
        file.truncate(2**42)  # of holes: nothing on the disk
    assert "imu.csv needs 4398.0 GB of memory and the computer has" in refusal(
        folder_with(tmp_path, "imu.csv")
    )


def test_parquet_whose_few_bytes_hold_more_than_the_memory_is_refused_unread(tmp_path, monkeypatch):
    path = tmp_path / "imu.parquet"
    still = np.zeros(1_000_000)
    pq.write_table(pa.table({"t": still, "gyro_x": still}), path)
    assert path.stat().st_size < 100_000
    monkeypatch.setattr(folder, "memory_bytes", lambda: 20_000_000)
    assert "needs 0.0 GB of memory and the computer has 0.0 GB: split the recording" in refusal(
        folder_with(tmp_path, "imu.parquet")
    )
