"""The life of a certificate from the command line, and the trail of it."""

import csv
import hashlib
import json
from io import StringIO
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml

from schemas.calibration import EvidenceFile
from storage.home import Home
from tests.drafts import draft
from tests.own_limits import laboratory_file

# `mimucal export` and `mimucal apply`: a result on its way to where the unit is used.

K_AND_B = ("gyro_scale_factor", "gyro_cross_coupling", "gyro_bias", "accel_scale_factor",
           "accel_cross_coupling", "accel_bias", "accel_rate_sensitivity")  # fmt: skip


@pytest.fixture
def run(run_on_earth) -> str:
    return run_on_earth


def test_a_corrected_recording_calibrates_to_an_ideal_unit(mimucal, plant_on_earth, run, tmp_path):
    done = mimucal("apply", run, plant_on_earth, "--out", tmp_path / "corrected", "--json")
    assert (done.code, done.json["format"], done.json["assumed_ideal"]) == (0, "mimu-apply/1", [])
    again = mimucal("calibrate", tmp_path / "corrected", "--json").json
    assert again["recording_id"] == "plant_earth_rotation_corrected"
    assert again["validity"]["verdict"] == "valid"
    for name in K_AND_B:
        item = again["items"][name]
        for element, value in item["value"].items():
            ideal = 1.0 if name.endswith("scale_factor") else 0.0
            assert abs(value - ideal) <= item["U"][element], (name, element)
    sensitivity = again["items"]["gyro_g_sensitivity"]
    for element, value in sensitivity["value_without_earth_rotation"].items():
        assert abs(value) <= sensitivity["U_without_earth_rotation"][element]


def test_export_prints_a_form_and_nothing_else(mimucal, run):
    document = mimucal("export", run, "--as", "json", "--json")
    assert document.json["format"] == "mimu-correction/1"
    assert document.json["unit"] == {
        "manufacturer": "Plant", "model": "M-tactical", "serial": "SN00102"
    }  # fmt: skip
    assert yaml.safe_load(mimucal("export", run, "--as", "yaml").out) == document.json
    header = mimucal("export", run, "--as", "c", "--json").json
    assert (header["format"], header["as"]) == ("mimu-export/1", "c")
    assert header["text"] == mimucal("export", run, "--as", "c").out
    assert "update_rate" in mimucal("export", run, "--as", "kalibr").out
    evidence = EvidenceFile.model_validate_json(mimucal("export", run, "--as", "evidence").out)
    assert (evidence.run, evidence.decision) == (run, None)


def test_a_result_in_a_file_needs_no_store_but_for_kalibr(mimucal, run, tmp_path, monkeypatch):
    file = tmp_path / "result.json"
    file.write_text(mimucal("calibrate", run, "--json").out, encoding="utf-8")
    monkeypatch.setenv("MIMUCAL_HOME", str(tmp_path / "another"))
    assert mimucal("export", file, "--as", "json", "--json").json["unit"] is None
    refused = mimucal("export", file, "--as", "kalibr")
    assert refused.code == 2
    assert "sampling rate and noise" in refused.err


def test_what_cannot_be_corrected_is_one_sentence(
    mimucal, run, shared, plant_on_earth, ahrs_clean, tmp_path
):
    taken, other = tmp_path / "taken", shared / "real/ln100_two_position"
    taken.mkdir()
    (taken / "mine").write_text("kept", encoding="utf-8")
    ahrs = mimucal("calibrate", ahrs_clean, "--json").json["run"]
    out = tmp_path / "corrected"
    for arguments, says in (
        (("export", run, "--as", "matlab"), "choose one of json, yaml, c, ros, kalibr, csv"),
        (("export", "nowhere", "--as", "c"), "no result 'nowhere'"),
        (("export", ahrs, "--as", "c"), "models (1) and (2)"),
        (("apply", run, other, "--out", out), "give a result of that unit"),
        (("apply", run, plant_on_earth, "--out", taken), "new folder"),
    ):
        done = mimucal(*arguments)
        assert done.code == 2, arguments
        assert done.err.strip().count("\n") == 0
        assert says in done.err
    assert not out.exists()
    assert (taken / "mine").read_text(encoding="utf-8") == "kept"


def test_the_result_of_an_invalid_run_corrects_nothing(mimucal, run, tmp_path):
    document = mimucal("calibrate", run, "--json").json
    worst = {"code": "spoiled", "en": "The supply fell.", "zh": "电压下降。", "run": "invalid"}
    document["remarks"].append(worst)
    file = tmp_path / "invalid.json"
    file.write_text(json.dumps(document), encoding="utf-8")
    for arguments in (("export", file, "--as", "c"), ("apply", file, run, "--out", tmp_path / "o")):
        done = mimucal(*arguments)
        assert done.code == 2
        assert "invalid: The supply fell" in done.err


@pytest.mark.rehearsal
def test_a_corrected_recording_has_its_uncertainty_beside_the_readings_where_it_is_asked_for(
    mimucal, plant_on_earth, run, tmp_path
):
    out = tmp_path / "corrected"
    done = mimucal("apply", run, plant_on_earth, "--out", out, "--with-u", "--json")
    assert done.code == 0, done.err
    columns = pq.read_table(out / "imu.parquet")
    for name, u_rms in done.json["u_rms"].items():
        u = columns[f"u_{name}"].to_numpy()
        assert np.sqrt((u**2).mean()) == pytest.approx(u_rms)
    assert len(done.json["u_rms"]) == 6
    assert mimucal("calibrate", out, "--json").json["validity"]["verdict"] == "valid"
    plain = mimucal("apply", run, plant_on_earth, "--out", tmp_path / "plain")
    assert plain.out.strip() == str(tmp_path / "plain")
    assert "gyro_x: U of the correction = " in plain.err
    assert "u_gyro_x" not in pq.read_table(tmp_path / "plain/imu.parquet").column_names


