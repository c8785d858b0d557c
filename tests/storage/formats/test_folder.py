"""What the exchange format allows is read; everything else is refused with one sentence."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from schemas.base import Unusable
from schemas.recording import ACCEL, ANGLE, GYRO
from storage.formats.folder import read_folder
from tests.shared import shared_path

ROWS = 20

Change = Callable[[dict, dict[str, pd.DataFrame]], None]


def manifest() -> dict:
    return {
        "format": "mimu-recording/1",
        "recording_id": "small",
        "unit": {"manufacturer": "M", "model": "U", "serial": "1"},
        "station": {"id": "T1", "table_axes": [{"name": "outer", "direction": [0, 0, 1]}]},
        "streams": {"imu": "imu.csv", "table": "table.csv", "environment": "environment.csv"},
    }


def frames() -> dict[str, pd.DataFrame]:
    t = np.arange(ROWS) / 100
    imu = pd.DataFrame({"t": t} | {name: t + k for k, name in enumerate(GYRO + ACCEL)})
    return {
        "imu": imu,
        "table": pd.DataFrame({"t": t, "outer_angle": 2 * t}),
        "environment": pd.DataFrame({"t": [0.0, 0.1], "humidity": [45.1, 45.2]}),
    }


def write(folder: Path, change: Change = lambda m, f: None, suffix: str = "csv") -> Path:
    """A small recording with one thing changed, as a folder."""
    text, tables = manifest(), frames()
    if suffix == "parquet":
        text["streams"] = {name: f"{name}.parquet" for name in tables}
    change(text, tables)
    folder.mkdir(exist_ok=True)
    for name, table in tables.items():
        if suffix == "parquet":
            table.to_parquet(folder / f"{name}.parquet")
        else:
            table.to_csv(folder / f"{name}.csv", index=False)
    (folder / "manifest.json").write_text(json.dumps(text), encoding="utf-8")
    return folder


def set_value(stream: str, column: str, row: int, value: object) -> Change:
    def change(_: dict, tables: dict[str, pd.DataFrame]) -> None:
        table = tables[stream]
        if isinstance(value, str):
            table[column] = table[column].astype(object)
        table.loc[row - 1, column] = value

    return change


def both(*changes: Change) -> Change:
    def change(text: dict, tables: dict[str, pd.DataFrame]) -> None:
        for each in changes:
            each(text, tables)

    return change


def drop(stream: str, *columns: str) -> Change:
    return lambda _, tables: tables.update({stream: tables[stream].drop(columns=list(columns))})


def say(path: str, value: object) -> Change:
    def change(text: dict, _: dict[str, pd.DataFrame]) -> None:
        *way, last = path.split(".")
        for step in way:
            text = text[step]
        text[last] = value

    return change


def nulls(stream: str, columns: tuple[str, ...], rows: slice = slice(None)) -> Change:
    def change(_: dict, tables: dict[str, pd.DataFrame]) -> None:
        tables[stream].loc[tables[stream].index[rows], list(columns)] = np.nan

    return change


def segment(item: str, kind: str, **more: object) -> dict:
    return {"name": f"{item}_{kind}", "kind": kind, "item": item, "t_start": 0, "t_end": 1} | more


RATE = {"axis": "x", "rate_deg_s": 10}

REFUSED: dict[str, tuple[Change, tuple[str, ...]]] = {
    "another format": (say("format", "mimu-recording/2"), ("format", "mimu-recording/2")),
    "no station": (lambda text, _: text.pop("station"), ("manifest.json", "station")),
    "gravity of the moon": (say("station.gravity_m_s2", 1.62), ("gravity_m_s2", "1.62")),
    "unknown stream": (say("streams.camera", "camera.csv"), ("streams.camera",)),
    "no imu stream": (lambda text, _: text["streams"].pop("imu"), ("streams.imu", "missing")),
    "path upwards": (say("streams.imu", "../imu.csv"), ("../imu.csv", "leaves the folder")),
    "absolute path": (say("streams.imu", "/etc/passwd"), ("/etc/passwd", "leaves the folder")),
    "stream file missing": (say("streams.imu", "other.csv"), ("other.csv", "no such file")),
    "unknown suffix": (say("streams.imu", "imu.xlsx"), ("imu.xlsx", ".parquet")),
    "no time": (drop("imu", "t"), ("imu.csv", "column t", "missing")),
    "column missing": (drop("imu", "accel_y"), ("imu.csv", "column accel_y", "missing")),
    "half of the angles": (
        lambda _, f: f["imu"].insert(1, "angle_x", 0.0),
        ("column angle_y", "missing"),
    ),
    "axis without angle": (drop("table", "outer_angle"), ("table.csv", "outer_angle")),
    "table without axes": (say("station.table_axes", None), ("table.csv", "table_axes")),
    "text for a number": (
        set_value("imu", "gyro_x", 7, "abc"),
        ("imu.csv", "column gyro_x", "row 7", "abc"),
    ),
    "hole in one column": (
        nulls("imu", ("gyro_y",), slice(4, 5)),
        ("column gyro_y", "row 5", "null or NaN"),
    ),
    "infinite value": (
        set_value("imu", "accel_z", 3, np.inf),
        ("column accel_z", "row 3", "inf"),
    ),
    "hole in the table": (
        nulls("table", ("outer_angle",), slice(2, 3)),
        ("table.csv", "column outer_angle", "row 3"),
    ),
    "hole in time": (nulls("imu", ("t",), slice(9, 10)), ("column t", "row 10")),
    "nothing measured": (nulls("imu", GYRO + ACCEL), ("gyro_*", "accel_*", f"{ROWS} rows")),
    "time backwards": (
        set_value("imu", "t", 6, 0.001),
        ("column t", "row 6", "backwards", "0.001"),
    ),
    "time standing": (set_value("imu", "t", 6, 0.04), ("column t", "row 6", "stands still")),
    "less than a nanosecond": (
        set_value("imu", "t", 6, 0.04 + 1e-10),
        ("column t", "row 6", "nanosecond"),
    ),
    "time since 1970": (
        lambda _, f: f["imu"].__setitem__("t", f["imu"]["t"] + 1.7e9),
        ("column t", "row 1", "26 days"),
    ),
    "rows missing": (
        lambda _, f: f.update(table=f["table"].iloc[:0]),
        ("table.csv", "no row"),
    ),
}


ONLY_CSV = ("text for a number", "path upwards", "stream file missing", "unknown suffix")


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
@pytest.mark.parametrize("fault", REFUSED)
def test_fault_is_refused_with_one_sentence(fault, suffix, tmp_path):
    change, words = REFUSED[fault]
    if fault in ONLY_CSV:
        suffix = "csv"
    words = tuple(word.replace(".csv", f".{suffix}") for word in words)
    with pytest.raises(Unusable) as refusal:
        read_folder(write(tmp_path / "recording", change, suffix))
    sentence = str(refusal.value)
    assert all(word in sentence for word in words), sentence
    assert "\n" not in sentence
    assert sentence.endswith(".")


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (b"", "not JSON"),
        (b"{", "not JSON"),
        (b"[" * 100_000, "not JSON"),
        (b'{"a":' * 900 + b"1" + b"}" * 900, "not JSON|format"),
        (b'{"a": {"b": [1, NaN]}}', "a.b.1 is nan"),
        (b'{"a": 1e400}', "a is inf"),
        (b'{"a": -Infinity}', "a is -inf"),
        (b'{"a": "x\\ud800"}', "a is .*surrogate"),
        (b"\xff\xfe{}", "not UTF-8"),
        (b"[1]", "object"),
        (b"{}", "format"),
    ],
)
def test_manifest_that_is_none_is_refused(content, word, tmp_path):
    folder = write(tmp_path / "recording")
    (folder / "manifest.json").write_bytes(content)
    with pytest.raises(Unusable, match=word):
        read_folder(folder)


def test_missing_folder_and_missing_manifest_are_refused(tmp_path):
    with pytest.raises(Unusable, match="no such folder"):
        read_folder(tmp_path / "nowhere")
    with pytest.raises(Unusable, match=r"manifest\.json"):
        read_folder(tmp_path)


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
@pytest.mark.parametrize("content", [b"", b"\0\1\2 not a table", b"\xff\xfe\n\xff"])
def test_file_that_is_no_table_is_refused(suffix, content, tmp_path):
    folder = write(tmp_path / "recording", suffix=suffix)
    (folder / f"imu.{suffix}").write_bytes(content)
    with pytest.raises(Unusable, match=rf"imu\.{suffix}"):
        read_folder(folder)


def test_link_out_of_the_folder_is_refused(tmp_path):
    folder = write(tmp_path / "recording")
    (folder / "imu.csv").rename(tmp_path / "imu.csv")
    (folder / "imu.csv").symlink_to(tmp_path / "imu.csv")
    with pytest.raises(Unusable, match="leaves the folder"):
        read_folder(folder)


def test_known_column_twice_is_refused_and_unknown_ones_are_left_out(tmp_path):
    folder = write(tmp_path / "recording")
    header, *rows = (folder / "imu.csv").read_text().splitlines()
    more = [f"{header},note,note"] + [f"{row},a,b" for row in rows]
    (folder / "imu.csv").write_text("\n".join(more))
    assert set(read_folder(folder).imu.columns) == {*GYRO, *ACCEL}
    twice = [f"{header},gyro_x"] + [f"{row},1" for row in rows]
    (folder / "imu.csv").write_text("\n".join(twice))
    with pytest.raises(Unusable, match="column gyro_x is there twice"):
        read_folder(folder)


@pytest.mark.parametrize("fields", [2, 9])
def test_row_with_another_number_of_fields_is_named(fields, tmp_path):
    folder = write(tmp_path / "recording")
    lines = (folder / "imu.csv").read_text().splitlines()
    lines[6] = ",".join(["1"] * fields)
    (folder / "imu.csv").write_text("\n".join(lines))
    with pytest.raises(Unusable, match=rf"imu\.csv: row 6: {fields} fields .* has 7"):
        read_folder(folder)


def test_column_of_times_of_day_is_refused(tmp_path):
    def change(_: dict, tables: dict[str, pd.DataFrame]) -> None:
        tables["imu"]["t"] = pd.to_datetime(tables["imu"]["t"], unit="s")

    with pytest.raises(Unusable, match="column t holds timestamp"):
        read_folder(write(tmp_path / "recording", change, "parquet"))


def test_csv_and_parquet_of_the_same_numbers_have_one_digest(tmp_path):
    as_csv = read_folder(write(tmp_path / "csv"))
    as_parquet = read_folder(write(tmp_path / "parquet", suffix="parquet"))
    assert as_csv.digest == as_parquet.digest
    assert len(as_csv.digest) == 64


@pytest.mark.parametrize(
    "change",
    [
        set_value("imu", "gyro_x", 3, 0.5),
        set_value("imu", "t", 3, 0.021),
        set_value("environment", "humidity", 1, 45.3),
        say("recording_id", "other"),
        say("segments", [segment("six_position", "static")]),
    ],
)
def test_digest_changes_with_anything_that_is_said(change, tmp_path):
    before = read_folder(write(tmp_path / "before"))
    assert read_folder(write(tmp_path / "after", change)).digest != before.digest


def test_triad_may_be_null_over_a_stretch(tmp_path):
    change = both(nulls("imu", GYRO, slice(0, 5)), nulls("imu", ACCEL, slice(5, None)))
    imu = read_folder(write(tmp_path / "recording", change)).imu
    assert np.isnan(imu.columns["gyro_z"]).sum() == 5
    assert np.isnan(imu.columns["accel_z"]).sum() == ROWS - 5


def test_angles_stand_in_for_both_triads(tmp_path):
    def change(_: dict, tables: dict[str, pd.DataFrame]) -> None:
        tables["imu"] = tables["imu"].rename(columns=dict(zip(GYRO, ANGLE, strict=True)))
        tables["imu"] = tables["imu"].drop(columns=list(ACCEL))

    imu = read_folder(write(tmp_path / "recording", change)).imu
    assert set(imu.columns) == set(ANGLE)


def test_what_the_manifest_leaves_null_stays_unknown(tmp_path):
    station = read_folder(write(tmp_path / "recording")).manifest.station
    assert (station.latitude_deg, station.gravity_m_s2, station.heading_deg) == (None, None, None)


@pytest.mark.parametrize("name", ["real/vn200_imu1_rate_table", "real/ferraris_session"])
def test_real_recording_is_read(name):
    recording = read_folder(shared_path(f"data/{name}"))
    assert recording.manifest.recording_id == Path(name).name
    assert np.array_equal(recording.imu.t, np.rint(recording.imu.t * 1e9) / 1e9)
