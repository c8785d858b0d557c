"""`backup`, `restore`, `upgrade`, `settings` and `alert` as an operator types them."""

import json
import socket
import tarfile
from pathlib import Path

import pytest

from flows.validate import run_validate
from schemas.base import Unusable
from schemas.laboratory import variables
from tasks.validation.coverage import MIN_UNITS
from tests.storage.full_home import HOMES

OLD = HOMES / "0013.tar.xz"


@pytest.fixture
def earlier(home: Path) -> Path:
    """A home that an earlier version left."""
    with tarfile.open(OLD) as archive:
        archive.extractall(home, filter="data")
    return home


def test_upgrade_backup_and_restore_of_an_earlier_home(
    earlier: Path, mimucal, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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


def test_settings_show_every_variable_and_no_secret(
    mimucal, home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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


def test_a_variable_with_a_slip_of_the_pen_is_named(
    mimucal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MIMUCAL_DATABSE", "postgresql://host/mimucal")
    done = mimucal("settings", "--json")
    assert (done.code, done.json["unknown"]) == (1, ["MIMUCAL_DATABSE"])


def test_an_alert_that_no_channel_takes_exits_with_1(mimucal, home: Path) -> None:
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


def test_a_small_study_leaves_the_record_of_the_home_alone(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("MIMUCAL_HOME", str(tmp_path))
    kept = tmp_path / "validation.json"
    kept.write_text("{}", encoding="utf-8")
    with pytest.raises(Unusable, match="--out"):
        run_validate(MIN_UNITS - 1, 1, None, as_json=True)
    assert kept.read_text(encoding="utf-8") == "{}"
