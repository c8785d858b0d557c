"""The life of a certificate from the command line, and the trail of it."""

import csv
import hashlib
import json
from io import StringIO
from pathlib import Path

import pytest

from storage.home import Home
from tests.drafts import draft
from tests.own_limits import laboratory_file


@pytest.fixture
def key(home: Path) -> str:
    """The key of a draft by Wang."""
    return draft(Home(home)).certificate.number


def test_a_draft_is_checked_issued_and_withdrawn_and_the_trail_tells_it(mimucal, key: str) -> None:
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


def test_who_does_it_may_stand_in_the_environment(mimucal, key: str, monkeypatch) -> None:
    monkeypatch.setenv("MIMUCAL_USER", "Li")
    assert mimucal("check", key).code == 0
    refused = mimucal("issue", key)
    assert refused.code == 2
    assert "Li checked" in refused.err


@pytest.mark.parametrize("command", ["check", "issue", "withdraw", "amend"])
def test_a_step_of_nobody_is_refused_with_the_way_out(
    mimucal, key: str, command: str, monkeypatch
) -> None:
    monkeypatch.delenv("MIMUCAL_USER", raising=False)
    why = ("--why", "an error") if command in ("withdraw", "amend") else ()
    refused = mimucal(command, key, *why)
    assert refused.code == 2
    assert f"mimucal {command} {key} --by NAME" in refused.err
    assert "MIMUCAL_USER" in refused.err


def test_a_form_of_the_trail_that_is_none_is_refused(mimucal, key: str) -> None:
    refused = mimucal("trail", "--as", "pdf")
    assert refused.code == 2
    assert "choose one of table, csv, jsonl" in refused.err


@pytest.mark.rehearsal
def test_the_evidence_lies_beside_the_certificate_and_its_hash_in_the_record(
    mimucal, run_on_earth: str, home: Path, tmp_path: Path, unprinted
) -> None:
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


@pytest.mark.rehearsal
def test_a_result_by_draws_is_certified_without_an_evidence_file(
    mimucal, run_on_earth: str, home: Path, unprinted
) -> None:
    laboratory_file(home)
    arguments = ("--uncertainty", "montecarlo", "--by", "Wang", "--json")
    drafted = mimucal("certify", run_on_earth, *arguments)
    assert (drafted.code, drafted.json["evidence"]) == (0, None), drafted.err
