"""Stage: re-processes the history of a store with today's code, beside the old results."""

import hashlib
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TypeVar

from schemas.base import Progress, Unusable
from schemas.certificate import LIVE, Laboratory
from schemas.history import Change, Difference, Failure, Plan, Reprocessing, Touched
from schemas.orders import Estimation, ReprocessOrder
from schemas.tolerance import Decision, Tolerance
from storage import settings
from storage.blobs import Unreachable, blobs_of
from storage.catalogue import certificates, equipment, results
from storage.catalogue.database import BUSY_S, Busy, name_of, opened_once
from storage.catalogue.results import Made, ToMake
from storage.catalogue.runs import Run
from storage.catalogue.selection import check_known, select
from storage.home import Home
from storage.whole_files import report_folder, written_out
from tasks.history import appeared_or_disappeared, difference, report_texts
from tasks.stages.estimate import calibration_of, how_made
from tasks.stages.fan_out import fan_out, processors
from tasks.stages.stage import stage
from tasks.version import code_version

# Re-processes one result of an earlier run with today's code, beside the old one.
#
# What a worker does, wherever it runs: it needs the store and the catalogue, and nothing else.

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


def reprocess_one(job: Job) -> Outcome:
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
                lambda: results.keep(to_make, calibration, job.circumstances, seconds, home)
            )
            made = Made(
                made_again=to_make.key, run=to_make.run.id, before=to_make.before, after=after,
                fault=None, seconds=seconds,
            )  # fmt: skip
            if not before:
                return Outcome(made, Difference())
            moved = difference(before.calibration, calibration, job.tolerance, job.laboratory)
            return Outcome(made, moved)
    except Unusable as fault:
        why = str(fault)
    except Exception as failure:
        why = f"mimucal itself failed ({type(failure).__name__}: {failure})"
    return with_fault(job, why, time.monotonic() - began)


def with_fault(job: Job, why: str, seconds: float = 0.0) -> Outcome:
    """The outcome of a result that could not be made again; it is noted where that is possible."""
    to_make = job.to_make
    try:
        results.keep_fault(to_make, why, job.circumstances, seconds, job.home)
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


DIED = (
    "its worker died twice while it was at this run alone; see that the machine has enough memory "
    "for it, and calibrate it by itself"
)


def plan(order: ReprocessOrder, home: Home) -> Plan:
    """What the order would do; nothing is read but the catalogue, and nothing is written."""
    now = circumstances(settings.laboratory(home), home)
    runs = _selected(order, now, home)
    to_make = results.to_make(runs, now, home)
    waiting = {each.run.id: each.run.rows for each in to_make}
    return Plan(
        code_version=code_version(),
        circumstances=now,
        runs=tuple(waiting),
        results=len(to_make),
        done_before=len(_done(runs, now, home)),
        rows=sum(waiting.values()),
    )


@stage("reprocess")
def reprocess(order: ReprocessOrder, home: Home, progress: Progress) -> Reprocessing:
    """Re-process the newest results of a selection, and report what changed.

    A result is made once under the same circumstances: an interrupted command continues where it
    was, and when repeated after the end only gives the report. Failures are tried again.
    progress(done, total) is called after each result. Raises Unusable for a report folder that
    cannot be made.
    """
    began = time.monotonic()
    out = report_folder(order.out)
    laboratory = settings.laboratory(home)
    now = circumstances(laboratory, home)
    runs = _selected(order, now, home)
    earlier = _done(runs, now, home)
    limits = cache(lambda manufacturer, model: settings.tolerance_for(manufacturer, model, home))
    by_id = {run.id: run for run in runs}

    def between(before: str, after: str, printed: Decision | None = None) -> Difference:
        """What changed from one kept result to another of the same run."""
        was, now = (results.find(each, home) for each in (before, after))
        run = by_id[now.run]
        tolerance = limits(run.manufacturer, run.model)
        return difference(was.calibration, now.calibration, tolerance, laboratory, printed)

    store = store_of(home)
    jobs = [
        Job(each, home, store, now, laboratory, limits(each.run.manufacturer, each.run.model))
        for each in results.to_make(runs, now, home)
    ]
    progress(0, len(jobs))
    outcomes = []
    for outcome in _carried_out(jobs, order):
        outcomes.append(outcome)
        progress(len(outcomes), len(jobs))
    compared = _with_certificates([*_again(earlier, between), *outcomes], between, home)
    report = _report(runs, list(compared), home).model_copy(
        update={
            "circumstances": now,
            "done_before": len(earlier),
            "seconds": time.monotonic() - began,
        }
    )
    if out is not None:
        for name, text in report_texts(report).items():
            with written_out(out / name) as draft:
                draft.write_text(text, encoding="utf-8")
    return report


