"""Random faults at random times, each in a run of its own; a table of how they ended."""

import time
from collections import Counter
from pathlib import Path

import numpy as np

from schemas.base import Unusable
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import FAULTS, StationFault
from tests.proof.faults.judge import kind, violations
from tests.proof.faults.run import OVER_SOCKETS, run_with

EVIDENCE = Path(__file__).parents[1] / "evidence" / "faults.md"
LATEST_S, LATEST_OVER_SOCKETS_S = 600.0, 100.0  # station time: a sound run takes a bit longer
KINDS = ("recovered", "repeated", "remarks", "invalid", "stopped")
NOT_IN_THIS_PROCEDURE = ("fixture_stays",)


def drawn(seed: int, count: int) -> list[StationFault]:
    """As many faults, every name in turn, each at a random time."""
    rng = np.random.default_rng(seed)
    names = [name for name in FAULTS if name not in NOT_IN_THIS_PROCEDURE]
    order = [str(name) for _ in range(count // len(names) + 1) for name in rng.permutation(names)]
    return [
        StationFault(name, round(rng.uniform(0.0, _latest_s(name)), 1)) for name in order[:count]
    ]


def _latest_s(name: str) -> float:
    return LATEST_OVER_SOCKETS_S if name in OVER_SOCKETS else LATEST_S


def run_faults(count: int, seed: int, write: bool) -> None:
    """Hold the runs and print their table. Raises Unusable where anything is violated."""
    config = VirtualStation()
    sound = run_with(None, config).recording
    assert sound is not None
    ended: dict[str, Counter[str]] = {}
    wrong, began_s = [], time.monotonic()
    for fault in drawn(seed, count):
        outcome = run_with(fault, config)
        how = kind(outcome)
        ended.setdefault(fault.name, Counter())[how] += 1
        against = violations(fault.name, outcome, sound)
        wrong += [f"{fault}: {violation}" for violation in against]
        print(f"{fault!s:30} {how:10} {'; '.join(against) or outcome.sentence[:110]}", flush=True)
    text = page(ended, wrong, seed, time.monotonic() - began_s)
    print(text)
    if write:
        EVIDENCE.write_text(text, encoding="utf-8")
    if wrong:
        raise Unusable(f"{len(wrong)} of {count} runs with a fault did not end as they should")


def page(ended: dict[str, Counter[str]], wrong: list[str], seed: int, seconds: float) -> str:
    """The table of how runs with each fault ended."""
    total = sum(count for counts in ended.values() for count in counts.values())
    rows = [
        f"| `{name}` | {FAULTS[name][1]} | "
        + " | ".join(str(counts[how] or "") for how in KINDS) + " |"
        for name, counts in sorted(ended.items())
    ]  # fmt: skip
    return "\n".join([
        "# Runs in which something fails", "",
        f"{total} runs of a short procedure (seed {seed}, {seconds:.0f} s), each with one fault of "
        f"the virtual station from a random time on: {len(wrong)} violations.", "",
        "Recovered: valid, with the values of the sound run. Repeated: so, after segments were "
        "measured again. Remarks: with those values, and no unit passes. Invalid: no "
        "verdict. Stopped: one sentence. The table is at rest at the end.", "",
        "| fault | what happens | " + " | ".join(KINDS) + " |",
        "|---|---|" + "---:|" * len(KINDS), *rows, "",
        *(f"- {each}" for each in wrong),
    ]).rstrip() + "\n"  # fmt: skip
