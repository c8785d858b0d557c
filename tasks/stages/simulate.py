"""Stage: what a unit with a given calibration would have read on a run's motion."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.recording import ACCEL, GYRO, Manifest, Recording, Stream
from storage.catalogue import runs
from storage.catalogue.runs import Run
from storage.formats.columns import write_columns
from storage.home import Home
from tasks.model.simulate import predict
from tasks.model.term import Parameter, nominal_values, places
from tasks.model.terms.standard import DEG, STANDARD_TERMS
from tasks.motion.whole import whole_motion
from tasks.stages.estimate import estimate
from tasks.stages.explain import calibration_named

PRINTED: Mapping[str, float] = {"deg/s": DEG, "(deg/s)/g": DEG}  # per SI unit of the model
ITEMS_OF: Mapping[str, tuple[str, ...]] = {
    "gyro_matrix": ("gyro_scale_factor", "gyro_cross_coupling"),
    "accel_matrix": ("accel_scale_factor", "accel_cross_coupling"),
}  # of the other terms the item has the term's name


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


def simulate_run(run: Run, home: Home, out: Path, calibration: str | None = None) -> Simulated:
    """Write what models (1) and (2) read on a run's motion as a mimu-recording/1 folder.

    calibration: a result's id or a mimu-calibration/1 file; the run's own by the method of its
    specification unless it is given. The folder has the run's own table, pose and environment.
    Raises Unusable where no motion is known, or the calibration is of another kind of unit.
    """
    recording = runs.load(run, home)
    given = calibration_named(calibration, home) if calibration else estimate(run, home)
    values, assumed = model_values(given)
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
    said = manifest.model_dump() | {
        "recording_id": f"{manifest.recording_id}_simulated",
        "simulated": True,
    }
    imu = Stream(
        recording.imu.t[known], dict(zip(GYRO + ACCEL, readings[known].T.copy(), strict=True))
    )
    return replace(recording, manifest=Manifest.model_validate(said), imu=imu, digest="")


def model_values(calibration: Calibration) -> tuple[np.ndarray, tuple[str, ...]]:
    """Parameters (p,), SI, of models (1) and (2) from a calibration's items.

    Also the elements that it does not give and that are taken as those of an ideal unit. The
    accelerometers' rate sensitivity is that of model (2), whose sign is not that of eq. (12).
    Raises Unusable for a calibration without any of these items.
    """
    values, assumed = nominal_values(STANDARD_TERMS), []
    for term, place in zip(STANDARD_TERMS, places(STANDARD_TERMS), strict=True):
        for number, parameter in enumerate(term.parameters, start=place.start):
            found = _element(calibration, term.name, parameter)
            if found is None:
                assumed.append(f"{term.name} {parameter.name}")
            else:
                values[number] = found
    if len(assumed) == len(values):
        raise Unusable(
            f"the calibration of {calibration.recording_id} by {calibration.method} has no item of "
            "models (1) and (2) of JJF 2003; give one by the method jjf2003 or joint."
        )
    return values, tuple(assumed)


def _element(calibration: Calibration, term: str, parameter: Parameter) -> float | None:
    """One parameter in SI; a diagonal element of a matrix stands in the item under its axis."""
    element = parameter.name
    item_of = ITEMS_OF.get(term)
    name = term
    if item_of:
        diagonal = element[0] == element[-1]
        name, element = (item_of[0], element[0]) if diagonal else (item_of[1], element)
    item = calibration.items.get(name)
    if item is None:
        return None
    if term == "accel_rate_sensitivity":
        by_clause = item.value.get(element)
        opposite = {} if by_clause is None else {element: -by_clause}
        return (item.value_model or opposite).get(element)
    found = item.value.get(element)
    return None if found is None else found / PRINTED.get(item.unit, 1.0)
