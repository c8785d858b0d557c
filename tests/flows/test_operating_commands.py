"""What an operator types to keep a home: backups, upgrades, settings, alerts, pruning, checks."""

import json
import socket
import tarfile
from pathlib import Path

import pytest

from flows.store_commands import validate
from schemas.base import Unusable
from schemas.laboratory import variables
from storage import retention
from storage.catalogue import audit_trail, runs
from storage.home import Home
from tasks.certificate.pdf import faces_of
from tasks.validation.coverage import MIN_UNITS
from tests.storage.full_home import HOMES
from tests.tasks.certificate.sample_certificate import certificate

# `backup`, `restore`, `upgrade`, `settings` and `alert` as an operator types them.

OLD = HOMES / "0013.tar.xz"


@pytest.fixture
def earlier(home) -> Path:
    """A home that an earlier version left."""
    with tarfile.open(OLD) as archive:
        archive.extractall(home, filter="data")
    return home


def test_upgrade_backup_and_restore_of_an_earlier_home(earlier, mimucal, tmp_path, monkeypatch):
    refused = mimucal("runs")
    assert refused.code == 2
    assert "run `mimucal upgrade`" in refused.err
    assert mimucal("upgrade", "--json").json["done"] == "upgraded"
    assert mimucal("upgrade").out == "The catalogue needs no upgrade.\n"
    assert mimucal("upgrade", "--back", "--json").json["done"] == "back"
    assert mimucal("runs").code == 2
    mimucal("upgrade")
    assert mimucal("upgrade", "--confirm").code == 0
    assert mimucal("upgrade", "--back").code == 2
    assert mimucal("upgrade", "--back", "--confirm").code == 2
    before = mimucal("runs", "--json").json
    made = mimucal("backup", tmp_path / "backups", "--json").json
    assert made["missing"] == []
    assert made["rows"]["runs"] == len(before["runs"])
    assert mimucal("restore", tmp_path / "backups").code == 2  # not empty
    monkeypatch.setenv("MIMUCAL_HOME", str(tmp_path / "other"))
    restored = mimucal("restore", tmp_path / "backups", "--json")
    assert (restored.code, restored.json["faults"]) == (0, [])
    assert restored.json["backup"] == made["backup"]
    assert mimucal("runs", "--json").json == before
    assert mimucal("verify").code == 0


def test_settings_show_every_variable_and_no_secret(mimucal, home, monkeypatch):
    monkeypatch.setenv("MIMUCAL_SIGNING_PASSPHRASE", "hunter2")
    monkeypatch.setenv("MIMUCAL_DATABASE", "postgresql://lab:hunter2@host/mimucal")
    monkeypatch.setenv("MIMUCAL_USER", "")
    done = mimucal("settings", "--json")
    assert done.code == 0
    assert "hunter2" not in done.out + mimucal("settings").out
    shown = {row["variable"]: row for row in done.json["settings"]}
    assert shown.keys() == set(variables().values())
    assert (shown["MIMUCAL_HOME"]["value"], shown["MIMUCAL_HOME"]["source"]) == (
        str(home), "environment",
    )  # fmt: skip
    assert shown["MIMUCAL_DATABASE"]["value"] == "***"
    assert (shown["MIMUCAL_USER"]["value"], shown["MIMUCAL_USER"]["source"]) == (None, "default")


def test_a_variable_with_a_slip_of_the_pen_is_named(mimucal, monkeypatch):
    monkeypatch.setenv("MIMUCAL_DATABSE", "postgresql://host/mimucal")
    done = mimucal("settings", "--json")
    assert (done.code, done.json["unknown"]) == (1, ["MIMUCAL_DATABSE"])


def test_an_alert_that_no_channel_takes_exits_with_1(mimucal, home):
    assert "names no operators" in mimucal("alert", "text").err
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    home.mkdir(exist_ok=True)
    (home / "recall.toml").write_text(
        f'format = "mimu-recall/1"\noperators.channels.chat = "json://127.0.0.1:{port}"\n'
    )
    done = mimucal("alert", "text", "--json")
    assert done.code == 1
    assert json.loads(done.out)["channels"]["chat"]


