"""`make prove ARGS="--line 10000 --seed 1"`: a line's store, made of its seed, and judged."""

import json
import os
import time
from pathlib import Path

import numpy as np
import typer

from flows.printing import stdout
from flows.progress import counting
from schemas.base import Unusable
from schemas.orders import ExplainOrder, ReviewOrder
from storage.catalogue.run_index import find
from storage.home import Home
from tasks.stages.explain import explain_run
from tasks.stages.review import review_runs
from tests.proof.line.draw import Line, draw_line, station_name
from tests.proof.line.judge import TILTED, Judged, judge
from tests.proof.line.physics import measured_by_grade
from tests.proof.line.recorded import Recorded
from tests.proof.line.store import fill, recorded_runs

UNITS, RECORDED, EXPLAINED = 200, 48, 12
RUNS_OF_A_UNIT = 5  # at least, of a small line
PAGE = Path(__file__).parents[1] / "evidence" / "line.md"
TEXT = """# A line with years behind it

`make prove ARGS="--line {runs} --seed {seed}"`: {runs:,} runs of {units} units of 4 models on 6
stations over three years, made in {made:.0f} s. Each unit has true coefficients that drift, and
some are adjusted; each run measures them with noise of its stated U; some runs are invalid, fail,
lack an item, are retests. One station is tilted from a day on: which one, and when, lies in a file
outside of the store until the pages have answered. {recorded} of the runs have recordings of the
independent plant; `mimucal review` pools these, and `mimucal explain` answers {explained} of them.

| what | answered | held against |
|---|---:|---|
| numbers of the Quality page that the catalogue has, too | {same} of {numbers} | SQL, and numpy |
| numbers of Line, Runs, Unit, Due and Mismatch | {same_others} of {numbers_others} | the same |
| the tilted station on the Mismatch page | {found} | {truth} |
| since | {since} | {since_truth} |
| size, east and north (µrad) | {size} | {size_truth} |
| stations off by more than 2 U on the Quality page in what a tilt moves | {off} | {truth} |
| names in single runs of the tilted station, since then | {named} | `axis_tilt` |
| names in single runs of the others | {others} | none |

The tilt moves that station's mean by {power} U of the comparison of stations; from 3 U on the comparison
must find it, below that it has too little power for so few runs, and the Mismatch page alone must.

Faults: {faults}.
"""


def run_line(count: int, seed: int, write: bool, out: Path | None = None) -> None:
    """Makes the store, has it reviewed and judges the pages; exit 1 where one is wrong.

    Its answer lies sealed beside it. write: into the evidence. Raises Unusable for a folder in use.
    """
    home = Home((out or Path(f"proof-line-{seed}")).absolute())
    line, made = make_line(seed, count, home)
    judged = judge(home, json.loads(answer_of(home).read_text(encoding="utf-8")))
    page = page_of(line, made, judged)
    stdout(markup=False).print(page)
    (PAGE if write else home.path / PAGE.name).write_text(page, encoding="utf-8")
    if judged.faults:
        raise typer.Exit(1)


def make_line(seed: int, count: int, home: Home) -> tuple[Line, float]:
    """The store of a line that was reviewed, in a new folder, and how long its runs took in s."""
    line = draw_line(seed, count, min(UNITS, max(1, count // RUNS_OF_A_UNIT)))
    made = make_store(home, line, RECORDED)
    look_back(home)
    return line, made


def look_back(home: Home, explained: int = EXPLAINED) -> None:
    """What the laboratory would do: a review of the recorded runs, and `explain` for the last."""
    recorded = tuple(recorded_runs(home))
    with counting("statistics") as report:
        review_runs(ReviewOrder(paths=recorded), home, report)
    last = recorded[-explained:]
    with counting("explanations") as report:
        for done, run in enumerate(last, start=1):
            explain_run(find(run, home), home, ExplainOrder(run=run))
            report(done, len(last))


def page_of(line: Line, made: float, judged: Judged) -> str:
    """The evidence as Markdown."""
    return TEXT.format(
        runs=line.runs, seed=line.seed, units=len(line.units), made=made, recorded=RECORDED,
        explained=EXPLAINED, faults="; ".join(judged.faults) or "none", **judged.declared,
    )  # fmt: skip


def make_store(home: Home, line: Line, recorded: int) -> float:
    """Seals the answer, makes the store, and gives how long that took in seconds."""
    if home.path.exists() and any(home.path.iterdir()):
        raise Unusable(f"--out {home.path} is not empty; a store needs a folder of its own")
    os.environ["MIMUCAL_HOME"] = str(home.path)
    home.path.mkdir(parents=True, exist_ok=True)
    answer_of(home).write_text(json.dumps(answer(line), indent=1) + "\n", encoding="utf-8")
    began = time.perf_counter()
    with counting("runs of the line") as report:
        fill(home, line, Recorded(recorded), report)
    seconds = time.perf_counter() - began
    stdout(markup=False).print(f"{line.runs} runs in {seconds:.0f} s: {home.path}")
    return seconds


def answer_of(home: Home) -> Path:
    """Where the answer lies: outside of the store."""
    return home.path.with_name(f"{home.path.name}.answer.json")


def answer(line: Line) -> dict[str, object]:
    """What is to be found."""
    tilt, measured = line.tilt, measured_by_grade(line)
    item, element = TILTED
    return {
        "station": station_name(tilt.station), "effect": "axis_tilt",
        "shift": float(np.mean([measured[unit.grade].shift[item][element] for unit in line.units])),
        "since": tilt.since.isoformat(), "east_rad": tilt.east, "north_rad": tilt.north,
    }  # fmt: skip
