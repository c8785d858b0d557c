"""The statistics of a run that `review` combines: made once and kept beside its recording."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

from schemas.base import Unusable
from schemas.recording import Recording
from schemas.review import RunStatistics
from storage import run_statistics
from storage.catalogue import runs
from storage.catalogue.run_index import Run
from storage.home import Home
from tasks.review.run_statistics import VERSION, statistics_of
from tasks.stages.fan_out import fan_out, processors

WORTH_A_PROCESS = 4  # runs that take longer than a process takes to begin


@dataclass(frozen=True)
class Job:
    """A run whose statistics are to be made."""

    run: Run
    home: Home


def kept_statistics(run: Run, home: Home) -> RunStatistics | None:
    """The statistics of a run where they are kept."""
    return run_statistics.load(run.digest, VERSION, home)


def all_kept_statistics(which: Sequence[Run], home: Home) -> list[RunStatistics | None]:
    """The same of many runs, unpacked by as many threads as there are processors."""
    with ThreadPoolExecutor(processors()) as threads:
        return list(threads.map(partial(kept_statistics, home=home), which))


def keep_statistics(run: Run, recording: Recording, home: Home) -> None:
    """Makes and keeps the statistics of a run, unless they are there; a run that has none, and a
    home that only reads, stay without.
    """
    if kept_statistics(run, home) is None:
        with suppress(Unusable):
            run_statistics.keep(run.digest, VERSION, statistics_of(recording), home)


def make_statistics(which: Sequence[Run], home: Home) -> Iterator[tuple[Run, str]]:
    """Makes and stores the statistics of runs in one process per processor; yields each finished
    run, and why it has none; empty: it has.
    """
    workers = min(processors(), len(which) // WORTH_A_PROCESS)
    yield from fan_out(_made, [Job(run, home) for run in which], workers, _died)


def _made(job: Job) -> tuple[Run, str]:
    """However it fails, one recording does not end the work on the others."""
    try:
        recording = runs.load(job.run, job.home)
        run_statistics.keep(job.run.digest, VERSION, statistics_of(recording), job.home)
    except Unusable as fault:
        return job.run, str(fault)
    except Exception as failure:
        return job.run, f"mimucal itself failed ({type(failure).__name__}: {failure})"
    return job.run, ""


def _died(job: Job) -> tuple[Run, str]:
    return job.run, "its worker died twice; see that the machine has enough memory for it"