def _selected(order: ReprocessOrder, now: str, home: Home) -> list[Run]:
    """The runs of the order, those that it made again before included.

    Their newest results are no longer of the version that the order names. Raises Unusable for a
    station, model, serial number, procedure or equipment that no run has.
    """
    chosen = select(order, home)
    if not chosen:
        check_known(order, home)
    if order.code_version is None:
        return chosen
    ids = {run.id for run in chosen} | results.made_from(order.code_version, now, home)
    others = select(order.model_copy(update={"code_version": None}), home)
    return [run for run in others if run.id in ids]


def _carried_out(jobs: Sequence[Job], order: ReprocessOrder) -> Iterator[Outcome]:
    def died(job: Job) -> Outcome:
        return with_fault(job, DIED)

    if order.scheduler is None:
        return fan_out(reprocess_one, jobs, order.workers or processors(), died)
    from tasks.stages.on_cluster import on_cluster

    return on_cluster(reprocess_one, jobs, order.scheduler, died)


def _done(runs: Sequence[Run], now: str, home: Home) -> list[Made]:
    """What was made again before, of these runs, under the same circumstances."""
    ids = {run.id for run in runs}
    made = results.made_under(now, home)
    return [each for each in made if each.run in ids and not each.fault]


def _again(earlier: Sequence[Made], between: Callable[..., Difference]) -> Iterator[Outcome]:
    """The differences of what was made again before."""
    for made in earlier:
        changes = Difference()
        if made.before and made.after and made.before != made.after:
            changes = between(made.before, made.after)
        yield Outcome(made, changes)


def _with_certificates(
    outcomes: Sequence[Outcome], between: Callable[..., Difference], home: Home
) -> Iterator[Outcome]:
    """The outcomes; of a result that a live certificate prints, or that came after the printed one,
    with the difference from that certificate.
    """
    papers = {each.run: each for each in certificates.register(home) if each.state in LIVE}
    for outcome in outcomes:
        made = outcome.made
        paper = papers.get(made.run)
        if paper is None or made.before is None or made.after is None:
            yield outcome
            continue
        if paper.result not in (made.before, *results.chain(made.before, home)):
            yield outcome
            continue
        printed = certificates.record_of(paper, home).decision
        yield Outcome(made, between(paper.result, made.after, printed))


def _report(runs: Sequence[Run], outcomes: Sequence[Outcome], home: Home) -> Reprocessing:
    done = [each for each in outcomes if not each.made.fault]
    changed = [change for each in done for change in each.difference.changed]
    again = [each for each in done if each.made.before is not None]
    same = [each for each in again if not each.difference.changed and not each.difference.flips]
    faults = ((each.made.run, each.made.fault) for each in outcomes if each.made.fault)
    return Reprocessing(
        code_version=code_version(),
        circumstances="",
        runs=len(runs),
        done=len(done),
        done_before=0,
        failed=len(outcomes) - len(done),
        unchanged=len(same),
        first=len(done) - len(again),
        changed=tuple(sorted(changed, key=_most_first)),
        flips=tuple(flip for each in done for flip in each.difference.flips),
        certificates=tuple(_touched(done, home)),
        failures=tuple(Failure(run=run, why=why) for run, why in faults),
        seconds=0.0,
    )


def _most_first(change: Change) -> tuple[bool, float, str, str, str]:
    """Values that appeared or disappeared come before all changes, however large."""
    return (
        not appeared_or_disappeared(change),
        -(change.in_U or 0.0),
        change.run,
        change.item,
        change.element,
    )


def _touched(done: Sequence[Outcome], home: Home) -> Iterator[Touched]:
    """Certificates that print a result which is different now, or was already."""
    of_run: dict[str, list[Outcome]] = {}
    for outcome in done:
        of_run.setdefault(outcome.made.run, []).append(outcome)
    for entry in certificates.register(home):
        for outcome in of_run.get(entry.run, ()):
            made = outcome.made
            if made.before is None or made.after is None or made.after == entry.result:
                continue
            if entry.result == made.before or entry.result in results.chain(made.before, home):
                printed = results.find(entry.result, home).calibration
                moved = difference(printed, results.find(made.after, home).calibration)
            else:
                continue
            if moved.changed:
                yield Touched(
                    number=entry.number,
                    run=entry.run,
                    state=entry.state,
                    verdict=entry.verdict,
                    largest_in_U=max(
                        (c.in_U for c in moved.changed if c.in_U is not None), default=None
                    ),
                    U_factor=max(map(_factor_of_u, moved.changed)),
                )


def _factor_of_u(change: Change) -> float:
    """By which factor, above 1, a U is another one; 1 where it was or is not stated."""
    if not change.U_before or not change.U_after:
        return 1.0
    return max(change.U_after / change.U_before, change.U_before / change.U_after)
