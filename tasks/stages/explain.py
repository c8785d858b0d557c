"""Stage: where model and recording differ, which physics was left out, and how much it matters."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from schemas.base import Unusable
from schemas.discrepancy import Discrepancy, RunStatistics
from schemas.orders import ExplainOrder
from schemas.recording import ACCEL, ANGLE, GYRO, Recording, Stream
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
from tasks.stages.estimate import in_use, read_calibration
from tasks.stages.fan_out import fan_out, processors
from tasks.stages.stage import stage
from tasks.words import Message, message

if TYPE_CHECKING:
    from tasks.explain.explanation import Explanation
    from tasks.explain.inputs.prepared import Prepared

# The readings predicted by another simulator, and whether they are of this run.


# longest gap in another simulator's rows that is interpolated, in sample intervals of the unit
MAX_STEPS = 1.5
MIN_SHARE_OF_ROWS = 0.5  # of the unit's rows that a simulation must have
# of a table axis: a larger difference is another position, not a difference in timing
MAX_ANGLE_DIFFERENCE = np.radians(10.0)
MAX_SHARE_DIFFERENT = 0.1  # of the rows of the table
MIN_ROTATION = np.radians(1.0)  # rad/s rms: too little motion to distinguish one from another
MAX_RATE_DIFFERENCE = 0.5  # of the rms rate of the motion, by the rate that is simulated
NO_SERIAL = ("", "-")


def simulated_readings(recording: Recording, path: Path, other: Recording) -> np.ndarray:
    """What a simulation, read from a path, says of a recording: (n, 6) rad/s and m/s² at the
    unit's rows.

    Interpolated linearly where its rows are not the unit's; NaN where it says nothing. Raises
    Unusable for a simulation of another stretch of time or another motion, or without gyro and
    accelerometer.
    """
    t = recording.imu.t
    readings = np.full((len(t), len(GYRO + ACCEL)), np.nan)
    between = _within(other.imu.t, t)
    for channel, name in enumerate(GYRO + ACCEL):
        if name in other.imu.columns:
            values = np.interp(t, other.imu.t, other.imu.columns[name])
            readings[between, channel] = values[between]
    simulated = np.isfinite(readings).any(axis=1)
    if simulated.mean() < MIN_SHARE_OF_ROWS:
        percent = f"{100.0 * simulated.mean():.0f} %"
        raise Unusable(
            f"{path}: it says what the unit reads in {percent} of the rows of "
            f"{recording.manifest.recording_id} only, whose {len(t)} rows go from {t[0]:g} s to "
            f"{t[-1]:g} s; give gyro_* and accel_* at the times of the unit's own stream."
        )
    fault = _other_angles(recording, other) or _other_rates(recording, readings)
    if fault:
        raise Unusable(f"{path}: {fault}; give the simulation of this same run.")
    return readings


def other_unit(recording: Recording, other: Recording) -> tuple[Message, ...]:
    """A remark where a simulation names another unit; it need not name any."""
    own, its = recording.manifest.unit.serial, other.manifest.unit.serial
    if own == its or {own, its} & set(NO_SERIAL):
        return ()
    return (message("explain-simulation-of-other-unit", own=own, its=its),)


def _within(known: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(n,) bool: which times t fall on a known one or between two that are near each other."""
    longest = MAX_STEPS * float(np.median(np.diff(t))) if len(t) > 1 else np.inf
    after = np.clip(np.searchsorted(known, t), 0, len(known) - 1)
    before = np.clip(after - 1, 0, None)
    inside = (t > known[before]) & (t < known[after])
    return (known[after] == t) | (inside & (known[after] - known[before] <= longest))


def _other_angles(recording: Recording, other: Recording) -> str:
    """What the table's angles say against it; empty: nothing, or one of the two has none."""
    if recording.table is None or other.table is None:
        return ""
    for name in recording.table.columns:
        if name.endswith("_angle") and name in other.table.columns:
            fault = _other_angle(recording, other.table, name)
            if fault:
                return fault
    return ""


def _other_angle(recording: Recording, table: Stream, name: str) -> str:
    own = recording.table
    assert own is not None
    inside = (own.t >= table.t[0]) & (own.t <= table.t[-1])
    t, at = own.t[inside], own.columns[name][inside]
    turned = np.exp(1j * table.columns[name])  # whole turns do not count
    theirs = np.interp(t, table.t, turned.real) + 1j * np.interp(t, table.t, turned.imag)
    apart = np.abs(np.angle(np.exp(1j * at) * theirs.conj()))
    if not len(t) or np.mean(apart > MAX_ANGLE_DIFFERENCE) <= MAX_SHARE_DIFFERENT:
        return ""
    worst = int(np.argmax(apart))
    return (
        f"its table holds {name} at {np.degrees(np.angle(theirs[worst])):.1f}° at t = "
        f"{t[worst]:g} s, where that of {recording.manifest.recording_id} is at "
        f"{np.degrees(np.angle(np.exp(1j * at[worst]))):.1f}°, and differs by more than "
        f"{np.degrees(MAX_ANGLE_DIFFERENCE):.0f}° in "
        f"{100.0 * np.mean(apart > MAX_ANGLE_DIFFERENCE):.0f} % of the rows"
    )


def _other_rates(recording: Recording, readings: np.ndarray) -> str:
    """What the size of the rate says against it, which does not depend on how the unit sits."""
    moved = np.linalg.norm(whole_motion(recording).rate, axis=1)
    read = np.linalg.norm(readings[:, : len(GYRO)], axis=1)
    known = np.isfinite(moved) & np.isfinite(read)
    if not known.any():
        return ""
    missed, turned = np.where(known, np.abs(read - moved), 0.0), moved[known]
    rms, size = np.sqrt(np.mean(missed[known] ** 2)), np.sqrt(np.mean(turned**2))
    if max(rms, size) <= MIN_ROTATION or rms <= MAX_RATE_DIFFERENCE * size:
        return ""
    worst = int(np.argmax(missed))
    return (
        f"its gyro_* reads a rate of {np.degrees(read[worst]):.3g} °/s at t = "
        f"{recording.imu.t[worst]:g} s, where {recording.manifest.recording_id} turns at "
        f"{np.degrees(moved[worst]):.3g} °/s, and differs by {np.degrees(rms):.3g} °/s rms from "
        "its motion"
    )


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
    limits = in_use(recording, home).limits
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
