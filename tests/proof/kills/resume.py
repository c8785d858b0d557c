"""An acquisition that is killed and goes on: its values against those of an uninterrupted run."""

import random
import time
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Calibration, Item
from schemas.procedure import Procedure
from schemas.recording import MEASURED, Recording
from schemas.station import StationFile
from storage.catalogue import runs
from storage.catalogue.listing import Run
from storage.home import Home
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.evaluation import evaluation_for
from tasks.specifications.register import specification_for
from tasks.stages.acquire import acquire_run
from tasks.stages.left_run import left_runs
from tasks.station.acquisition import Acquired
from tasks.station.interrupted import interrupted
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.process import running
from tests.proof.faults.outcome import comes_to_rest
from tests.proof.kills.kill import acquire_and_kill
from tests.tasks.station.over_sockets import ignore

SPEED = 40.0
PAGE = "resumes.md"
LATEST = 0.9  # of the time that the uninterrupted run takes
COLUMNS = (
    "seed", "kill after (s)", "segments kept", "measured then", "run", "largest difference (U)",
    "of",
)  # fmt: skip


@dataclass(frozen=True)
class Resumed:
    """One run that was killed and went on.

    kept: measured segments that stood after the kill; again: those that were then measured.
    validity: the verdict on the run. worst: its largest difference from the uninterrupted run, by
    the U of that difference, and of which element.
    """

    seed: int
    after_s: float
    kept: int
    again: int
    validity: str
    worst: float
    element: str

    @property
    def holds(self) -> bool:
        return self.worst <= 1.0


def hold(
    folder: Path, count: int, procedure: Procedure, report: Callable[[int, int], None]
) -> list[Resumed]:
    """An uninterrupted run, and kills of the seeds 1 to count; resumes.md in the folder."""
    config = VirtualStation()
    with running(config, SPEED) as station:
        began_s = time.monotonic()
        ((whole, _),) = acquire_run(station, procedure, Home(folder / "whole"), ignore).kept
        takes_s = time.monotonic() - began_s
    uninterrupted = _calibrated(runs.load(whole, Home(folder / "whole")))
    found = []
    for seed in range(1, count + 1):
        after_s = random.Random(seed).uniform(0.0, LATEST * takes_s)
        home = Home(folder / f"{seed:03d}")
        with running(config, SPEED) as station:
            run, acquired, kept = killed_and_resumed(station, procedure, home, after_s)
        resumed = _calibrated(runs.load(run, home))
        segments = sum(each.kind in MEASURED for each in acquired.manifest.segments or ())
        differs = worst_difference(resumed, uninterrupted)
        verdict = resumed.validity.verdict
        found.append(Resumed(seed, after_s, kept, segments - kept, verdict, *differs))
        report(len(found), count)
        (folder / PAGE).write_text(as_markdown(found), encoding="utf-8")
    return found


def killed_and_resumed(
    station: StationFile, procedure: Procedure, home: Home, after_s: float
) -> tuple[Run, Acquired, int]:
    """A run that is killed so long (s) after its first bytes, and then goes on; and how many of
    its measured segments stood after the kill.

    Where the kill left no reading, it begins anew. Raises Unusable where the table did not come to
    rest after the kill, and as `acquire_run` does.
    """
    home.path.mkdir(parents=True, exist_ok=True)
    files = home.path / "station.json", home.path / "procedure.json"
    for file, content in zip(files, (station, procedure), strict=True):
        file.write_text(content.model_dump_json(), encoding="utf-8")
    acquire_and_kill(*files, home.path, after_s)
    if not comes_to_rest(station, VirtualStation().unit.gyro.lsb):
        raise Unusable("the table still turns, long after the acquisition was killed")
    try:
        (left,) = left_runs(station, procedure, home).values()
    except Unusable:
        (kept,) = acquire_run(station, procedure, home, ignore).kept
        return *kept, 0
    stood = len(interrupted(left.recording, station.unit_link).measured())
    (kept,) = acquire_run(station, procedure, home, ignore, resume=True).kept
    return *kept, stood


def _calibrated(recording: Recording) -> Calibration:
    return calibrate(
        specification_for(recording.manifest.standard), recording, run="", code_version="",
        evaluation=evaluation_for(recording),
    )  # fmt: skip


def worst_difference(one: Calibration, other: Calibration) -> tuple[float, str]:
    """The largest difference of a value in units of that of its two U, and of which element it is.

    A value that only one of them has differs without bound.
    """
    worst, where = 0.0, ""
    for name, item in one.items.items():
        for element, value in item.value.items():
            against, reach = (
                other.items[name].value[element],
                _reach(item, other.items[name], element),
            )
            if (value is None) != (against is None):
                return float("inf"), f"{name}.{element}"
            if value is not None and against is not None and reach:
                worst, where = max(
                    (worst, where), (abs(value - against) / reach, f"{name}.{element}")
                )
    return worst, where


def _reach(one: Item, other: Item, element: str) -> float:
    """Expanded uncertainty of the difference of two independent values, as in E_n."""
    return float(np.hypot(one.U.get(element) or 0.0, other.U.get(element) or 0.0))


def summary(found: Sequence[Resumed]) -> str:
    """One sentence."""
    return (
        f"{len(found)} acquisitions killed at random moments and gone on with: "
        f"{sum(each.holds for each in found)} have the values of an uninterrupted run within "
        f"U; the largest difference is {max(each.worst for each in found):.2f} U"
    )


def as_markdown(found: Sequence[Resumed]) -> str:
    """The summary, how it was held, and a row for each run."""
    rows = [
        f"| {seed} | {after:.1f} | {kept} | {again} | {validity} | {worst:.2f} | {element} |"
        for seed, after, kept, again, validity, worst, element in map(astuple, found)
    ]
    return "\n".join([
        "# Runs that were killed and went on",
        "",
        f"{summary(found)}.",
        "",
        f"Each on a virtual station of its own, with the same unit, at {SPEED:g} times the clock:",
        "the acquisition is killed (SIGKILL), the watchdog brings the table to rest, and",
        "`acquire --resume` measures what is missing. Differences are counted in the expanded",
        "uncertainty U of a difference of two such values, √(U₁² + U₂²), as E_n does.",
        "",
        f"| {' | '.join(COLUMNS)} |",
        f"|{'---|' * len(COLUMNS)}",
        *rows,
        "",
    ])  # fmt: skip
