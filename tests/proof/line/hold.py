"""`make prove ARGS="--line 10000 --seed 1"`: a line's store, made of its seed."""

import json
import os
import time
from pathlib import Path

from flows.printing import stdout
from flows.progress import counting
from schemas.base import Unusable
from storage.home import Home
from tests.proof.line.draw import Line, draw_line, station_name
from tests.proof.line.recorded import Recorded
from tests.proof.line.store import fill

UNITS, RECORDED = 200, 48
RUNS_OF_A_UNIT = 5  # at least, of a small line


def run_line(seed: int, count: int, out: Path | None) -> None:
    """Makes the store; its answer lies sealed beside it. Raises Unusable for a folder in use."""
    folder = (out or Path(f"proof-line-{seed}")).absolute()
    home, line = Home(folder), draw_line(seed, count, min(UNITS, max(1, count // RUNS_OF_A_UNIT)))
    make_store(home, line, RECORDED)


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
    tilt = line.tilt
    return {
        "station": station_name(tilt.station), "effect": "axis_tilt",
        "since": tilt.since.isoformat(), "east_rad": tilt.east, "north_rad": tilt.north,
    }  # fmt: skip
