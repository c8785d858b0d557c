"""Results made again: noted once for each circumstances, beside the results before."""

import pytest

from storage.catalogue import results, runs
from storage.catalogue.results import keep, keep_fault, made_under, to_make
from storage.catalogue.runs import Run
from tests.storage.small import calibrated, small


@pytest.fixture
def run(fresh) -> Run:
    return runs.add(small(), fresh)[0]


def test_each_newest_result_is_made_again_and_a_run_without_any_once(fresh, run):
    bare = runs.add(small(1.0), fresh)[0]
    results.save(calibrated(run), fresh)
    newest = results.save(calibrated(run, 0.5), fresh)
    joint = results.save(calibrated(run, method="joint"), fresh)
    waiting = to_make([run, bare], "now", fresh)
    assert {(each.run.id, each.before) for each in waiting} == {
        (run.id, newest), (run.id, joint), (bare.id, None),
    }  # fmt: skip


def test_what_was_made_is_not_made_again_under_the_same_circumstances_alone(fresh, run):
    before = results.save(calibrated(run), fresh)
    (waiting,) = to_make([run], "now", fresh)
    after = keep(waiting, calibrated(run, 0.5), "now", 1.0, fresh)
    assert to_make([run], "now", fresh) == []
    assert [each.before for each in to_make([run], "later", fresh)] == [after]
    (made,) = made_under("now", fresh)
    assert (made.before, made.after, made.fault) == (before, after, None)
    assert [each.id for each in results.of_run(run, fresh)] == [before, after]


def test_a_first_result_is_not_made_twice(fresh, run):
    (waiting,) = to_make([run], "now", fresh)
    keep(waiting, calibrated(run), "now", 1.0, fresh)
    assert to_make([run], "now", fresh) == []


def test_what_failed_is_tried_again_and_then_fails_no_more(fresh, run):
    results.save(calibrated(run), fresh)
    (waiting,) = to_make([run], "now", fresh)
    for why in ("the disk was off", "it still was"):
        keep_fault(waiting, why, "now", 1.0, fresh)
        assert [each.fault for each in made_under("now", fresh)] == [why]
        assert to_make([run], "now", fresh) == [waiting]
    keep(waiting, calibrated(run), "now", 1.0, fresh)
    assert [each.fault for each in made_under("now", fresh)] == [None]


def test_result_and_note_are_kept_both_or_neither(fresh, run, monkeypatch):
    (waiting,) = to_make([run], "now", fresh)

    def power_cut(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(results, "_note", power_cut)
    with pytest.raises(KeyboardInterrupt):
        keep(waiting, calibrated(run), "now", 1.0, fresh)
    assert results.of_run(run, fresh) == []
    assert made_under("now", fresh) == []
