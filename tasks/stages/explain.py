"""Stage: where model and recording differ, which physics was left out, and how much it matters."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from schemas.base import Unusable
from schemas.discrepancy import Discrepancy
from schemas.orders import ExplainOrder
from schemas.recording import ANGLE, Recording
from schemas.review import RunStatistics
from storage import run_statistics, settings
from storage.catalogue import discrepancies, runs
from storage.catalogue.runs import Run
from storage.home import Home
from storage.whole_files import report_folder
from tasks.coefficients.correct import model_values
from tasks.explain.correction.consequences import Consequences, consequences
from tasks.explain.explain import explain, explained
from tasks.explain.inputs.prepared import prepare
from tasks.explain.inputs.reference import ReferencePrediction
from tasks.explain.locate.where import locate
from tasks.explain.progress import Progress, report_progress, silent
from tasks.explain.report import discrepancy_of, pictures_of, report_html, write_report
from tasks.model.model import predict
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.encoders import as_mean_rates
from tasks.motion.whole import whole_motion
from tasks.review.pool import VERSION, pooled, statistics_from, statistics_of
from tasks.review.several_recordings import (
    discrepancy_together,
    found_together,
    held_out_gain,
    reviewed_runs,
)
from tasks.stages import import_recording
from tasks.stages.estimate import limits_in_use, read_calibration
from tasks.stages.fan_out import fan_out, processors
from tasks.stages.simulate import other_unit, simulated_readings
from tasks.stages.stage import stage
from tasks.words import Message, message

if TYPE_CHECKING:
    from tasks.explain.explanation import Explanation
    from tasks.explain.inputs.prepared import Prepared


FEWEST_FOR_POOL = 4  # fewest runs for which a process pool is faster


@dataclass(frozen=True)
class Job:
    """A run whose statistics are to be made."""

    run: Run
    home: Home


@dataclass(frozen=True)
class Explained:
    """The answer, and the files of its report where a folder was named."""

    discrepancy: Discrepancy
    files: tuple[Path, ...] = ()


@stage("explain")
def explain_run(
    run: Run, home: Home, order: ExplainOrder, progress: Progress = silent
) -> Explained:
    """Find where the standard's model and a run differ, and which physics is missing.

    What the standard's own model leaves out of a run is stored with it, unless the home is
    read-only. progress: is called with the current step and the share of the work that is done.
    Raises Unusable for a result, a simulation or a folder that cannot be used.
    """
    # Late: the other stages need none of it.
    out = report_folder(order.out)
    recording = runs.load(run, home)
    reference, doubts = _reference(as_mean_rates(recording), home, order)
    unit = recording.manifest.unit
    tolerance = settings.tolerance_for(unit.manufacturer, unit.model, home)
    limits = limits_in_use(recording.manifest, home, settings.laboratory(home))
    prepared = prepare(recording, reference, progress=progress)
    explanation = explained(prepared, progress=progress)
    report_progress(progress, "consequences")
    effects = consequences(recording, explanation, tolerance, limits)
    explanation = replace(explanation, remarks=(*doubts, *explanation.remarks, *effects.remarks))
    wheres = locate(explanation) if explanation.findings else ()
    discrepancy = discrepancy_of(explanation, wheres, effects)
    report_progress(progress, "report")
    files = () if out is None else tuple(write_report(discrepancy, explanation, out))
    if reference is None:
        html = report_html(discrepancy, explanation, pictures_of(discrepancy, explanation))
        with suppress(Unusable):
            discrepancies.keep(run, discrepancy, html, datetime.now(UTC), home)
    keep_statistics(run, recording, prepared, home)
    return Explained(discrepancy, files)


def _reference(
    recording: Recording, home: Home, order: ExplainOrder
) -> tuple[ReferencePrediction | None, tuple[Message, ...]]:
    """What a calibration or another simulator says the unit should have read, with remarks on it;
    None: neither.
    """
    if order.simulated is not None:
        path = Path(order.simulated)
        other = import_recording.read(path)
        readings = simulated_readings(recording, path, other)
        model = message("explain-model-simulation")
        return ReferencePrediction(readings, model), other_unit(recording, other)
    if order.calibration is None:
        return None, ()

    values, _ = model_values(read_calibration(order.calibration, home))
    model = message("explain-model-calibration")
    return ReferencePrediction(predict(STANDARD_TERMS, whole_motion(recording), values), model), ()


def kept_statistics(run: Run, home: Home) -> RunStatistics | None:
    """The statistics of a run where they are kept."""
    return run_statistics.load(run.digest, VERSION, home)


def all_kept_statistics(which: Sequence[Run], home: Home) -> list[RunStatistics | None]:
    """The same of many runs, unpacked by as many threads as there are processors."""
    with ThreadPoolExecutor(processors()) as threads:
        return list(threads.map(partial(kept_statistics, home=home), which))


def keep_statistics(run: Run, recording: Recording, prepared: "Prepared", home: Home) -> None:
    """Makes and keeps the statistics of a run, unless they are there; a run that has none, and a
    home that only reads, stay without.

    prepared: the recording as it was explained.
    """
    if kept_statistics(run, home) is None:
        as_stamped = prepared.reference is None and not prepared.delay
        with suppress(Unusable):
            made = statistics_from(prepared) if as_stamped else statistics_of(recording)
            run_statistics.keep_statistics(run.digest, VERSION, made, home)


def make_statistics(which: Sequence[Run], home: Home) -> Iterator[tuple[Run, str]]:
    """Makes and stores the statistics of runs in one process per processor; yields each finished
    run, and why it has none; empty: it has.
    """
    workers = min(processors(), len(which) // FEWEST_FOR_POOL)
    yield from fan_out(_made, [Job(run, home) for run in which], workers, _died)


def _made(job: Job) -> tuple[Run, str]:
    """However it fails, one recording does not end the work on the others."""
    try:
        recording = runs.load(job.run, job.home)
        run_statistics.keep_statistics(job.run.digest, VERSION, statistics_of(recording), job.home)
    except Unusable as fault:
        return job.run, str(fault)
    except Exception as failure:
        return job.run, f"mimucal itself failed ({type(failure).__name__}: {failure})"
    return job.run, ""


def _died(job: Job) -> tuple[Run, str]:
    return job.run, "its worker died twice; see that the machine has enough memory for it"


# Stage: which physics several recordings of one unit show together.


@stage("explain-together")
def explain_together(
    which: Sequence[Run], home: Home, order: ExplainOrder, progress: Progress = silent
) -> Explained:
    """Add up what recordings of one unit say, and name what they show together; what each says by
    itself stands among the remarks.

    Raises Unusable for recordings of different units or formats, the same one twice, and an order
    of a report, a calibration or a simulation.
    """
    # Late: the other stages need none of it.
    recordings = [runs.load(run, home) for run in which]
    _refuse(which, recordings, order)
    unit = recordings[0].manifest.unit
    who = reviewed_runs(
        {run.id: each.manifest for run, each in zip(which, recordings, strict=True)}
    )
    # In the order asked for, in which the answer names them.
    pool = pooled([
        (replace(who[run.id], at=f"{number:06d}"), statistics_of(each))
        for number, (run, each) in enumerate(zip(which, recordings, strict=True))
    ])  # fmt: skip
    found, p_value = found_together(pool)
    alone = [_answer(explain(each, progress=progress)) for each in recordings]
    report_progress(progress, "report")
    fitted = alone
    while found:
        names = list(dict.fromkeys(one.effect.name for one in found))
        fitted = [_answer(explain(each, only=names)) for each in recordings]
        gained = tuple(one for one in found if held_out_gain(one, fitted) > 0.0)
        if gained == found:
            break
        found, fitted = gained, alone
    title = f"{unit.manufacturer} {unit.model} {unit.serial}"
    return Explained(discrepancy_together(title, found, p_value, alone, fitted))


def _answer(explanation: "Explanation") -> Discrepancy:
    """Without what it does to a certificate, which is of one recording."""
    wheres = locate(explanation) if explanation.findings else ()
    none = ((),) * len(explanation.findings)
    return discrepancy_of(explanation, wheres, Consequences(none, none))


def _refuse(which: Sequence[Run], recordings: Sequence[Recording], order: ExplainOrder) -> None:
    names = ", ".join(run.recording_id for run in which)
    if len({run.id for run in which}) < len(which):
        raise Unusable(f"{names}: one of these recordings is named twice; name each once.")
    units = {
        f"{m.unit.manufacturer} {m.unit.model} {m.unit.serial}"
        for m in (each.manifest for each in recordings)
    }
    if len(units) > 1:
        raise Unusable(
            f"{names} are recordings of different units ({', '.join(sorted(units))}): explain "
            "recordings of one unit together, or `mimucal review` those of many."
        )
    if len({_format(each) for each in recordings}) > 1:
        raise Unusable(
            f"{names} have different formats (rates or angles, motion from the table or from a "
            "pose): explain those of one format together."
        )
    if order.out or order.calibration or order.simulated:
        raise Unusable(
            f"{names}: several recordings are compared with the fitted model and have no report "
            "folder; leave --out, --calibration and --simulated out, or explain one recording."
        )


def _format(recording: Recording) -> tuple[str, bool, bool]:
    angles = any(name in recording.imu.columns for name in ANGLE)
    return recording.manifest.format, angles, recording.table is None
