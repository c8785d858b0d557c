"""What may go, goes with an entry in the trail; what a result or a certificate needs stays."""

import json
import os
from datetime import UTC, date, datetime, timedelta

import pytest

from schemas.recording import Recording
from storage import retention
from storage.catalogue import audit_trail, results, runs
from storage.catalogue.runs import Run
from storage.home import Home
from storage.verify import verify
from tests.keep import keep
from tests.storage.s3_server import Store, serving
from tests.storage.small import calibrated, certified, small

TOMORROW = (datetime.now(UTC) + timedelta(days=1)).date()


def kept(home: Home, recording: Recording) -> Run:
    return runs.add(recording, home)[0]


def found(home: Home) -> set[tuple[str, str]]:
    return {(each.run, each.what) for each in retention.dispensable(TOMORROW, home)}


def delete(home: Home) -> list[str]:
    """Deletes what can go; gives why something did not."""
    can_go = retention.dispensable(TOMORROW, home)
    return [each.why for each in retention.delete(can_go, "Li", home, lambda *_: None)[1]]


def test_a_recording_that_nothing_stands_on_goes_and_is_in_the_trail(fresh):
    unused, used = kept(fresh, small()), kept(fresh, small(1.0))
    results.save(calibrated(used), fresh)
    assert found(fresh) == {(unused.id, "recording"), (used.id, "columns")}
    assert delete(fresh) == []
    assert runs.all_runs(fresh) == [used]
    assert [path.name for path in fresh.raw.iterdir()] == [f"{used.digest}.mcap"]
    assert list(fresh.columns.iterdir()) == []
    first, second = audit_trail.entries(fresh)
    assert (first.person, first.action, first.subject) == ("Li", "delete recording", unused.id)
    assert json.loads(first.details)["digest"] == unused.digest
    assert (second.action, second.subject) == ("delete columns", used.id)
    assert verify(fresh)[1] == []
    assert runs.load(used, fresh).digest == used.digest  # from raw
    assert kept(fresh, small()).id == unused.id  # it can come back


def test_what_is_not_older_stays(fresh):
    run = kept(fresh, small())
    assert retention.dispensable(run.imported_at.date(), fresh) == []


@pytest.mark.parametrize("state", ["draft", "checked", "issued"])
def test_runs_of_a_certificate_stay_as_found_and_as_left(fresh, state):
    left, before = kept(fresh, small()), kept(fresh, small(1.0))
    decision = certified(small(), calibrated(left), "A-1").decision
    as_found = {
        "calibration": calibrated(before), "decision": decision,
        "calibrated_on": date(2026, 1, 1),
    }  # fmt: skip
    paper = certified(small(), calibrated(left), "A-1", state=state, as_found=as_found)
    keep(paper, fresh)
    assert results.of_run(before, fresh) == []  # the certificate alone names it
    assert found(fresh) == {(left.id, "columns"), (before.id, "columns")}
    assert delete(fresh) == []
    assert len(list(fresh.raw.iterdir())) == 2


def test_an_unreadable_certificate_protects_every_run_of_its_unit(fresh):
    run, sibling = kept(fresh, small()), kept(fresh, small(1.0))
    stranger = kept(fresh, small(2.0, serial="2"))
    keep(certified(small(), calibrated(run), "A-1"), fresh)
    record = fresh.certificates / "A-1.json"
    record.unlink()
    assert (sibling.id, "columns") in found(fresh)
    assert {run for run, what in found(fresh) if what == "recording"} == {stranger.id}


def test_a_run_that_is_calibrated_meanwhile_stays(fresh):
    run = kept(fresh, small())
    can_go = retention.dispensable(TOMORROW, fresh)
    results.save(calibrated(run), fresh)
    deleted, refused = retention.delete(can_go, "Li", fresh, lambda *_: None)
    assert deleted == []
    assert "now depends on it" in refused[0].why
    assert audit_trail.entries(fresh) == []
    assert runs.load(run, fresh).digest == run.digest


def test_columns_are_kept_where_the_raw_recording_is_damaged(fresh):
    run = kept(fresh, small())
    results.save(calibrated(run), fresh)
    raw = fresh.raw / f"{run.digest}.mcap"
    raw.chmod(0o644)
    raw.write_bytes(raw.read_bytes()[:2000])
    (why,) = delete(fresh)
    assert str(raw) in why
    assert runs.load(run, fresh).digest == run.digest
    assert audit_trail.entries(fresh) == []


@pytest.mark.real_time
def test_a_bucket_is_pruned_and_what_it_holds_unknown_is_a_fault(fresh, monkeypatch):
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(name, "of-a-test")
    store = Store(every=7)
    with serving(store) as url:
        monkeypatch.setenv("MIMUCAL_STORE", url)
        unused, used = kept(fresh, small()), kept(fresh, small(1.0))
        results.save(calibrated(used), fresh)
        assert verify(fresh)[1] == []
        assert delete(fresh) == []
        there = {key for key in store.objects if not key.endswith("/")}  # but for empty folders
        assert there == {f"lab/mimu/raw/{used.digest}.mcap"}
        store.objects[f"lab/mimu/columns/{unused.digest}/imu.parquet"] = b"left"
        store.objects["lab/mimu/raw/notes.txt"] = b"notes"
        faults = {fault.what: fault.why for fault in verify(fresh)[1]}
    assert set(faults) == {
        f"s3://lab/mimu/columns/{unused.digest}", "s3://lab/mimu/raw/notes.txt"
    }  # fmt: skip
    assert all("the catalogue does not know it" in why for why in faults.values())


def test_a_draft_that_was_broken_off_is_named_and_goes(fresh):
    recording = small()
    keep(certified(recording, calibrated(kept(fresh, recording)), "A-1"), fresh, b"%PDF")
    left = [
        fresh.certificates / name
        for name in ("draft-rabc.0123456789ab.pdf", ".draft-rabc.0123456789ab.json.1f.part")
    ]
    other = fresh.certificates / "A-2.pdf"  # may be evidence
    for path in (*left, other):
        path.write_bytes(b"%PDF")
        os.utime(path, times=(0, 0))
    young = fresh.certificates / "draft-rabd.0123456789ab.pdf"
    young.write_bytes(b"%PDF")
    named = {fault.what: fault.why for fault in verify(fresh)[1]}
    assert [str(path) in named and "mimucal prune" in named[str(path)] for path in left] == [
        True
    ] * 2
    assert delete(fresh) == []
    assert (young.exists(), other.exists(), *(path.exists() for path in left)) == (
        True, True, False, False,
    )  # fmt: skip
    gone = [entry.subject for entry in audit_trail.entries(fresh) if entry.action == "delete draft"]
    assert gone == sorted(path.name for path in left)
    assert {fault.what for fault in verify(fresh)[1]} == {str(other)}