@pytest.mark.rehearsal
def test_uncertainties_that_a_result_does_not_give_are_refused_in_a_sentence(
    mimucal, plant_on_earth, tmp_path, home
):
    example = mimucal("calibrate", plant_on_earth, "--uncertainty", "example", "--json")
    (tmp_path / "example.json").write_text(example.out, encoding="utf-8")
    arguments = (tmp_path / "example.json", plant_on_earth, "--out", tmp_path / "new")
    done = mimucal("apply", *arguments, "--with-u")
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert "has no covariance of its elements" in done.err
    assert not (tmp_path / "new").exists()
    assert mimucal("apply", *arguments, "--json").json["u_rms"] == {}


@pytest.fixture
def key(home) -> str:
    """The key of a draft by Wang."""
    return draft(Home(home)).certificate.number


def test_a_draft_is_checked_issued_and_withdrawn_and_the_trail_tells_it(mimucal, key):
    checked = mimucal("check", key, "--by", "Li", "--reason", "read twice", "--json").json
    assert (checked["format"], checked["state"]) == ("mimu-certificate/1", "checked")
    issued = mimucal("issue", key, "--by", "Zhao", "--json").json
    assert [step["person"] for step in issued["steps"]] == ["Wang", "Li", "Zhao"]
    assert all(Path(issued[face]).exists() for face in ("pdf", "dcc", "record"))
    assert Path(issued["pdf"]).read_bytes().startswith(b"%PDF-1.")
    gone = mimucal("withdraw", issued["number"], "--why", "a wrong table", "--by", "Zhao")
    assert f"{issued['number']}: pass (withdrawn)" in gone.out
    assert "due" not in gone.out  # nobody is to come back by a certificate that no longer counts
    entries = mimucal("trail", "--json").json["entries"]
    assert [(e["action"], e["person"]) for e in entries] == [
        ("draft", "Wang"), ("check", "Li"), ("issue", "Zhao"), ("withdraw", "Zhao")
    ]  # fmt: skip
    lines = mimucal("trail", "--as", "jsonl").out.splitlines()
    assert [json.loads(line) for line in lines] == entries
    rows = list(csv.DictReader(StringIO(mimucal("trail", "--as", "csv").out)))
    assert [row["hash"] for row in rows] == [entry["hash"] for entry in entries]
    assert "a wrong table" in mimucal("trail").out
    assert mimucal("verify").code == 0


def test_who_does_it_may_stand_in_the_environment(mimucal, key, monkeypatch):
    monkeypatch.setenv("MIMUCAL_USER", "Li")
    assert mimucal("check", key).code == 0
    refused = mimucal("issue", key)
    assert refused.code == 2
    assert "Li checked" in refused.err


@pytest.mark.parametrize("command", ["check", "issue", "withdraw", "amend"])
def test_a_step_of_nobody_is_refused_with_the_way_out(mimucal, key, command, monkeypatch):
    monkeypatch.delenv("MIMUCAL_USER", raising=False)
    why = ("--why", "an error") if command in ("withdraw", "amend") else ()
    refused = mimucal(command, key, *why)
    assert refused.code == 2
    assert f"mimucal {command} {key} --by NAME" in refused.err
    assert "MIMUCAL_USER" in refused.err


@pytest.mark.rehearsal
def test_the_evidence_lies_beside_the_certificate_and_its_hash_in_the_record(
    mimucal, run_on_earth, home, tmp_path, unprinted
):
    laboratory_file(home)
    limits = tmp_path / "limits.toml"
    limits.write_text(
        'format = "mimu-tolerance/1"\nmanufacturer = "Plant"\nmodel = "M-tactical"\n'
        'document = "test"\nrule = "guard_band"\n[[limits]]\nitem = "gyro_scale_factor"\n'
        'unit = "1"\nlower = 0.999\nupper = 1.001\n',
        encoding="utf-8",
    )
    order = ("--order", "flows/demo_papers/order.toml", "--calibrated-on", "2026-05-02")
    given = ("--tolerance", limits, *order, "--operator", "Sun", "--by", "Wang", "--json")
    drafted = mimucal("certify", run_on_earth, *given).json
    mimucal("check", drafted["number"], "--by", "Li")
    issued = mimucal("issue", drafted["number"], "--by", "Zhao", "--json").json
    path = Path(issued["evidence"])
    assert path.name == f"{issued['number']}.evidence.json"
    record = json.loads(Path(issued["record"]).read_text(encoding="utf-8"))
    assert hashlib.sha256(path.read_bytes()).hexdigest() == record["evidence_sha256"]
    evidence = json.loads(path.read_text(encoding="utf-8"))
    assert evidence["decision"] == record["decision"]
    assert evidence["digest"] == record["calibration"]["digest"]
    assert not Path(drafted["evidence"]).exists()
    assert mimucal("verify").code == 0
    assert mimucal("verify", path).code == 0

    path.chmod(0o600)
    path.write_bytes(path.read_bytes().replace(b'"value":', b'"value": ', 1))
    for arguments in ((), (path,)):
        done = mimucal("verify", *arguments, "--json")
        (fault,) = done.json["faults"]
        assert (done.code, Path(fault["what"]).name) == (1, path.name)
    alone = tmp_path / "alone.evidence.json"
    alone.write_bytes(path.read_bytes())
    assert "beside it" in mimucal("verify", alone).out
