"""History made again: new results beside the old, exactly what moved, and nothing twice."""

import errno
import json
import shutil
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

import pytest

from flows import carry_out, execute
from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.certificate import Certificate
from schemas.history import Reprocessing
from schemas.orders import ReprocessOrder
from schemas.recording import Recording
from schemas.tolerance import Decision
from storage.catalogue import results, runs
from storage.home import Home
from tasks.stages import reprocess
from tasks.stages.reprocess import plan as planned_by
from tests.earlier_results import EARLIER, newest, plant, two_calibrated
from tests.keep import keep, take_number


@pytest.fixture(scope="module")
def calibrated(
    tmp_path_factory: pytest.TempPathFactory, ideal_run: Callable[..., Recording]
) -> Home:
    """Two runs, calibrated."""
    return two_calibrated(tmp_path_factory.mktemp("calibrated") / "home", ideal_run)


@pytest.fixture
def store(home: Path, calibrated: Home) -> Home:
    """A copy of them, where commands look."""
    shutil.copytree(calibrated.path, home)
    return Home(home)


def reprocessed(**order: Any) -> Reprocessing:
    return execute.reprocess(ReprocessOrder(workers=1, **order))


def test_the_same_code_changes_nothing_and_keeps_nothing_new(store: Home) -> None:
    report = reprocessed()
    assert (report.done, report.unchanged, report.failed) == (2, 2, 0)
    assert (report.changed, report.flips) == ((), ())
    for run in runs.all_runs(store):
        assert len(results.of_run(run, store)) == 1


def test_exactly_the_values_that_earlier_code_had_otherwise_are_reported(
    store: Home, tmp_path: Path
) -> None:
    first, second = newest(store)
    planted = plant(first, store, "gyro_scale_factor", "x", 3.0)
    report = reprocessed(out=str(tmp_path / "report"))
    (change,) = report.changed
    assert (change.run, change.item, change.element) == (first.run, "gyro_scale_factor", "x")
    assert change.before == planted.items["gyro_scale_factor"].value["x"]
    assert change.after == first.items["gyro_scale_factor"].value["x"]
    assert change.in_U == pytest.approx(3.0)
    assert newest(store) == [first, second]  # made again bit for bit
    kept = results.of_run(runs.find(first.run, store), store)
    assert [each.code_version for each in kept] == [first.code_version, EARLIER, first.code_version]
    assert "code_version" in str(kept[-1].why)
    written = json.loads((tmp_path / "report/report.json").read_text(encoding="utf-8"))
    assert len(written["changed"]) == 1


@pytest.mark.rehearsal
def test_an_order_by_version_goes_on_and_reports_all_of_it(store: Home) -> None:
    """What it made is of today's version, and still what it was ordered to report."""
    first, second = newest(store)
    plant(first, store, "gyro_scale_factor", "x", 3.0)
    of_first = reprocessed(code_version=EARLIER)
    assert len(of_first.changed) == 1
    plant(second, store, "gyro_scale_factor", "y", 2.0)  # as if it had not yet come to this one
    of_both = reprocessed(code_version=EARLIER)
    assert {each.run for each in of_both.changed} == {first.run, second.run}
    assert reprocessed(code_version=EARLIER).changed == of_both.changed
    planned = planned_by(ReprocessOrder(code_version=EARLIER), store)
    assert (planned.results, planned.done_before) == (0, 2)
    assert reprocessed(code_version="0.0.8").runs == 0


def test_a_value_that_is_gone_comes_first(store: Home) -> None:
    first, _ = newest(store)
    planted = plant(first, store, "gyro_scale_factor", "x", 3.0)
    name = "gyro_bias"
    lost = planted.items[name].model_copy(update={"value": planted.items[name].value | {"z": None}})
    results.save(planted.model_copy(update={"items": planted.items | {name: lost}}), store)
    changed = reprocessed().changed
    assert [(each.item, each.in_U is None) for each in changed] == [
        ("gyro_bias", True), ("gyro_scale_factor", False),
    ]  # fmt: skip


