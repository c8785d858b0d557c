"""The life of a certificate from the command line, and the trail of it."""

import csv
import json
from io import StringIO
from pathlib import Path

import pytest

from storage.home import Home
from tests.drafts import draft


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
