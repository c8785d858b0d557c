"""`make prove ARGS="--fleets 60 --seed 1"`: sealed fleets, reviewed blind, as a page."""

import json
import os
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from flows.progress import counting
from schemas.review import RunStatistics
from storage.run_statistics import decoded, encoded
from tasks.explain.explain import explain
from tasks.review.pool import pooled
from tasks.review.report import review_of
from tasks.review.run_statistics import VERSION, statistics_of
from tasks.review.search import search
from tasks.review.several_recordings import reviewed_runs
from tasks.stages.fan_out import processors
from tests.proof.fleets.draw import Fleet, FleetRun, draw, drawn_runs
from tests.proof.fleets.judge import Judged, judged
from tests.proof.fleets.page import Alone, Many, page
from tests.proof.fleets.play import manifest_of_run, played
from tests.proof.report import publish

PAGE = "fleets.md"
MANY = 10_000  # runs of the search that is timed


def run_fleets(count: int, seed: int, write: bool) -> None:
    """Holds the trial. What was made of a fleet stays in proof-fleets-SEED, where the same command
    goes on.
    """
    folder = Path(f"proof-fleets-{seed}")
    context = get_context("spawn")
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    fleets = [draw(seed, number) for number in range(count)]
    with ProcessPoolExecutor(os.cpu_count(), context) as pool:
        work = [(fleet, run, folder) for fleet in fleets for run in fleet.runs]
        with counting("runs") as report:
            for done, _ in enumerate(pool.map(_made, work, chunksize=4), start=1):
                report(done, len(work))
        alone = list(pool.map(_explained, [(fleet, folder) for fleet in fleets]))
    outcomes = [_reviewed(fleet, folder) for fleet in fleets]
    text = page(seed, outcomes, alone, _many(folder))
    (folder / PAGE).write_text(text, encoding="utf-8")
    publish(PAGE, text, write, False)


def _file(folder: Path, fleet: Fleet, run: FleetRun) -> Path:
    return folder / "statistics" / f"{fleet.number:03d}" / f"{run.day:04d}"


def _made(work: tuple[Fleet, FleetRun, Path]) -> None:
    """Plays a run and keeps its statistics: all that is seen of it."""
    fleet, run, folder = work
    path = _file(folder, fleet, run)
    if path.exists():
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_suffix(".draft")
    draft.write_bytes(encoded(statistics_of(played(fleet, run)), VERSION))
    draft.rename(path)


def _explained(work: tuple[Fleet, Path]) -> Alone | None:
    """What `explain` says of the affected run in the middle, alone; nothing of a clean fleet."""
    fleet, folder = work
    affected = [run for run in fleet.runs if run.affected]
    if fleet.effect is None or not affected:
        return None
    path = folder / "alone" / f"{fleet.number:03d}.json"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        explanation = explain(played(fleet, affected[len(affected) // 2]))
        names = [[one.effect, *one.indistinguishable] for one in explanation.findings]
        path.write_text(json.dumps(names), encoding="utf-8")
    names = json.loads(path.read_text(encoding="utf-8"))
    return Alone(
        named=any(each == [fleet.effect.name] for each in names),
        among=any(fleet.effect.name in each for each in names),
        wrong=any(fleet.effect.name not in each and each[0] != "unnamed" for each in names),
    )


def _reviewed(fleet: Fleet, folder: Path) -> Judged:
    manifests = {f"fleet_{fleet.number}_{r.day:04d}": manifest_of_run(fleet, r) for r in fleet.runs}
    who = reviewed_runs(manifests)
    files = [_file(folder, fleet, run) for run in fleet.runs]
    pool = pooled([(who[name], _read(file)) for name, file in zip(who, files, strict=True)])
    return judged(fleet, review_of(pool, *search(pool)))


def _read(path: Path) -> RunStatistics:
    return decoded(path.read_bytes(), VERSION)


def _many(folder: Path) -> Many:
    """A search over thousands of kept statistics of units and stations drawn anew, timed."""
    files: Sequence[Path] = sorted((folder / "statistics").glob("*/*"))
    began, processor = time.perf_counter(), time.process_time()
    with ThreadPoolExecutor(processors()) as threads:
        kept = list(threads.map(_read, (files[k % len(files)] for k in range(MANY))))
    read = time.perf_counter()
    search(pooled(list(zip(drawn_runs(MANY), kept, strict=True))))
    searched, used = time.perf_counter() - read, time.process_time() - processor
    size = float(np.mean([file.stat().st_size for file in files]))
    return Many(MANY, read - began, searched, used, size)
