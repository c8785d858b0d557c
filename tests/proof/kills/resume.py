"""An acquisition that is killed and goes on: its values against those of an uninterrupted run."""

import random
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import astuple, dataclass, replace
from pathlib import Path

import numpy as np

from schemas.calibration import Calibration, Item
from schemas.procedure import Procedure
from schemas.recording import MEASURED, Recording
from storage.catalogue import runs
from storage.home import Home
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.evaluation import evaluation_for
from tasks.specifications.register import specification_for
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.process import running
from tests.proof.faults.run_with_fault import run_in_memory
from tests.proof.kills.go_on import SPEED, killed_and_resumed
from tests.proof.report import table

AT_ONCE = 3
PAGE = "resumes.md"
LATEST = 0.9  # of the time that an uninterrupted run takes at least
WARM_UP_S = 600.0  # of JJF 2003: a unit that is still cold has other biases
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
    worst: float = 0.0
    element: str = ""

    @property
    def holds(self) -> bool:
        return self.worst <= 1.0


def run_all(
    folder: Path, count: int, procedure: Procedure, report: Callable[[int, int], None]
) -> list[Resumed]:
    """An uninterrupted run, and kills of the seeds 1 to count; resumes.md in the folder."""
    whole = run_in_memory(procedure, VirtualStation()).recording
    assert whole is not None
    uninterrupted, latest_s = _calibrated(whole), LATEST * float(whole.imu.t[-1]) / SPEED
    found = []
    with ProcessPoolExecutor(AT_ONCE) as pool:
        seeds = range(1, count + 1)
        earliest_s = procedure.warm_up_s / SPEED
        begun = [pool.submit(_one, seed, folder, procedure, earliest_s, latest_s) for seed in seeds]
        for done in as_completed(begun):
            resumed, one = done.result()
            worst, element = worst_difference(resumed, uninterrupted)
            found.append(replace(one, worst=worst, element=element))
            report(len(found), count)
            (folder / PAGE).write_text(as_markdown(found), encoding="utf-8")
    return found


def _one(
    seed: int, folder: Path, procedure: Procedure, earliest_s: float, latest_s: float
) -> tuple[Calibration, Resumed]:
    after_s = random.Random(seed).uniform(earliest_s, latest_s)
    home = Home(folder / f"{seed:03d}")
    with running(VirtualStation(), SPEED) as station:
        run, acquired, kept = killed_and_resumed(station, procedure, home, after_s)
    resumed = _calibrated(runs.load(run, home))
    segments = sum(each.kind in MEASURED for each in acquired.manifest.segments or ())
    return resumed, Resumed(seed, after_s, kept, segments - kept, resumed.validity.verdict)


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
        (seed, f"{after:.1f}", kept, again, validity, f"{worst:.2f}", element)
        for seed, after, kept, again, validity, worst, element in map(
            astuple, sorted(found, key=lambda each: each.seed)
        )
    ]
    return "\n".join([
        "# Runs that were killed and went on",
        "",
        f"{summary(found)}.",
        "",
        f"Each on a virtual station of its own, with the same unit, at {SPEED:g} times the clock:",
        f"after the warm-up of {WARM_UP_S:g} s the acquisition is killed (SIGKILL), the watchdog",
        "brings the table to rest, and `acquire --resume` warms up and measures what is missing.",
        "The uninterrupted run is of the same procedure, in simulated time. Differences are",
        "counted in the expanded uncertainty U of a difference of two such values,",
        "√(U₁² + U₂²), as E_n does.",
        "",
        *table(COLUMNS, rows),
        "",
    ])  # fmt: skip
