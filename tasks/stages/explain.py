"""Stage: where model and recording differ, which physics was left out, and what it matters."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.discrepancy import Discrepancy
from schemas.recording import ACCEL, GYRO, Recording
from schemas.tolerance import Tolerance
from storage import settings
from storage.catalogue import results, runs
from storage.catalogue.runs import Run
from storage.home import Home
from tasks.stages import refuse
from tasks.words import message

if TYPE_CHECKING:
    from tasks.explain.inputs.reference import Told

WIDEST_STEP = 1.5  # steps of the unit between which another simulator's rows are interpolated
FEWEST_ROWS = 0.5  # of the unit's rows that a simulation must have


@dataclass(frozen=True)
class Explained:
    """The answer, and the files of its report where a folder was named."""

    discrepancy: Discrepancy
    files: tuple[Path, ...] = ()


def explain_run(
    run: Run,
    home: Home,
    out: Path | None = None,
    calibration: str | None = None,
    simulated: Path | None = None,
    progress: Callable[[str], None] = lambda now: None,
) -> Explained:
    """Find where the standard's model and a run differ, and say which physics is missing.

    out: folder of the report; nothing is written without it. calibration: the model's parameters,
    a result's id or a mimu-calibration/1 file; they are fitted unless it is given. simulated: a
    recording of the same run by another simulator, in place of the model's prediction. progress:
    is told what is being done.
    Raises Unusable for a result, a simulation or a folder that cannot be used.
    """
    # Late: the other stages need none of it.
    from tasks.explain.correction.consequences import consequences
    from tasks.explain.explain import explain
    from tasks.explain.locate import locate
    from tasks.explain.report import discrepancy_of, write_report

    _check_folder(out)
    recording = runs.load(run, home)
    told = _told(recording, home, calibration, simulated)
    explanation = explain(recording, told=told, progress=progress)
    progress("consequences")
    effects = consequences(recording, explanation, _tolerance(recording, home))
    explanation = replace(explanation, remarks=(*explanation.remarks, *effects.remarks))
    wheres = locate(explanation) if explanation.findings else ()
    discrepancy = discrepancy_of(explanation, wheres, effects.of_findings, effects.changes)
    progress("report")
    files = () if out is None else tuple(write_report(discrepancy, explanation, out))
    return Explained(discrepancy, files)


def _told(
    recording: Recording, home: Home, calibration: str | None, simulated: Path | None
) -> "Told | None":
    """What a calibration or another simulator says the unit should have read; None: neither."""
    from tasks.explain.inputs.reference import Told

    if simulated is not None:
        said = message("explain-model-simulation")
        return Told(simulated_readings(recording, simulated), said)
    if calibration is None:
        return None
    from tasks.model.simulate import predict
    from tasks.model.terms.standard import STANDARD_TERMS
    from tasks.motion.whole import whole_motion
    from tasks.stages.simulate import model_values

    values, _ = model_values(calibration_named(calibration, home))
    said = message("explain-model-calibration")
    return Told(predict(STANDARD_TERMS, whole_motion(recording), values), said)


def calibration_named(reference: str, home: Home) -> Calibration:
    """A result by its id in the store, or from a mimu-calibration/1 file.

    Raises Unusable for neither.
    """
    try:
        path = Path(reference) if Path(reference).is_file() else None
    except (OSError, ValueError):  # too long for a path, or with a NUL: then it is none
        path = None
    if path is None:
        return results.find(reference, home).calibration
    return settings.read_calibration(path)


def simulated_readings(recording: Recording, path: Path) -> np.ndarray:
    """What another simulator says of a recording: (n, 6) rad/s and m/s² at the unit's rows.

    Interpolated linearly where its rows are not the unit's; NaN where it says nothing.
    Raises Unusable for a simulation of another stretch of time, or without gyro and accelerometer.
    """
    t, other = recording.imu.t, refuse.read(path).imu
    readings = np.full((len(t), len(GYRO + ACCEL)), np.nan)
    between = _within(other.t, t)
    for channel, name in enumerate(GYRO + ACCEL):
        if name in other.columns:
            values = np.interp(t, other.t, other.columns[name])
            readings[between, channel] = values[between]
    said = np.isfinite(readings).any(axis=1)
    if said.mean() < FEWEST_ROWS:
        raise Unusable(
            f"{path}: it says what the unit reads in {100.0 * said.mean():.0f} % of the rows of "
            f"{recording.manifest.recording_id} only, whose {len(t)} rows go from {t[0]:g} s to "
            f"{t[-1]:g} s; give gyro_* and accel_* at the times of the unit's own stream."
        )
    return readings


def _within(known: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(n,) bool: which times t fall on a known one or between two that are near each other."""
    step = WIDEST_STEP * float(np.median(np.diff(t))) if len(t) > 1 else np.inf
    after = np.clip(np.searchsorted(known, t), 0, len(known) - 1)
    before = np.clip(after - 1, 0, None)
    inside = (t > known[before]) & (t < known[after])
    return (known[after] == t) | (inside & (known[after] - known[before] <= step))


def _tolerance(recording: Recording, home: Home) -> Tolerance | None:
    unit = recording.manifest.unit
    return settings.tolerance_for(unit.manufacturer, unit.model, home)


def _check_folder(out: Path | None) -> None:
    """Refuses what cannot become a folder before the work begins."""
    if out is None:
        return
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Unusable(
            f"{out} cannot be made a folder ({error.strerror}); name another with --out."
        ) from error
