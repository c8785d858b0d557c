"""Stage: re-processes the history of a store with today's code, beside the old results."""

import time
from collections.abc import Callable, Iterator, Sequence
from functools import cache

from schemas.capability import Capability
from schemas.certificate import LIVE
from schemas.history import Change, Difference, Failure, Plan, Reprocessing, Touched
from schemas.orders import ReprocessOrder
from schemas.tolerance import Tolerance
from storage import settings
from storage.catalogue import certificates, reprocessing, results
from storage.catalogue.reprocessing import Made
from storage.catalogue.run_index import Run
from storage.catalogue.selection import check_known, select
from storage.home import Home
from storage.whole_files import report_folder, written_out
from tasks.history import appeared_or_disappeared, difference, report_texts
from tasks.stages.fan_out import fan_out, processors
from tasks.stages.make_again import Job, Outcome, circumstances, make_again, store_of, with_fault
from tasks.stages.stage import stage
from tasks.version import code_version

Progress = Callable[[int, int], None]
DIED = (
    "its worker died twice while it was at this run alone; see that the machine has enough memory "
    "for it, and calibrate it by itself"
)


def plan(order: ReprocessOrder, home: Home) -> Plan:
    """What the order would do; nothing is read but the catalogue, and nothing is written."""
    now = circumstances(settings.laboratory(home), home)
    runs = _selected(order, now, home)
    to_make = reprocessing.to_make(runs, now, home)
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
    store = store_of(home)
    jobs = [
        Job(each, home, store, now, laboratory, limits(each.run.manufacturer, each.run.model))
        for each in reprocessing.to_make(runs, now, home)
    ]
    progress(0, len(jobs))
    outcomes = []
    for outcome in _carried_out(jobs, order):
        outcomes.append(outcome)
        progress(len(outcomes), len(jobs))
    capabilities = laboratory.capabilities if laboratory else ()
    before = _again(earlier, runs, limits, capabilities, home)
    compared = _with_certificates([*before, *outcomes], runs, limits, capabilities, home)
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
    ids = {run.id for run in chosen} | reprocessing.made_from(order.code_version, now, home)
    others = select(order.model_copy(update={"code_version": None}), home)
    return [run for run in others if run.id in ids]


def _carried_out(jobs: Sequence[Job], order: ReprocessOrder) -> Iterator[Outcome]:
    def died(job: Job) -> Outcome:
        return with_fault(job, DIED)

    if order.scheduler is None:
        return fan_out(make_again, jobs, order.workers or processors(), died)
    from tasks.stages.on_cluster import on_cluster

    return on_cluster(make_again, jobs, order.scheduler, died)


def _done(runs: Sequence[Run], now: str, home: Home) -> list[Made]:
    """What was made again before, of these runs, under the same circumstances."""
    ids = {run.id for run in runs}
    made = reprocessing.made_under(now, home)
    return [each for each in made if each.run in ids and not each.fault]


def _again(
    earlier: Sequence[Made],
    runs: Sequence[Run],
    limits: Callable[[str, str], Tolerance | None],
    capabilities: Sequence[Capability],
    home: Home,
) -> Iterator[Outcome]:
    """The differences of what was made again before."""
    by_id = {run.id: run for run in runs}
    for made in earlier:
        changes = Difference()
        if made.before and made.after and made.before != made.after:
            run = by_id[made.run]
            before, after = (results.find(each, home) for each in (made.before, made.after))
            tolerance = limits(run.manufacturer, run.model)
            changes = difference(before.calibration, after.calibration, tolerance, capabilities)
        yield Outcome(made, changes)


def _with_certificates(
    outcomes: Sequence[Outcome],
    runs: Sequence[Run],
    limits: Callable[[str, str], Tolerance | None],
    capabilities: Sequence[Capability],
    home: Home,
) -> Iterator[Outcome]:
    """The outcomes; of a result that a live certificate prints, or that came after the printed one,
    with the difference from that certificate.
    """
    by_id = {run.id: run for run in runs}
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
        run = by_id[made.run]
        printed, after = (results.find(each, home) for each in (paper.result, made.after))
        moved = difference(
            printed.calibration, after.calibration, limits(run.manufacturer, run.model),
            capabilities, certificates.record_of(paper, home).decision,
        )  # fmt: skip
        yield Outcome(made, moved)


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
