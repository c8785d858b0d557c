"""Stage: what a unit with a given calibration would have read on a run's motion."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from schemas.base import Unusable
from schemas.orders import SimulateOrder
from schemas.recording import ACCEL, GYRO, Manifest, Recording, Stream
from storage.catalogue import runs
from storage.catalogue.run_index import Run
from storage.formats.columns import write_columns
from storage.home import Home
from tasks.coefficients.parameters import model_values
from tasks.model.simulate import predict
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import whole_motion
from tasks.stages.calibration_input import read_calibration
from tasks.stages.estimate import estimate
from tasks.stages.stage import stage


@dataclass(frozen=True)
class Simulated:
    """A simulated recording: its folder, its rows, and what had to be taken as ideal or left out.

    assumed: elements that the calibration does not give. rows_left_out: where the motion is not
    known.
    """

    folder: Path
    rows: int
    rows_left_out: int
    assumed: tuple[str, ...] = ()


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
    try:
        write_columns(simulated, out)
    except OSError as error:  # FileExistsError is one
        raise Unusable(
            f"{out} cannot be written ({error.strerror or error}); name a new folder with --out."
        ) from error
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