# `mimucal validate`: a study too small to show anything does not replace the record.


def test_a_small_study_leaves_the_record_of_the_home_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("MIMUCAL_HOME", str(tmp_path))
    kept = tmp_path / "validation.json"
    kept.write_text("{}", encoding="utf-8")
    with pytest.raises(Unusable, match="--out"):
        validate(MIN_UNITS - 1, 1, None, as_json=True)
    assert kept.read_text(encoding="utf-8") == "{}"


# `mimucal prune` lists what can go, and deletes it only when told to, by somebody.


@pytest.fixture
def store(home, ideal_run) -> Home:
    """A run that was never calibrated."""
    runs.add(ideal_run(dwell=1.0), Home(home))
    return Home(home)


def test_nothing_is_deleted_unless_it_is_asked_for(store, mimucal):
    (run,) = runs.all_runs(store)
    listed = mimucal("prune", "--before", "2999-01-01", "--json").json
    assert (listed["format"], listed["deleted"]) == ("mimu-prune/1", False)
    assert [(each["run"], each["what"]) for each in listed["found"]] == [(run.id, "recording")]
    assert run.id in mimucal("prune", "--before", "2999-01-01").out
    assert runs.all_runs(store) == [run]
    assert mimucal("prune", "--before", "2000-01-01", "--json").json["found"] == []


def test_a_deletion_names_who_did_it(store, mimucal, monkeypatch):
    monkeypatch.delenv("MIMUCAL_USER", raising=False)
    refused = mimucal("prune", "--before", "2999-01-01", "--delete")
    assert refused.code == 2
    assert "--by NAME" in refused.err
    done = mimucal("prune", "--before", "2999-01-01", "--delete", "--by", "Li Na", "--json")
    assert (done.code, len(done.json["found"]), done.json["refused"]) == (0, 1, [])
    assert runs.all_runs(store) == []
    assert [entry.person for entry in audit_trail.entries(store)] == ["Li Na"]


def test_a_home_in_which_nothing_can_be_deleted_is_one_refusal(
    store, mimucal, monkeypatch, ideal_run
):
    runs.add(ideal_run(dwell=1.5), store)

    def cannot(*_: object) -> None:
        raise Unusable("the home cannot be written; make room or give rights.")

    monkeypatch.setitem(retention.DELETE, "recording", cannot)
    refused = mimucal("prune", "--before", "2999-01-01", "--delete", "--by", "Li Na")
    assert (refused.code, refused.out) == (2, "")
    assert refused.err.count("cannot be written") == 1
    assert len(runs.all_runs(store)) == 2


# `mimucal verify` of a certificate's file: nothing but the file, and no home.


@pytest.fixture
def dcc(tmp_path) -> Path:
    path = tmp_path / "MIMU-2026-0042.xml"
    path.write_bytes(faces_of(certificate(), None).dcc)
    return path


def test_a_whole_file_says_what_it_is_and_what_it_cannot_know(mimucal, home, dcc):
    done = mimucal("verify", dcc)
    assert done.code == 0
    assert "whole; certificate MIMU-2026-0042, issued" in done.out
    assert "not signed electronically" in done.out
    assert not home.exists()


def test_a_changed_file_is_a_fault_in_the_published_format(mimucal, dcc):
    dcc.write_bytes(dcc.read_bytes().replace(b"0.01187", b"0.01188"))
    done = mimucal("verify", dcc, "--json")
    assert done.code == 1
    assert done.json["format"] == "mimu-verify/1"
    assert [fault["what"] for fault in done.json["faults"]] == [str(dcc)]


def test_a_file_that_is_not_there_or_certificates_that_are_none_are_one_sentence(mimucal, dcc):
    for arguments, says in (
        ((dcc.with_name("none.pdf"),), "none.pdf cannot be read"),
        ((dcc, "--trust", dcc), "give a file with certificates as PEM"),
    ):
        done = mimucal("verify", *arguments)
        assert (done.code, done.out) == (2, "")
        assert says in done.err
        assert done.err.strip().count("\n") == 0
