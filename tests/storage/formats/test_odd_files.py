"""Files that are not what their name says: one sentence, and nothing beside it."""

import json
import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO
from storage.formats import recordings


@pytest.fixture
def folder(tmp_path) -> Path:
    """A small recording as a folder with imu.csv."""
    t = np.arange(20) / 100
    table = pd.DataFrame({"t": t} | {name: t + k for k, name in enumerate(GYRO + ACCEL)})
    table.to_csv(tmp_path / "imu.csv", index=False)
    say(tmp_path, "imu.csv")
    return tmp_path


def say(folder: Path, stream: str) -> None:
    manifest = {
        "format": "mimu-recording/1",
        "recording_id": "small",
        "unit": {"manufacturer": "M", "model": "U", "serial": "1"},
        "station": {"id": "T1"},
        "streams": {"imu": stream},
    }
    (folder / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")


def refusal(path: Path) -> str:
    with pytest.raises(Unusable) as caught:
        recordings.read(path)
    sentence = str(caught.value)
    assert sentence.endswith(".")
    assert "\n" not in sentence
    return sentence


def test_parquet_named_csv_is_refused_quietly(folder, capfd):
    table = pd.read_csv(folder / "imu.csv")
    table.to_parquet(folder / "imu.csv")
    assert ".parquet" in refusal(folder)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("begins", [b"", b"t,gyro_x\n0,1\n"])
def test_binary_named_csv_is_refused_quietly(folder, seed, begins, capfd):
    noise = np.random.default_rng(seed).integers(0, 256, 5000, dtype=np.uint8).tobytes()
    (folder / "imu.csv").write_bytes(begins + noise)
    sentence = refusal(folder)
    assert "imu.csv" in sentence
    assert "UTF-8" in sentence
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("sign", "name"), [(";", "semicolons"), ("\t", "tabs")])
def test_other_separator_is_named(folder, sign, name):
    table = pd.read_csv(folder / "imu.csv")
    table.to_csv(folder / "imu.csv", index=False, sep=sign, decimal=",")
    sentence = refusal(folder)
    assert name in sentence
    assert "commas" in sentence
    assert "imu.csv" in sentence


@pytest.mark.parametrize("start", [b"", b"\xef\xbb\xbf", b"\n\n"])
@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_csv_of_any_system_is_read(folder, start, end):
    expected = recordings.read(folder).digest
    content = (folder / "imu.csv").read_bytes()
    (folder / "imu.csv").write_bytes((start + content).replace(b"\n", end))
    assert recordings.read(folder).digest == expected


def test_stream_whose_name_is_too_long_is_refused(folder):
    say(folder, "a" * 300 + ".csv")
    sentence = refusal(folder)
    assert "too long" in sentence
    assert len(sentence) < 300 + len(str(folder))


def test_links_in_a_circle_are_refused(folder):
    (folder / "imu.csv").unlink()
    (folder / "imu.csv").symlink_to("other.csv")
    (folder / "other.csv").symlink_to("imu.csv")
    assert "circle" in refusal(folder)


def test_pipe_is_not_waited_for(folder):
    (folder / "manifest.json").unlink()
    os.mkfifo(folder / "manifest.json")
    assert "pipe" in refusal(folder)
    os.mkfifo(folder / "imu.mcap")
    assert "pipe" in refusal(folder / "imu.mcap")


def test_path_that_is_too_long_is_refused(folder):
    assert "too long" in refusal(folder / ("a" * 300))


@pytest.mark.parametrize("sign", ["\0", "\x1b", "\x7f", "\x85", "\n"])
def test_control_character_in_a_text_is_refused_with_its_field(folder, sign):
    path = folder / "manifest.json"
    manifest = json.loads(path.read_text())
    manifest["unit"]["serial"] = f"A{sign}1"
    path.write_text(json.dumps(manifest))
    sentence = refusal(folder)
    assert "unit.serial" in sentence
    assert str(folder) in sentence
    assert sign not in sentence


def test_remark_may_have_several_lines_but_no_other_control_character(folder):
    path = folder / "manifest.json"
    manifest = json.loads(path.read_text())
    path.write_text(json.dumps(manifest | {"remark": "one\n\ttwo 三"}))
    assert recordings.read(folder)
    path.write_text(json.dumps(manifest | {"remark": "one\0"}))
    assert "remark" in refusal(folder)


def test_triads_that_are_null_throughout_are_refused_with_their_file(folder):
    table = pd.read_csv(folder / "imu.csv")
    table[[*GYRO, *ACCEL]] = np.nan
    table.to_csv(folder / "imu.csv", index=False)
    assert refusal(folder).startswith(f"{folder / 'imu.csv'}: ")
