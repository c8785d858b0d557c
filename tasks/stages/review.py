"""Stage: what many runs show together, who carries it and since when."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from schemas.base import Progress, Unusable
from schemas.certificate import LIVE, Laboratory
from schemas.discrepancy import KeptReview, Review, Skipped, Touched
from schemas.orders import ReviewOrder, Selection, order_of
from storage import run_statistics, settings
from storage.catalogue import certificates, runs
from storage.catalogue.runs import Run
from storage.catalogue.selection import check_known, select
from storage.formats.manifest import MANIFEST
from storage.home import Home
from storage.whole_files import report_folder, written_out
from tasks.review.hypotheses import Effect
from tasks.review.pool import pooled
from tasks.review.report import moved_elements, review_of, touched_of, with_touched
from tasks.review.search import Found, search
from tasks.review.several_recordings import reviewed_runs
from tasks.review.windows import rows_of
from tasks.stages.estimate import in_use
from tasks.stages.explain import all_kept_statistics, make_statistics
from tasks.stages.fan_out import fan_out, processors
from tasks.stages.import_recording import run_of
from tasks.stages.stage import stage
from tasks.version import code_version

MOST = 200  # newest certificates examined for each finding
FEWEST_FOR_POOL = 8  # fewest certificates for which a process pool is faster
FEWEST = 2  # fewest runs that can be compared
SELECTED = ("since", "until", "model", "serial", "station")


@dataclass(frozen=True)
class CertificateUnderEffect:
    """A certificate, the run it is based on, and an effect with values (m,) SI.

    laboratory: that of the home.
    """

    certificate: str
    run: Run
    effect: Effect
    values: np.ndarray
    home: Home
    laboratory: Laboratory | None


@dataclass(frozen=True)
class Reviewed:
    """The answer, and its file where a folder was named."""

    review: Review
    files: tuple[Path, ...] = ()


@stage("review")
def review_runs(order: ReviewOrder, home: Home, progress: Progress) -> Reviewed:
    """Add the statistics of runs up, and say what no run shows alone.

    Statistics that are not kept yet are made, and kept; so is the answer, as the home's last one,
    unless the home only reads. progress(done, total) is called after each
    run. Raises Unusable for fewer than two runs, or a folder that cannot be written.
    """
    # Late: the other stages need none of it.
    out = report_folder(order.out)
    chosen, skipped = _chosen(order, home)
    found = dict(zip(chosen, all_kept_statistics(chosen, home), strict=True))
    missing = [run for run, each in found.items() if each is None]
    for done, (run, why) in enumerate(make_statistics(missing, home), start=1):
        progress(done, len(missing))
        if why:
            skipped.append(Skipped(run=run.id, why=why))
    found |= zip(missing, all_kept_statistics(missing, home), strict=True)
    usable = {run.id: each for run, each in found.items() if each is not None}
    manifests = {run.id: runs.manifest(run, home) for run in chosen if run.id in usable}
    if len(usable) < FEWEST:
        raise Unusable(_too_few(len(usable), skipped))
    named = reviewed_runs(manifests)
    pool = pooled([(named[run], each) for run, each in usable.items()])
    found_together, p_value = search(pool)
    review = review_of(pool, found_together, p_value, skipped)
    review = with_certificates(review, found_together, {run.id: run for run in chosen}, home)
    review = review.model_copy(update={"code_version": code_version()})
    with suppress(Unusable):
        run_statistics.keep_review(
            _kept(review, order, [run for run in chosen if run.id in usable]), home
        )
    return Reviewed(review, () if out is None else (_write(review, out),))


def _kept(review: Review, order: ReviewOrder, used: Sequence[Run]) -> KeptReview:
    """The answer with what was asked and when."""
    asked = {name: str(value) for name in SELECTED if (value := getattr(order, name)) is not None}
    asked |= {"paths": str(len(order.paths))} if order.paths else {}
    days = sorted(run.recorded_on for run in used if run.recorded_on is not None)
    return KeptReview(
        at=datetime.now(UTC), asked=asked, days=(days[0], days[-1]) if days else None, review=review
    )


def _chosen(order: ReviewOrder, home: Home) -> tuple[list[Run], list[Skipped]]:
    """The runs of the order's paths, each once, else of its selection; and what is no recording."""
    if not order.paths:
        asked = {name: getattr(order, name) for name in SELECTED}
        selection = order_of(Selection, **asked)
        chosen = select(selection, home)
        if not chosen:
            check_known(selection, home)
        return chosen, []
    found, skipped = dict[str, Run](), []
    for path in (path for named in order.paths for path in _recordings(named)):
        try:
            run = run_of(path, home)
            found[run.id] = run
        except Unusable as fault:
            skipped.append(Skipped(run=path, why=str(fault)))
    selected = [run for run in found.values() if _selected(run, order)]
    if found and not selected:
        raise Unusable(
            f"none of the {len(found)} recordings of PATH is of the station, model, serial number "
            "or days that the options name; correct them or leave them out."
        )
    return selected, skipped


