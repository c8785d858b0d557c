"""Re-processes one result of an earlier run with today's code, beside the old one.

What a worker does, wherever it runs: it needs the store and the catalogue, and nothing else.
"""

import hashlib
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from schemas.base import Unusable
from schemas.certificate import Laboratory
from schemas.history import Difference
from schemas.orders import Estimation
from schemas.tolerance import Tolerance
from storage.blobs import Unreachable, blobs_of
from storage.catalogue import equipment, reprocessing, results
from storage.catalogue.connection import Busy, name_of, opened_once
from storage.catalogue.database import BUSY_S
from storage.catalogue.reprocessing import Made, ToMake
from storage.home import Home
from tasks.history import difference
from tasks.stages.estimate import calibration_of, how_made
from tasks.version import code_version

PATIENCE_S = 120.0  # long enough for a database to restart
PAUSE_S = 1.0

R = TypeVar("R")


@dataclass(frozen=True)
class Job:
    """A result to make again, with everything that is not in store or catalogue."""

    to_make: ToMake
    home: Home
    store: str
    circumstances: str
    laboratory: Laboratory | None
    tolerance: Tolerance | None


@dataclass(frozen=True)
class Outcome:
    """What was made, and what is different from before."""

    made: Made
    difference: Difference


def make_again(job: Job) -> Outcome:
    """Estimate as before with today's code, keep the result, and say what is different.

    However that fails, it is an outcome with a fault, never an exception: one recording does not
    end the work on the others.
    """
    began = time.monotonic()
    try:
        with opened_once(job.home, BUSY_S):
            to_make, home = job.to_make, job.home
            _check_worker(job)
            before = to_make.before and _patiently(lambda: results.find(str(to_make.before), home))
            how = how_made(before.calibration) if before else Estimation()
            calibration = _patiently(lambda: calibration_of(to_make.run, home, how, job.laboratory))
            seconds = time.monotonic() - began
            after = _patiently(
                lambda: reprocessing.keep(to_make, calibration, job.circumstances, seconds, home)
            )
            made = Made(
                made_again=to_make.key, run=to_make.run.id, before=to_make.before, after=after,
                fault=None, seconds=seconds,
            )  # fmt: skip
            if not before:
                return Outcome(made, Difference())
            capabilities = job.laboratory.capabilities if job.laboratory else ()
            return Outcome(
                made, difference(before.calibration, calibration, job.tolerance, capabilities)
            )
    except Unusable as fault:
        why = str(fault)
    except Exception as failure:
        why = f"mimucal itself failed ({type(failure).__name__}: {failure})"
    return with_fault(job, why, time.monotonic() - began)


def with_fault(job: Job, why: str, seconds: float = 0.0) -> Outcome:
    """The outcome of a result that could not be made again; it is noted where that is possible."""
    to_make = job.to_make
    try:
        reprocessing.keep_fault(to_make, why, job.circumstances, seconds, job.home)
    except Unusable as fault:
        why = f"{why} ({fault})"
    made = Made(
        made_again=to_make.key, run=to_make.run.id, before=to_make.before, after=None,
        fault=why, seconds=seconds,
    )  # fmt: skip
    return Outcome(made, Difference())


def circumstances(laboratory: Laboratory | None, home: Home) -> str:
    """What a result is made under: the code, and what the laboratory states of its equipment."""
    limits = laboratory.limits if laboratory else {}
    listed = laboratory.equipment if laboratory else ()
    texts = [f"{name} {limit.model_dump_json()}" for name, limit in sorted(limits.items())]
    standards = (*listed, *equipment.register(home))
    texts += [standard.model_dump_json(exclude={"checks"}) for standard in standards]
    return hashlib.sha256("\n".join([code_version(), *texts]).encode()).hexdigest()[:12]


def store_of(home: Home) -> str:
    """Which catalogue and which recordings a home means on this machine."""
    return f"{name_of(home)} and {blobs_of(home).where('raw')}"


def _check_worker(job: Job) -> None:
    """Refuses to work with other code, or into another catalogue, than the order was given with."""
    if (mine := store_of(job.home)) != job.store:
        raise Unusable(
            f"a worker on {platform.node()} works on {mine}, not on {job.store}; start it with the "
            "same MIMUCAL_DATABASE and MIMUCAL_STORE"
        )
    if circumstances(job.laboratory, job.home) != job.circumstances:
        raise Unusable(
            f"a worker on {platform.node()} has another version ({code_version()}) than the one "
            "that gave the order, or the register of equipment was changed since; install the same "
            "there, and give the order again"
        )


def _patiently(ask: Callable[[], R]) -> R:
    """Retries while a catalogue or a bucket is temporarily out of reach."""
    gives_up = time.monotonic() + PATIENCE_S
    while True:
        try:
            return ask()
        except (Busy, Unreachable):
            if time.monotonic() > gives_up:
                raise
            time.sleep(PAUSE_S)
