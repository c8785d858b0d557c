"""`mimucal prune` lists what can go, and deletes it only when told to, by somebody."""

from collections.abc import Callable
from pathlib import Path

import pytest

from schemas.base import Unusable
from schemas.recording import Recording
from storage import retention
from storage.catalogue import audit_trail, runs
from storage.home import Home


@pytest.fixture
def store(home: Path, ideal_run: Callable[..., Recording]) -> Home:
    """A run that was never calibrated."""
    runs.add(ideal_run(dwell=1.0), Home(home))
    return Home(home)


def test_nothing_is_deleted_unless_it_is_asked_for(store: Home, mimucal) -> None:
    (run,) = runs.all_runs(store)
    listed = mimucal("prune", "--before", "2999-01-01", "--json").json
    assert (listed["format"], listed["deleted"]) == ("mimu-prune/1", False)
    assert [(each["run"], each["what"]) for each in listed["found"]] == [(run.id, "recording")]
    assert run.id in mimucal("prune", "--before", "2999-01-01").out
    assert runs.all_runs(store) == [run]
    assert mimucal("prune", "--before", "2000-01-01", "--json").json["found"] == []


def test_a_deletion_names_who_did_it(store: Home, mimucal, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MIMUCAL_USER", raising=False)
    refused = mimucal("prune", "--before", "2999-01-01", "--delete")
    assert refused.code == 2
    assert "--by NAME" in refused.err
    done = mimucal("prune", "--before", "2999-01-01", "--delete", "--by", "Li Na", "--json")
    assert (done.code, len(done.json["found"]), done.json["refused"]) == (0, 1, [])
    assert runs.all_runs(store) == []
    assert [entry.person for entry in audit_trail.entries(store)] == ["Li Na"]


def test_a_home_in_which_nothing_can_be_deleted_is_one_refusal(
    store: Home, mimucal, monkeypatch: pytest.MonkeyPatch, ideal_run: Callable[..., Recording]
) -> None:
    runs.add(ideal_run(dwell=1.5), store)

    def cannot(*_: object) -> None:
        raise Unusable("the home cannot be written; make room or give rights.")

    monkeypatch.setitem(retention.DELETE, "recording", cannot)
    refused = mimucal("prune", "--before", "2999-01-01", "--delete", "--by", "Li Na")
    assert (refused.code, refused.out) == (2, "")
    assert refused.err.count("cannot be written") == 1
    assert len(runs.all_runs(store)) == 2
