"""Random faults at random times, each in a run of its own; a table of how they ended."""

import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cache

import numpy as np

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.recording import Recording
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import FAULTS, StationFault
from tests.proof.faults.client import OF_THE_CLIENT
from tests.proof.faults.judge import kind, violations
from tests.proof.faults.run_with_fault import IN_REAL_TIME, procedure_of, run_in_memory, run_with
from tests.proof.report import EVIDENCE, table

LATEST_S = 600.0  # station time: a sound run takes a bit longer
LATEST_IN_REAL_TIME_S = 200.0  # of a briefer run, on a station that is slower than it was asked
KINDS = ("recovered", "repeated", "remarks", "invalid", "stopped")
AT_ONCE = 6  # some wait for their stations
NOT_IN_THIS_PROCEDURE = ("fixture_stays",)


WHAT_HAPPENS = {name: what for name, (_, what) in FAULTS.items()} | OF_THE_CLIENT


@dataclass(frozen=True)
class Ended:
    """How a run with a fault ended: one of KINDS, with what must not be, and its sentence."""

    fault: StationFault
    how: str
    violations: list[str]
    sentence: str


def drawn(seed: int, count: int) -> list[StationFault]:
    """As many faults, every name in turn, each at a random time."""
    rng = np.random.default_rng(seed)
    names = [name for name in WHAT_HAPPENS if name not in NOT_IN_THIS_PROCEDURE]
    order = [str(name) for _ in range(count // len(names) + 1) for name in rng.permutation(names)]
    return [
        StationFault(name, round(rng.uniform(0.0, _latest_s(name)), 1)) for name in order[:count]
    ]


def _latest_s(name: str) -> float:
    return LATEST_IN_REAL_TIME_S if name in IN_REAL_TIME else LATEST_S


def run_faults(count: int, seed: int, write: bool) -> None:
    """Hold the runs and print their table, which grows as they end.

    Raises Unusable where anything is violated.
    """
    began_s, found = time.monotonic(), []
    with ProcessPoolExecutor(AT_ONCE) as pool:
        faults = sorted(drawn(seed, count), key=lambda fault: fault.name in IN_REAL_TIME)
        for done in as_completed([pool.submit(run_one, fault) for fault in faults]):
            found.append(one := done.result())
            response = "; ".join(one.violations) or one.sentence[:110]
            print(f"{one.fault!s:30} {one.how:10} {response}", flush=True)
            if write:
                text = page(found, seed, time.monotonic() - began_s)
                (EVIDENCE / "faults.md").write_text(text, encoding="utf-8")
    print(page(found, seed, time.monotonic() - began_s))
    if wrong := sum(bool(one.violations) for one in found):
        raise Unusable(f"{wrong} of {count} runs with a fault did not end as they should")


def run_one(fault: StationFault) -> Ended:
    """One run with a fault, and how it is judged."""
    try:
        outcome = run_with(fault, VirtualStation())
    except Unusable as failure:
        return Ended(fault, "stopped", [f"it was not held: {failure}"], "")
    against = violations(fault.name, outcome, _sound(procedure_of(fault.name)))
    return Ended(fault, kind(outcome), against, outcome.sentence)


@cache
def _sound(procedure: Procedure) -> Recording:
    sound = run_in_memory(procedure, VirtualStation()).recording
    assert sound is not None
    return sound


def page(found: Sequence[Ended], seed: int, seconds: float) -> str:
    """The table of how runs with each fault ended."""
    ended: dict[str, Counter[str]] = {}
    for one in found:
        ended.setdefault(one.fault.name, Counter())[one.how] += 1
    wrong = [f"{one.fault}: {'; '.join(one.violations)}" for one in found if one.violations]
    rows = [
        (f"`{name}`", WHAT_HAPPENS[name], *(counts[how] or "" for how in KINDS))
        for name, counts in sorted(ended.items())
    ]
    return "\n".join([
        "# Runs in which something fails", "",
        f"{len(found)} runs of a short procedure (seed {seed}, {seconds:.0f} s), each with one "
        "fault of the station or of the computer that acquires, from a random time on: "
        f"{len(wrong)} violations.", "",
        "Recovered: valid, with the values of the sound run. Repeated: so, after segments were "
        "measured again. Remarks: with those values, and no unit passes. Invalid: no "
        "verdict. Stopped: one sentence. The table is at rest at the end.", "",
        *table(("fault", "what happens", *KINDS), rows), "",
        *(f"- {each}" for each in wrong),
    ]).rstrip() + "\n"  # fmt: skip