def _recordings(named: str) -> list[str]:
    """The recording at a path; for another folder, the recordings in it."""
    if not named:
        raise Unusable("PATH is empty; give a recording or a folder of recordings.")
    folder = Path(named)
    if not folder.is_dir() or (folder / MANIFEST).exists():
        return [named]
    within = sorted(folder.iterdir())
    if not within or any(path.name == "metadata.yaml" for path in within):  # a ROS 2 bag
        return [named]
    return [str(path) for path in within if path.is_dir() or path.suffix == ".mcap"] or [named]


def _selected(run: Run, order: ReviewOrder) -> bool:
    asked = ((order.model, run.model), (order.serial, run.serial), (order.station, run.station))
    day = run.recorded_on or run.imported_at.date()
    within = (order.since is None or day >= order.since) and (
        order.until is None or day <= order.until
    )
    return within and all(wanted is None or wanted == own for wanted, own in asked)


def _too_few(count: int, skipped: list[Skipped]) -> str:
    why = "; ".join(f"{one.run}: {one.why}" for one in skipped[:3])
    left_out = f"; {len(skipped)} left out ({why})" if skipped else ""
    way_out = (
        "one run alone is for `mimucal explain`" if count else "`mimucal runs` lists what is kept"
    )
    return f"review needs {FEWEST} runs or more, and {count} can be used{left_out}; {way_out}."


def _write(review: Review, folder: Path) -> Path:
    path = folder / "review.json"
    with written_out(path) as draft:
        draft.write_text(review.model_dump_json(indent=1), encoding="utf-8")
    return path


def with_certificates(
    review: Review, found: Sequence[Found], chosen: Mapping[str, Run], home: Home
) -> Review:
    """The review with what each finding changes in the certificates based on its runs.

    found: of each finding. chosen: runs by id.
    """
    laboratory = settings.laboratory(home)
    standing = [each for each in certificates.register(home) if each.state in LIVE]
    findings = []
    for finding, one in zip(review.findings, found, strict=True):
        affected = {
            one.pool.runs[k].run for k in np.flatnonzero(rows_of(one.pool, one.best.window))
        }
        jobs = [
            CertificateUnderEffect(
                entry.number, chosen[entry.run], one.best.effect, one.values, home, laboratory)
            for entry in standing if entry.run in affected
        ][-MOST:]  # fmt: skip
        workers = min(processors(), len(jobs) // FEWEST_FOR_POOL)
        elements = [each for some in fan_out(_touched, jobs, workers, _none) for each in some]
        findings.append(with_touched(finding, elements, len(jobs)))
    return review.model_copy(update={"findings": tuple(findings)})


def _touched(job: CertificateUnderEffect) -> list[Touched]:
    """Nothing where the recording is gone or its clauses give no items."""
    try:
        recording = runs.load(job.run, job.home)
        limits = in_use(recording, job.home, job.laboratory).limits
        elements = moved_elements(recording, job.effect, job.values, limits)
    except Unusable:
        return []
    return list(touched_of(job.certificate, elements))


def _none(job: CertificateUnderEffect) -> list[Touched]:
    return []
