"""Stage: recordings of a folder are imported, and their statistics made once and kept."""

from datetime import date
from pathlib import Path

import pytest

from schemas.base import Unusable
from schemas.orders import ReviewOrder
from storage import run_statistics
from storage.home import Home
from tasks.review.run_statistics import VERSION
from tasks.stages.review import review_runs
from tests.proof.plant.case import Case
from tests.proof.plant.simulate import simulate, write


def nothing(done: int, total: int) -> None:
    pass


def test_a_folder_is_reviewed_and_its_statistics_are_kept(tmp_path: Path) -> None:
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


def test_what_the_selection_leaves_nothing_of_is_said(tmp_path: Path) -> None:
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


def test_a_store_without_runs_has_nothing_to_review(tmp_path: Path) -> None:
    with pytest.raises(Unusable, match="2 runs or more, and 0"):
        review_runs(ReviewOrder(), Home(tmp_path), nothing)


def test_dates_the_wrong_way_round_are_one_sentence(tmp_path: Path) -> None:
    order = ReviewOrder(since=date(2027, 1, 1), until=date(2026, 1, 1))
    with pytest.raises(Unusable, match="--since 2027-01-01 is after --until 2026-01-01"):
        review_runs(order, Home(tmp_path), nothing)