def test_a_report_that_cannot_be_written_leaves_the_earlier_one(
    store: Home, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    report = tmp_path / "report"
    reprocessed(out=str(report))
    before = (report / "report.json").read_bytes()

    def full(path: Path, *_: Any, **__: Any) -> int:
        path.touch()
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(Unusable, match=r"report\.json cannot be written .*--out"):
        reprocessed(out=str(report))
    assert (report / "report.json").read_bytes() == before
    assert len(list(report.iterdir())) == 4


def test_a_failed_recording_is_a_row_and_is_tried_again(
    store: Home, monkeypatch: pytest.MonkeyPatch
) -> None:
    bad, _ = runs.all_runs(store)
    estimate = reprocess.calibration_of

    def fails(run: Any, *more: Any) -> Calibration:
        if run.id == bad.id:
            raise ZeroDivisionError("a planted fault")
        return estimate(run, *more)

    monkeypatch.setattr(reprocess, "calibration_of", fails)
    report = reprocessed()
    assert (report.done, report.failed) == (1, 1)
    assert report.failures[0].run == bad.id
    assert "planted fault" in report.failures[0].why
    monkeypatch.setattr(reprocess, "calibration_of", estimate)
    again = reprocessed()
    assert (again.done, again.done_before, again.failed) == (2, 1, 0)


def test_a_dry_run_says_what_would_be_done_and_does_nothing(store: Home, mimucal) -> None:
    before = {path: path.stat().st_mtime_ns for path in store.raw.iterdir()}
    planned = mimucal("reprocess", "--dry-run", "--json", "--until", "2000-01-01").json
    assert planned["runs"] == []
    planned = mimucal("reprocess", "--dry-run", "--json").json
    assert (len(planned["runs"]), planned["results"], planned["done_before"]) == (2, 2, 0)
    assert {path: path.stat().st_mtime_ns for path in store.raw.iterdir()} == before
    assert all(len(results.of_run(run, store)) == 1 for run in runs.all_runs(store))


@pytest.mark.parametrize("option", ["station", "model", "serial", "procedure", "equipment"])
def test_a_name_that_no_run_has_is_refused_with_those_that_are_known(
    store: Home, mimucal, option: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(carry_out, "as_flow_run", pytest.fail)  # it needs no server
    for more in ((), ("--dry-run",)):
        refused = mimucal("reprocess", f"--{option}", "nobody", *more)
        assert refused.code == 2
        assert f"--{option} nobody" in refused.err
        known = runs.all_runs(store)[0].model_dump().get(option)
        assert known is None or str(known) in refused.err


def test_certificates_on_values_that_moved_are_touched(store: Home, mimucal, shared: Path) -> None:
    first, second = newest(store)
    plant(first, store, "gyro_scale_factor", "x", 3.0)
    touched = _certified(store, first.run)
    _certified(store, second.run)
    report = reprocessed()
    assert [each.number for each in report.certificates] == [touched]
    assert report.certificates[0].largest_in_U == pytest.approx(3.0)
    assert reprocessed().certificates == report.certificates


def test_a_certificate_whose_u_grew_is_reported_though_a_later_result_has_it_already(
    store: Home, tmp_path: Path
) -> None:
    """As where a limit of the table is registered after the certificate, and the run calibrated."""
    first, _ = newest(store)
    scale = first.items["gyro_scale_factor"]
    U = {**scale.U, "x": scale.U["x"] / 3.0}
    smaller = scale.model_copy(update={"U": U, "k": 3.0})
    printed = first.model_copy(
        update={"items": first.items | {"gyro_scale_factor": smaller}, "code_version": EARLIER}
    )
    results.save(printed, store)
    number = _certified(store, first.run)
    results.save(first.model_copy(update={"code_version": "0.1.0"}), store)  # who knows the limit
    store.tolerances.mkdir(parents=True)
    unit = runs.load(runs.find(first.run, store), store).manifest.unit
    limit = {"item": "gyro_scale_factor", "unit": "1", "elements": ["x"], "magnitude": 10.0}
    limits = {
        "format": "mimu-tolerance/1", "manufacturer": unit.manufacturer, "model": unit.model,
        "document": "wide", "limits": [limit],
    }  # fmt: skip
    (store.tolerances / "wide.json").write_text(json.dumps(limits), encoding="utf-8")
    report = reprocessed()
    moved = {each.element: each for each in report.changed if each.item == "gyro_scale_factor"}
    assert (moved["x"].k_before, moved["x"].k_after) == (3.0, scale.k)
    assert moved["x"].U_after == pytest.approx(3.0 * moved["x"].U_before)
    (touched,) = report.certificates
    assert (touched.number, touched.U_factor) == (number, pytest.approx(3.0))
    assert report.unchanged == 1
    assert "pass" not in [each.before for each in report.flips if each.about == "unit"]


def _certified(home: Home, run: str) -> str:
    """A certificate that prints the newest result of a run."""
    kept = runs.find(run, home)
    number = take_number(home, "T")
    day = date(2026, 11, 22)
    certificate = Certificate(
        number=number, state="issued", calibrated_on=day, issued_on=day, due=date(2027, 11, 22),
        laboratory=None, order=None, manifest=runs.load(kept, home).manifest,
        calibration=results.of_run(kept, home)[-1].calibration,
        decision=Decision(verdict="inconclusive", rule="simple", document=None, limits=()),
    )  # fmt: skip
    keep(certificate, home)
    return number


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("--since", "2026-03-02", "--until", "2026-03-01"), "--since 2026-03-02"),
        (("--engine", "dask"), "--scheduler"),
        (("--engine", "mpi"), "--engine mpi"),
        (("--out", "/dev/null/report"), "/dev/null/report"),
    ],
)
def test_an_order_that_cannot_be_is_one_sentence(
    mimucal, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], named: str
) -> None:
    monkeypatch.setattr(carry_out, "as_flow_run", pytest.fail)
    done = mimucal("reprocess", *arguments)
    assert done.code == 2
    assert named in done.err
    assert done.err.strip().count("\n") == 0
