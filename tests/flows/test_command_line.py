"""The command line as scripts rely on it: documents, exit codes, one sentence for bad input."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from datetime import date
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from mcap.writer import Writer

from storage.formats.folder import read_folder
from storage.formats.mcap.messages import IMU, TEMPERATURE, encode, schema_text
from storage.formats.mcap.writer import write_mcap
from tests.own_limits import laboratory_file

SMALL = "real/ferraris_session"


def test_calibrate_of_a_path_prints_the_document_of_the_contract(mimucal, shared):
    done = mimucal("calibrate", shared / "real/ln100_two_position", "--json")
    assert done.code == 0
    assert done.json["format"] == "mimu-calibration/1"
    assert done.json["recording_id"] == "ln100_two_position"
    assert done.json["method"] == "jjf2003"
    item = done.json["items"]["gyro_g_sensitivity"]
    assert item["unit"] == "(deg/s)/g"
    assert set(item) >= {"value", "u", "U", "k", "value_without_earth_rotation"}
    assert item["value"]["xy"] is None
    assert done.json["unavailable"]["gyro_g_sensitivity"]
    assert done.json["warnings"]
    assert set(done.json["items"]["accel_rate_sensitivity"]["value_model"]) == {
        "xy", "xz", "yx", "yz", "zx", "zy"
    }  # fmt: skip


def test_the_same_content_is_one_run_whichever_way_it_comes(mimucal, shared, tmp_path):
    folder = shared / SMALL
    first = mimucal("import", folder, "--json").json["runs"][0]
    again = mimucal("import", folder, "--json").json["runs"][0]
    raw = tmp_path / "copy.mcap"
    write_mcap(read_folder(folder), raw)
    as_mcap = mimucal("import", raw, "--json").json["runs"][0]
    assert first["new"]
    assert not again["new"]
    assert not as_mcap["new"]
    assert first["run"] == again["run"] == as_mcap["run"]
    assert len(mimucal("runs", "--json").json["runs"]) == 1


def test_certify_decides_and_leaves_a_draft_and_its_issue_a_reminder(
    mimucal, home, plant_on_earth, tmp_path, unprinted
):
    laboratory_file(home)
    tolerance = tmp_path / "limits.toml"
    tolerance.write_text(
        'format = "mimu-tolerance/1"\nmanufacturer = "Plant"\nmodel = "M-tactical"\n'
        'document = "test"\n[[limits]]\nitem = "gyro_scale_factor"\nunit = "1"\n'
        "lower = 0.98\nupper = 1.02\n"
    )
    papers = ("--tolerance", tolerance, "--order", "flows/demo_papers/order.toml")
    papers += ("--calibrated-on", date.today(), "--operator", "Sun")
    unwaived = mimucal("certify", plant_on_earth, *papers[:2], "--json").json
    assert unwaived["verdict"] == "inconclusive"
    assert "waives the condition (largest rate)" in unwaived["reasons"][0]
    assert any(each.startswith("name of the client: not stated") for each in unwaived["missing"])
    done = mimucal("certify", plant_on_earth, *papers, "--json")
    assert done.code == 0
    assert done.json["format"] == "mimu-certificate/1"
    assert (done.json["verdict"], done.json["state"]) == ("pass", "draft")
    assert done.json["missing"] == []
    assert Path(done.json["pdf"]).read_bytes().startswith(b"%PDF")
    assert json.loads(Path(done.json["record"]).read_text())["number"] == done.json["number"]
    assert mimucal("remind", "--within", 370, "--json").json["due"] == []
    again = mimucal("certify", plant_on_earth, *papers, "--by", "Wang")
    key = done.json["number"]
    assert f"next: mimucal check {key} --by NAME, then mimucal issue {key} --by NAME" in again.out
    assert mimucal("check", key, "--by", "Li", "--json").json["state"] == "checked"
    issued = mimucal("issue", key, "--by", "Zhao", "--json").json
    assert issued["state"] == "issued"
    due = mimucal("remind", "--within", 370, "--json").json["due"]
    assert [d["certificate"] for d in due] == [issued["number"]]
    assert mimucal("remind", "--within", 30, "--json").json["due"] == []
    checked = mimucal("verify", "--json")
    assert (checked.code, checked.json["faults"]) == (0, [])
    why = ("--why", "the client's address", "--by", "Wang")
    amended = mimucal("amend", issued["number"], *why, "--json").json
    assert (amended["number"], amended["verdict"]) == (key, "pass")
    assert amended["replaces"]["number"] == issued["number"]


def test_show_tells_a_run_its_results_and_its_certificates(mimucal, shared, unprinted):
    run = mimucal("calibrate", shared / SMALL, "--json").json["run"]
    mimucal("certify", run, "--invalid-run")
    document = mimucal("show", run, "--json").json
    assert document["run"]["id"] == run
    assert len(document["results"]) == 1
    assert len(document["certificates"]) == 1
    assert "Segments" in mimucal("show", run).out


def test_verify_finds_a_flipped_byte_and_exits_with_1(mimucal, shared, home):
    mimucal("import", shared / SMALL)
    (raw,) = (home / "raw").glob("*.mcap")
    spoiled = bytearray(raw.read_bytes())
    spoiled[len(spoiled) // 2] ^= 1
    raw.chmod(0o644)
    raw.write_bytes(spoiled)
    done = mimucal("verify", "--json")
    assert done.code == 1
    assert str(raw) in done.json["faults"][0]["what"]


def drop_column(folder: Path) -> None:
    frame = pd.read_parquet(folder / "imu.parquet").drop(columns="gyro_y")
    frame.to_parquet(folder / "imu.parquet")


def put(column: str, row: int, value: float) -> Callable[[Path], None]:
    def spoil(folder: Path) -> None:
        frame = pd.read_parquet(folder / "imu.parquet")
        frame.loc[row, column] = value
        frame.to_parquet(folder / "imu.parquet")

    return spoil


def null_one(folder: Path) -> None:
    frame = pd.read_parquet(folder / "imu.parquet")
    frame["accel_z"] = frame["accel_z"].astype(object)
    frame.loc[7, "accel_z"] = None
    frame["accel_z"] = frame["accel_z"].astype("Float64")
    frame.to_parquet(folder / "imu.parquet")


def manifest(**changes: object) -> Callable[[Path], None]:
    def spoil(folder: Path) -> None:
        document = json.loads((folder / "manifest.json").read_text())
        (folder / "manifest.json").write_text(json.dumps(document | changes))

    return spoil


BAD = {
    "missing column": (drop_column, ["imu.parquet", "gyro_y"]),
    "NaN": (put("gyro_x", 4, float("nan")), ["imu.parquet", "gyro_x", "5"]),
    "null in one column only": (null_one, ["imu.parquet", "accel_z", "8"]),
    "time backwards": (put("t", 100, 0.5), ["imu.parquet", "101"]),
    "unknown format": (manifest(format="mimu-recording/9"), ["manifest.json", "format"]),
    "path leaving the folder": (
        manifest(streams={"imu": "../imu.parquet"}),
        ["manifest.json", "../imu.parquet"],
    ),
    "empty file": (lambda f: (f / "imu.parquet").write_bytes(b""), ["imu.parquet", "empty"]),
    "JSON that is not JSON": (
        lambda f: (f / "manifest.json").write_text("{segments: }"),
        ["manifest.json"],
    ),
}


@pytest.mark.parametrize("kind", sorted(BAD))
def test_bad_input_is_one_sentence_exit_2_and_an_unchanged_store(mimucal, copied, home, kind):
    spoil, names = BAD[kind]
    folder = copied(SMALL)
    spoil(folder)
    refused(mimucal, folder, names)
    assert not home.exists()


def refused(mimucal, path: Path, names: list[str]) -> None:
    for command in ("import", "calibrate", "certify"):
        done = mimucal(command, path)
        assert done.code == 2, command
        assert done.out == ""
        sentence = done.err.strip()
        assert "\n" not in sentence
        assert "Traceback" not in sentence
        assert all(name in sentence for name in names), sentence


def test_a_cut_off_mcap_is_refused_and_what_is_whole_is_offered(
    mimucal, plant_clean, tmp_path, home
):
    whole, cut = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    write_mcap(read_folder(plant_clean), whole)
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size * 2 // 3])
    done = mimucal("import", cut)
    assert done.code == 2
    assert "--salvage" in done.err
    assert not list(home.rglob("*.mcap"))
    saved = mimucal("import", cut, "--salvage", "--json")
    assert saved.code == 0
    shown = mimucal("show", saved.json["runs"][0]["run"], "--json").json
    assert 0.3 < shown["run"]["seconds"] / 1576 < 1.0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("calibrate", "nothing-like-it"), "mimucal runs"),
        (("calibrate", ""), "RUN is empty"),
        (("calibrate", "flows"), "flows holds no recording"),
        (("certify", "flows"), "flows holds no recording"),
        (("calibrate", "x" * 5000), "mimucal runs"),
        (("calibrate", "x", "--method", "guess"), "--method guess"),
        (("certify", "x", "--tolerance", "missing.toml"), "missing.toml"),
        (("certify", "x", "--calibrated-on", "yesterday"), "--calibrated-on"),
        (("certify", "x", "--calibrated-on", "2999-01-01"), "in the future"),
        (("acquire", "missing.json"), "missing.json"),
        (
            ("calibrate", "x", "--uncertainty", "guess"),
            "gum, montecarlo, example",
        ),
        (("certify", "x", "--uncertainty", "guess"), "--uncertainty guess"),
        (("trail", "--as", "pdf"), "choose one of table, csv, jsonl"),
        (("reprocess", "--since", "2026-13-01"), "'2026-13-01' is not a date"),
        (("reprocess", "--workers", "0"), "1. See"),
        (("remind", "--within", "-1"), "--within"),
        (("remind", "--within", "36501"), "--within"),
        (("station", "serve", "--port", "65535"), "--port"),
        (("station", "serve", "--speed", "inf"), "--speed"),
        (("demo", "--speed", "0"), "--speed"),
        (("demo", "--seed", "-1"), "--seed"),
        (("demo", "--procedure", "jjf1537"), "no procedure 'jjf1537': choose one of jjf1536, "),
        (("station",), "Missing command"),
        (("nonsense",), "nonsense"),
        (("runs", "--nonsense"), "--nonsense"),
    ],
)
def test_what_cannot_be_used_is_one_sentence_and_exit_2(mimucal, arguments, says):
    done = mimucal(*arguments)
    assert (done.code, done.out) == (2, "")
    assert says in done.err
    assert done.err.strip().count("\n") == 0


def test_missing_recording_is_a_fault_that_verify_finds(mimucal):
    done = mimucal("verify", "missing-folder")
    assert done.code == 1
    assert "missing-folder" in done.out


def test_demo_that_cannot_write_says_where(mimucal, home):
    home.mkdir()
    (home / "demo").write_text("in the way")
    done = mimucal("demo")
    assert done.code == 2
    assert str(home / "demo") in done.err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is full")
def test_an_output_without_room_is_one_sentence(tmp_path):
    command = [sys.executable, "-m", "flows.cli", "runs", "--json"]
    own = os.environ | {"MIMUCAL_HOME": str(tmp_path)}
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        done = subprocess.run(
            command, stdout=full, stderr=subprocess.PIPE, text=True, check=False, env=own
        )
    assert done.returncode == 2
    assert done.stderr.startswith("the output cannot be written (No space left on device)")


def test_ctrl_c_is_one_sentence_and_exit_1(mimucal, monkeypatch):
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("storage.catalogue.runs.all_runs", stop)
    done = mimucal("runs")
    assert (done.code, done.err) == (1, "stopped by the operator\n")


def test_text_of_a_recording_is_printed_as_it_is(mimucal, copied, unprinted):
    folder, text = copied(SMALL), "[/bold]x[red]:smile:{x}"
    document = json.loads((folder / "manifest.json").read_text())
    document["unit"]["serial"] = text
    manifest(recording_id=text, unit=document["unit"])(folder)
    calibrated = mimucal("calibrate", folder)
    assert calibrated.code == 0, calibrated.err
    assert text in calibrated.out
    for command in (
        ("runs",),
        ("show", text),
        ("certify", text, "--invalid-run"),
    ):
        done = mimucal(*command)
        assert done.code == 0, done.err
        assert text in done.out or command[0] == "certify"


def test_topics_of_a_bag_that_no_stream_takes_are_told(mimucal, tmp_path):
    bag = tmp_path / "bag.mcap"
    with bag.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2")
        for topic, kind in (("/imu", IMU), ("/camera", TEMPERATURE)):
            schema = writer.register_schema(kind, "ros2msg", schema_text(kind).encode())
            channel = writer.register_channel(topic, "cdr", schema)
            for k in range(300 if kind == IMU else 1):
                fields = {"sec": np.array([[k]]), "nanosec": np.array([[5]])}
                message = encode(kind, fields, {"frame_id": ("f",)})[0].tobytes()
                writer.add_message(channel, k, message, k)
        writer.finish()
    done = mimucal("import", bag, "--json")
    assert done.json["runs"][0]["left_out"] == ["/camera"]
    assert "/camera" in done.err


def test_what_was_taken_in_before_a_bad_recording_is_told(mimucal, copied, shared):
    bad = copied(SMALL)
    drop_column(bad)
    done = mimucal("import", shared / "real/ferraris_session", bad, "--json")
    assert done.code == 2
    assert [entry["new"] for entry in done.json["runs"]] == [True]
    assert str(bad) in done.err


def test_help_shows_what_an_option_takes(mimucal):
    printed = mimucal("station", "serve", "--help").out
    assert "NAME[@SECONDS]" in printed
    assert "0<=x<=65534" in printed
    assert "Address" in printed
    assert "Serve a virtual station" in mimucal().out


HEAVY = {
    "prefect", "numpy", "pandas", "pyarrow", "alembic", "sqlalchemy", "typst", "pymodbus",
    "matplotlib", "fluent", "pyarrow.compute", "scipy.optimize", "scipy.fft",
}  # fmt: skip


def loaded(*command: str) -> tuple[str, set[str]]:
    """What a command prints, and which of the heavy modules it loaded for that."""
    code = (
        f"import sys; sys.argv = ['mimucal', *{command!r}]\n"
        "from flows import cli\n"
        "try: cli.main()\n"
        "except SystemExit: pass\n"
        "print('LOADED', *sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    text, _, modules = done.stdout.rpartition("LOADED")
    return text, HEAVY & set(modules.split())


def test_help_starts_without_the_heavy_libraries():
    text, heavy = loaded("--help")
    assert heavy == set()
    assert "calibrate" in text


@pytest.mark.rehearsal
def test_runs_are_listed_with_the_catalogue_alone(mimucal, plant_clean):
    run = mimucal("import", plant_clean).out.split()[0]
    text, heavy = loaded("runs")
    assert run in text
    assert heavy == {"sqlalchemy"}


@pytest.mark.rehearsal
def test_calibrating_by_the_standard_starts_without_what_other_recordings_need(mimucal, shared):
    run = mimucal("import", shared / "real/vn200_imu0_rate_table").out.split()[0]
    _, heavy = loaded("calibrate", run, "--json")
    assert heavy == {"numpy", "pyarrow", "sqlalchemy", "fluent"}


@pytest.mark.rehearsal
def test_a_certificate_is_drafted_without_prefect_where_no_server_is_named(mimucal, shared):
    run = mimucal("import", shared / SMALL).out.split()[0]
    text, heavy = loaded("certify", run, "--by", "Li", "--invalid-run")
    assert "mimucal check draft-" in text
    assert heavy & {"prefect", "pandas", "alembic", "pymodbus"} == set()


def test_an_ahrs_recording_is_calibrated_by_its_own_specification(mimucal, ahrs_clean):
    done = mimucal("calibrate", ahrs_clean, "--json")
    assert (done.code, done.json["method"]) == (0, "jjf1536")
    truth = json.loads((ahrs_clean / "truth.json").read_text())
    item = done.json["items"]["ahrs_scale_factor"]
    for axis, true in zip("xyz", truth["K"], strict=True):
        assert abs(item["value"][axis] - true) < 3 * item["u"][axis]
    by_other = mimucal("calibrate", done.json["run"], "--method", "jjf2003")
    assert by_other.code == 2
    assert "JJF 1536" in by_other.err
