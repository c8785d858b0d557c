"""Stages: the correction of a result, a recording corrected with it, and one simulated by it."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Calibration, Correction
from schemas.orders import ApplyOrder, ExportOrder, SimulateOrder
from schemas.recording import ACCEL, GYRO, Manifest, Recording, Stream, Unit
from storage.catalogue import runs
from storage.catalogue.runs import Run
from storage.formats.content import write_columns
from storage.home import Home
from tasks.coefficients.correct import (
    Coefficients,
    coefficients,
    correct,
    model_values,
    reading_uncertainty,
)
from tasks.coefficients.exports import as_c, as_csv, as_json, as_kalibr, as_ros, as_yaml, document
from tasks.model.model import predict
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import whole_motion
from tasks.stages.estimate import correcting_calibration, estimate, read_calibration
from tasks.stages.stage import stage

OF_CORRECTION = {"json": as_json, "yaml": as_yaml, "c": as_c, "ros": as_ros, "csv": as_csv}


@dataclass(frozen=True)
class Simulated:
    """A simulated recording: its folder, its rows, and what was assumed ideal or omitted.

    assumed: elements that the calibration does not give. rows_left_out: where the motion is not
    known.
    """

    folder: Path
    rows: int
    rows_left_out: int
    assumed: tuple[str, ...] = ()


@dataclass(frozen=True)
class Corrected:
    """A corrected recording: its folder, its rows, and what was assumed ideal or left uncorrected.

    rows_left_out: with gyro or accelerometer alone, which is corrected for what the other reads.
    u_rms: of each corrected channel that has it, the root mean square of its standard uncertainty
    by the calibration, rad/s and m/s².
    """

    folder: Path
    rows: int
    rows_left_out: int
    assumed: tuple[str, ...]
    left_in: tuple[str, ...]
    u_rms: dict[str, float]


def export_correction(order: ExportOrder, home: Home) -> tuple[Correction, str]:
    """The correction of a result, and its text in the form that is ordered.

    Raises Unusable for the result of an invalid run or of an AHRS, and for what a form asks for
    and the run does not show.
    """
    calibration = correcting_calibration(order.calibration, home)
    recording = _recording_of(calibration, home)
    made = document(calibration, recording.manifest.unit if recording else None)
    if order.form != "kalibr":
        return made, OF_CORRECTION[order.form](made)
    if recording is None:
        raise Unusable(
            f"run {calibration.run} of {calibration.recording_id} is not in {home.path}, and "
            "kalibr asks for its sampling rate and noise: import the recording, or export another "
            "form."
        )
    return made, as_kalibr(made, calibration, recording)


@stage("apply")
def apply_correction(run: Run, home: Home, order: ApplyOrder) -> Corrected:
    """Write a run corrected for its unit's errors, as a mimu-recording/1 folder.

    Table, pose, environment and segments are the run's own. Raises Unusable for the result of
    another unit, of an invalid run or of an AHRS, for an existing folder, and where uncertainties
    are asked for that the result does not give.
    """
    calibration = correcting_calibration(order.calibration, home)
    known, _, assumed = coefficients(calibration)
    recording, source = runs.load(run, home), _recording_of(calibration, home)
    if source is not None:
        _check_unit(source.manifest.unit, recording.manifest, order.calibration)
    uncertainty = reading_uncertainty(calibration, known)
    if order.with_u and (uncertainty is None or len(uncertainty.unknown) == len(GYRO + ACCEL)):
        raise Unusable(
            f"{order.calibration} has no covariance of its elements, so the uncertainty of what it "
            "corrects is not known: calibrate the run again without --uncertainty, or leave "
            "--with-u out."
        )
    corrected, out = corrected_recording(recording, known, calibration), Path(order.out)
    u_rms = {}
    if uncertainty is not None:
        rows = slice(0, len(corrected.imu))
        rate, force = (corrected.imu.stack(names, rows) for names in (GYRO, ACCEL))
        u_rms = uncertainty.rms(rate, force)
        if order.with_u:
            u = uncertainty.of_rows(rate, force)
            columns = {
                f"u_{name}": np.ascontiguousarray(u[:, (GYRO + ACCEL).index(name)])
                for name in u_rms
            }
            imu = corrected.imu
            corrected = replace(corrected, imu=Stream(imu.t, {**imu.columns, **columns}, imu.span))
    _write(corrected, out)
    left_in = tuple(term.name for term in calibration.terms)
    left_out = len(recording.imu) - len(corrected.imu)
    return Corrected(out, len(corrected.imu), left_out, assumed, left_in, u_rms)


def corrected_recording(
    recording: Recording, known: Coefficients, calibration: Calibration
) -> Recording:
    """The recording with corrected rates and specific forces; its other columns as they are.

    Rows of which nothing can be corrected are left out.
    """
    rows, manifest = slice(0, len(recording.imu)), recording.manifest
    gyro, accel = (recording.imu.stack(names, rows) for names in (GYRO, ACCEL))
    rate, force = correct(known, gyro, accel)
    corrected = np.isfinite(np.hstack([rate, force])).any(axis=1)
    if not corrected.any():
        raise Unusable(
            f"{manifest.recording_id} has no row with gyro_* and accel_*, and each is corrected "
            "for what the other reads; give a recording that has both."
        )
    columns = {**recording.imu.columns}
    columns |= {name: column for name, column in zip(GYRO + ACCEL, (*rate.T, *force.T), strict=True)
                if name in columns}  # fmt: skip
    fields = manifest.model_dump() | {
        "recording_id": f"{manifest.recording_id}_corrected",
        "corrected_by": {"recording_id": calibration.recording_id, "run": calibration.run,
                         "method": calibration.method, "code_version": calibration.code_version},
    }  # fmt: skip
    columns = {name: np.ascontiguousarray(column) for name, column in columns.items()}
    imu = Stream(recording.imu.t, columns, recording.imu.span).at(corrected)
    return replace(recording, manifest=Manifest.model_validate(fields), imu=imu, digest="")


def _write(recording: Recording, out: Path) -> None:
    try:
        write_columns(recording, out)
    except OSError as error:  # FileExistsError is one
        raise Unusable(
            f"{out} cannot be written ({error.strerror or error}); name a new folder with --out."
        ) from error


def _recording_of(calibration: Calibration, home: Home) -> Recording | None:
    """The recording that a calibration was made of, if it is in the store."""
    for run in runs.all_runs(home):
        if run.digest == calibration.digest:
            return runs.load(run, home)
    return None


def _check_unit(unit: Unit, manifest: Manifest, reference: str) -> None:
    def named(unit: Unit) -> tuple[str, str, str]:
        return unit.manufacturer, unit.model, unit.serial

    if named(unit) != named(manifest.unit):
        raise Unusable(
            f"{reference} corrects {' '.join(named(unit))}, but {manifest.recording_id} is of "
            f"{' '.join(named(manifest.unit))}; give a result of that unit."
        )


@stage("simulate")
def simulate_run(run: Run, home: Home, order: SimulateOrder) -> Simulated:
    """Write what models (1) and (2) read on a run's motion as a mimu-recording/1 folder.

    Without a calibration in the order it is the run's own, by the method of its specification.
    The folder has the run's own table, pose and environment.
    Raises Unusable where no motion is known, or the calibration is of another kind of unit.
    """
    recording = runs.load(run, home)
    given = read_calibration(order.calibration, home) if order.calibration else estimate(run, home)
    values, assumed = model_values(given)
    out = Path(order.out)
    simulated = simulated_recording(recording, values)
    _write(simulated, out)
    rows = len(simulated.imu)
    return Simulated(out, rows, len(recording.imu) - rows, assumed)


def simulated_recording(recording: Recording, values: np.ndarray) -> Recording:
    """The recording as models (1) and (2) with parameters (p,), SI, read its motion.

    Rows of unknown motion are left out; a triad that needs more than is known there is null.
    """
    readings = predict(STANDARD_TERMS, whole_motion(recording), values)
    known = np.isfinite(readings).any(axis=1)
    manifest = recording.manifest
    if not known.any():
        raise Unusable(
            f"{manifest.recording_id}: neither encoders nor a pose nor labels tell how the unit "
            "moved, so nothing can be simulated; add a table or reference stream, or segments."
        )
    fields = manifest.model_dump() | {
        "recording_id": f"{manifest.recording_id}_simulated",
        "simulated": True,
    }
    imu = Stream(
        recording.imu.t[known], dict(zip(GYRO + ACCEL, readings[known].T.copy(), strict=True))
    )
    return replace(recording, manifest=Manifest.model_validate(fields), imu=imu, digest="")
