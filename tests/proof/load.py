"""Demonstrations on a computer whose every core is busy: whole, or invalid and said so.

Each has a validation record of this code in its home, so that a verdict is not withheld for a
record that is out of date; whether the shipped one is, is said.
"""

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tasks.validation.fingerprint import fingerprint
from tasks.validation.record import shipped
from tasks.version import code_version
from tests.proof.study import Count, Out, Seed, Write, folder_of, hold, table

LONGEST_S = 1800.0
FALSE_U = 2.0  # this far off, by U with k = 2, is four standard uncertainties
COMMAND = [sys.executable, "-c", "from flows.cli import main; main()"]
LOOP = [sys.executable, "-c", "while True: pass"]
MATRICES = {"gyro": "Kg", "accel": "Ka"}
COLUMNS = ("run", "outcome", "validity", "verdict", "worst in U", "load", "s", "what was said")


@dataclass(frozen=True)
class LoadedRun:
    """What became of one demonstration.

    outcome: whole, undecided (valid, and no verdict on the unit), invalid (no verdict either),
    stopped (with a sentence), or false.
    worst: the largest error of scale factors and cross couplings against the truth, in U.
    load: of the computer over the last minute, at the end.
    """

    number: int
    outcome: str
    validity: str
    verdict: str
    worst: float
    load: float
    seconds: float
    response: str

    @property
    def holds(self) -> bool:
        return self.outcome in ("whole", "invalid")


def load(count: Count = 20, seed: Seed = 1, out: Out = None, write: Write = False) -> None:
    """Demonstrations while every core is busy: whole, or invalid and said so."""
    folder = folder_of("load", out)
    work = {f"{number:04d}": number for number in range(seed, seed + count)}
    with busy(os.cpu_count() or 1):
        hold("load", work, partial(_one, folder), as_markdown, out, write=write, at_once=0,
             faults=lambda one: [] if one.holds else [f"{one.number}: {one.outcome}"])  # fmt: skip


@contextmanager
def busy(cores: int) -> Iterator[None]:
    """Endless loops, one for each core, for the length of the block."""
    loops = [subprocess.Popen(LOOP) for _ in range(cores)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def _one(folder: Path, number: int) -> LoadedRun:
    home = folder / f"{number:04d}"
    shutil.rmtree(home, ignore_errors=True)
    _have_validated(home)
    began_s = time.monotonic()
    made, response = _mimucal(home, "demo", "--json", "--seed", str(number))
    seconds, load = time.monotonic() - began_s, os.getloadavg()[0]
    if made is None:
        outcome = "stopped" if response.count("\n") == 0 and response else "false"
        return LoadedRun(number, outcome, "", "", 0.0, load, seconds, response)
    validity, verdict = made["validity"]["verdict"], made["verdict"]
    if verdict == "inconclusive" and validity != "invalid" and _all_pass(made):
        verdict = "pass"  # of the unit: what is open are the papers of virtual standards
    shown, _ = _mimucal(home, "show", made["run"], "--json")
    truth = json.loads(Path(made["paths"]["truth"]).read_text(encoding="utf-8"))
    items = shown["results"][-1]["calibration"]["items"] if shown else {}
    worst = worst_in_U(items, truth)
    reasons = "; ".join(made["validity"]["reasons"])
    outcome = outcome_of(validity, verdict, worst)
    return LoadedRun(number, outcome, validity, verdict, worst, load, seconds, reasons)


def _all_pass(made: Mapping[str, Any]) -> bool:
    """Whether every limited element passed."""
    record = json.loads(Path(made["paths"]["record"]).read_text(encoding="utf-8"))
    limits = record["decision"]["limits"]
    return bool(limits) and all(limit["verdict"] == "pass" for limit in limits)


def _have_validated(home: Path) -> None:
    """The shipped record in a new home, as one of this code."""
    home.mkdir()
    if record := shipped():
        own = record.model_copy(update={"code_version": code_version()})
        (home / "validation.json").write_text(own.model_dump_json(), encoding="utf-8")


def shipped_is_stale() -> bool:
    """Whether the shipped record is of another code than this one, for any method."""
    record = shipped()
    return record is None or any(
        method.fingerprint != fingerprint(name) for name, method in record.methods.items()
    )


def _mimucal(home: Path, *arguments: str) -> tuple[dict[str, Any] | None, str]:
    """The document of a command, None where it failed; and what it said on standard error."""
    done = subprocess.run(
        [*COMMAND, *arguments], capture_output=True, text=True, timeout=LONGEST_S,
        env=os.environ | {"MIMUCAL_HOME": str(home)},
    )  # fmt: skip
    return json.loads(done.stdout) if done.returncode == 0 else None, done.stderr.strip()


def worst_in_U(items: Mapping[str, Any], truth: Mapping[str, Any]) -> float:
    """The largest error of a scale factor or cross coupling in units of its U."""
    errors = [0.0]
    for sensor, matrix in MATRICES.items():
        for name in (f"{sensor}_scale_factor", f"{sensor}_cross_coupling"):
            item = items.get(name, {"value": {}, "U": {}})
            for element, value in item["value"].items():
                if value is not None and item["U"][element]:
                    row, column = ("xyz".index(axis) for axis in (element[0], element[-1]))
                    errors.append(abs(value - truth[matrix][row][column]) / item["U"][element])
    return max(errors)


def outcome_of(validity: str, verdict: str, worst: float) -> str:
    """Of a unit that conforms: a run that is not invalid must be right, and not fail it."""
    if validity == "invalid":
        return "invalid" if verdict == "inconclusive" else "false"
    if verdict == "fail" or worst > FALSE_U:
        return "false"
    return "undecided" if validity == "valid" and verdict != "pass" else "whole"


def summary(found: list[LoadedRun]) -> str:
    """How many held."""
    return (
        f"{len(found)} demonstrations with every core busy: {sum(one.holds for one in found)} "
        f"whole, or invalid and said so; false {sum(one.outcome == 'false' for one in found)}."
    )


def as_markdown(found: list[LoadedRun]) -> str:
    """What came out in all, then a row for each run."""
    record = (
        f"The validation record that ships is {'not ' if shipped_is_stale() else ''}of this code "
        f"({code_version()}); a copy in the name of this code stood in each home."
    )
    head = ("# Demonstrations under load", "", summary(found), "", record, "")
    return "\n".join((*head, *table(COLUMNS, map(_row, found)), ""))


def _row(one: LoadedRun) -> tuple[str, ...]:
    return (
        str(one.number), one.outcome, one.validity, one.verdict, f"{one.worst:.2f}",
        f"{one.load:.1f}", f"{one.seconds:.0f}", one.response,
    )  # fmt: skip
