"""Stage: recordings of a folder are imported, and their statistics made once and kept."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.discrepancy import Consequence
from schemas.orders import ExplainOrder, ReviewOrder
from storage import run_statistics
from storage.catalogue import certificates, runs
from storage.home import Home
from tasks.review.pool import VERSION
from tasks.review.report import review_of
from tasks.review.search import search
from tasks.review.windows import rows_of
from tasks.stages import review
from tasks.stages.explain import explain_together
from tasks.stages.review import review_runs
from tests.drafts import draft, recording_of
from tests.proof.plant.case import Case
from tests.proof.plant.simulate import simulate, write
from tests.tasks.review.fleet import fleet, of


def nothing(done: int, total: int) -> None:
    pass


def test_a_folder_is_reviewed_and_its_statistics_are_kept(tmp_path):
    home, folder = Home(tmp_path / "home"), tmp_path / "recordings"
    for seed in (1, 2):
        case = Case(seed=seed, procedure="rests", rate_hz=20, dwell_s=5.0)
        write(simulate(case).recording, folder / f"{seed}")
    (folder / "empty").mkdir()
    order = ReviewOrder(paths=(str(folder),), out=str(tmp_path / "out"))
    reviewed = review_runs(order, home, nothing)
    assert (reviewed.review.runs, reviewed.review.verdict) == (2, "no_mismatch")
    assert [Path(one.run).name for one in reviewed.review.skipped] == ["empty"]
    assert reviewed.files[0].read_text(encoding="utf-8").startswith("{")
    kept = sorted((home.path / run_statistics.FOLDER).iterdir())
    assert [run_statistics.load(path.name, VERSION, home) is not None for path in kept] == [
        True,
        True,
    ]
    made = [path.stat().st_mtime_ns for path in kept]
    again = review_runs(ReviewOrder(), home, nothing)
    assert again.review.findings == reviewed.review.findings
    assert [path.stat().st_mtime_ns for path in kept] == made


def test_what_the_selection_leaves_nothing_of_is_said(tmp_path):
    home, folder = Home(tmp_path / "home"), tmp_path / "recordings"
    case = Case(seed=1, procedure="rests", rate_hz=20, dwell_s=5.0)
    write(simulate(case).recording, folder / "1")
    of_folder = ReviewOrder(paths=(str(folder),), station="nowhere")
    with pytest.raises(Unusable, match="none of the 1 recordings of PATH"):
        review_runs(of_folder, home, nothing)
    with pytest.raises(Unusable, match="--station nowhere: no run"):
        review_runs(ReviewOrder(station="nowhere"), home, nothing)
    with pytest.raises(Unusable, match="PATH is empty"):  # a script's variable that is not set
        review_runs(ReviewOrder(paths=("",)), home, nothing)


# Stage: the certificates that stand on a finding's runs, and no others.

MOVED = Consequence(item="gyro_bias", element="x", before=0.25, after=0.3, U=0.02, unit="deg/s")


def test_only_certificates_on_its_runs_are_looked_at(tmp_path, monkeypatch):
    home = Home(tmp_path)
    draft(home, "1")
    draft(home, "2")
    entries = certificates.register(home)
    chosen = {entry.run: runs.find(entry.run, home) for entry in entries}
    pool = fleet(1, lambda unit, station, day: of("axis_tilt", 2.0 * (station == 2)))
    (one,), p_value = search(pool)
    rows = rows_of(pool, one.best.window)
    names = [run.run for run in pool.runs]
    names[int(np.argmax(rows))] = entries[0].run
    names[int(np.argmin(rows))] = entries[1].run
    renamed = tuple(replace(r, run=n) for r, n in zip(pool.runs, names, strict=True))
    one = replace(one, pool=replace(pool, runs=renamed))
    monkeypatch.setattr(review, "moved_elements", lambda recording, effect, values, limits: [MOVED])
    completed = review.with_certificates(review_of(pool, (one,), p_value), (one,), chosen, home)
    (found,) = completed.findings[0].touched
    assert (found.certificate, found.in_U) == (entries[0].number, pytest.approx(2.5))


# Stage: what cannot be explained together is refused in one sentence.


def test_recordings_of_different_units_are_refused(tmp_path):
    home = Home(tmp_path)
    which = [runs.add(recording_of(serial), home)[0] for serial in ("1", "2")]
    with pytest.raises(Unusable, match=r"different units \(Maker U 1, Maker U 2\)"):
        explain_together(which, home, ExplainOrder(run=which[0].id, others=(which[1].id,)))


def test_a_recording_named_twice_is_refused(tmp_path):
    home = Home(tmp_path)
    run, _ = runs.add(recording_of("1"), home)
    with pytest.raises(Unusable, match="named twice"):
        explain_together([run, run], home, ExplainOrder(run=run.id, others=(run.id,)))
