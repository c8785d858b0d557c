"""Many kills, and the page of them."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import astuple
from pathlib import Path

from tests.proof.kills.kill import BOUND_S, SPEED, Killed, kill
from tests.proof.report import table

AT_ONCE = 3
PAGE = "kills.md"
COLUMNS = ("seed", "kill after (s)", "sent", "recovered", "lost (s)", "wrong")


def run_all(folder: Path, count: int, report: Callable[[int, int], None]) -> list[Killed]:
    """Kills of the seeds 1 to count, and kills.md, in a new folder."""
    with ThreadPoolExecutor(AT_ONCE) as pool:
        killed = []
        for each in pool.map(lambda seed: kill(seed, folder / f"{seed:03d}"), range(1, count + 1)):
            killed.append(each)
            report(len(killed), count)
    (folder / PAGE).write_text(as_markdown(killed), encoding="utf-8")
    return killed


def summary(killed: Sequence[Killed]) -> str:
    """One sentence."""
    wrong = sum(bool(each.faults) for each in killed)
    with_rows = [each.lost_s for each in killed if each.recovered]
    return (
        f"{len(killed)} acquisitions killed at random moments: {wrong} against the bound of "
        f"{BOUND_S:g} s; of the {len(with_rows)} that had readings on the disk the last one was "
        f"at most {max(with_rows, default=0.0):.2f} s older than the kill"
    )


def as_markdown(killed: Sequence[Killed]) -> str:
    """The summary, how it was held, and a row for each kill."""
    rows = [
        (seed, f"{after:.2f}", sent, recovered, f"{lost:.2f}", "; ".join(wrong))
        for seed, after, sent, recovered, lost, wrong in map(astuple, killed)
    ]
    return "\n".join([
        "# Kills",
        "",
        f"{summary(killed)}.",
        "",
        f"Each on a virtual station of its own at {SPEED:g} times the clock, with a log of the",
        "unit's line beside it. What is recovered must be what was sent, reading by reading and",
        f"stamp by stamp, and hold all that was sent {BOUND_S:g} s before the kill.",
        "",
        *table(COLUMNS, rows),
        "",
    ])  # fmt: skip
