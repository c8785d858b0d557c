"""What many runs show together, beside only reading and unpacking their statistics."""

import tempfile
from functools import partial
from pathlib import Path

from schemas.discrepancy import RunStatistics
from storage.home import Home
from storage.run_statistics import keep_statistics, load
from tasks.review.pool import VERSION, ReviewedRun, pooled, statistics_of
from tasks.review.search import search
from tests.bench.measure import Figure, Section, processor_s
from tests.proof.fleets import draw, drawn_runs, played

MANY, MADE = 10_000, 6  # runs, and how many of each kind are made: the others repeat these
FLEET = (2, 9)  # seed and number of one whose model has an effect
AFFECTED = "2"  # the station whose runs have it here
ASKED = 6.0  # times the reading


def many_runs() -> Section:
    """A search with findings over kept statistics."""
    fleet = draw(*FLEET)
    with tempfile.TemporaryDirectory() as folder:
        home = Home(Path(folder))
        for affected in (False, True):
            some = [run for run in fleet.runs if run.affected == affected][:MADE]
            for number, run in enumerate(some):
                made = statistics_of(played(fleet, run))
                keep_statistics(_digest(number, affected), VERSION, made, home)
        figures = (
            Figure("the limit: read and unpack", processor_s(partial(_read, home), 1)),
            Figure(
                "`review`: read, add up, search", processor_s(partial(_reviewed, home), 1), ASKED
            ),
        )
    return Section(f"What {MANY:,} runs show together (asked: 10 s)", figures)


def _digest(number: int, affected: bool) -> str:
    return f"{2 * (number % MADE) + affected:064x}"


def _read(home: Home) -> list[tuple[ReviewedRun, RunStatistics]]:
    found = list[tuple[ReviewedRun, RunStatistics]]()
    for number, run in enumerate(drawn_runs(MANY)):
        kept = load(_digest(number, run.carriers["station"] == AFFECTED), VERSION, home)
        assert kept is not None
        found.append((run, kept))
    return found


def _reviewed(home: Home) -> None:
    search(pooled(_read(home)))
