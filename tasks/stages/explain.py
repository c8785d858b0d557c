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
from schemas.recording import Recording
from schemas.review import RunStatistics
from storage import run_statistics, settings
from storage.catalogue import discrepancies, runs
from storage.catalogue.run_index import Run
from storage.home import Home
from storage.whole_files import report_folder
from tasks.coefficients.parameters import model_values
from tasks.explain.correction.consequences import consequences
from tasks.explain.explain import explained
from tasks.explain.inputs.prepared import prepare
from tasks.explain.inputs.reference import ReferencePrediction
from tasks.explain.locate.where import locate
from tasks.explain.progress import Progress, report_progress, silent
from tasks.explain.report import discrepancy_of, pictures_of, report_html, write_report
from tasks.model.simulate import predict
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.angle_rates import as_mean_rates
from tasks.motion.whole import whole_motion
from tasks.review.run_statistics import VERSION, statistics_from, statistics_of
from tasks.stages import import_checks
from tasks.stages.calibration_input import read_calibration
from tasks.stages.equipment_in_use import limits_in_use
from tasks.stages.fan_out import fan_out, processors
from tasks.stages.simulation import other_unit, simulated_readings
from tasks.stages.stage import stage
from tasks.words import Message, message

if TYPE_CHECKING:
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
        other = import_checks.read(path)
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
            run_statistics.keep(run.digest, VERSION, made, home)


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
        run_statistics.keep(job.run.digest, VERSION, statistics_of(recording), job.home)
    except Unusable as fault:
        return job.run, str(fault)
    except Exception as failure:
        return job.run, f"mimucal itself failed ({type(failure).__name__}: {failure})"
    return job.run, ""


def _died(job: Job) -> tuple[Run, str]:
    return job.run, "its worker died twice; see that the machine has enough memory for it"
