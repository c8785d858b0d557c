"""A calibration that an order names, and the parameters of models (1) and (2) that it gives."""

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Calibration
from storage import settings
from storage.catalogue import results
from storage.home import Home
from tasks.model.parameters import DEG
from tasks.model.term import Parameter, nominal_values, places
from tasks.model.terms.standard import STANDARD_TERMS

PER_SI: Mapping[str, float] = {"deg/s": DEG, "(deg/s)/g": DEG}  # of the model's unit, else 1
ITEMS_OF: Mapping[str, tuple[str, str]] = {
    "gyro_matrix": ("gyro_scale_factor", "gyro_cross_coupling"),
    "accel_matrix": ("accel_scale_factor", "accel_cross_coupling"),
}  # of the other terms the item has the term's name


def read_calibration(reference: str, home: Home) -> Calibration:
    """A result by its id in the store, or from a mimu-calibration/1 file.

    Raises Unusable for neither.
    """
    if os.path.isfile(reference):  # of a text that can be no path it says no; Path.is_file raises
        return settings.read(Path(reference), Calibration)
    return results.find(reference, home).calibration


def model_values(calibration: Calibration) -> tuple[np.ndarray, tuple[str, ...]]:
    """Parameters (p,), SI, of models (1) and (2) from a calibration's items.

    Also the elements that it does not give and that are taken as those of an ideal unit. The
    accelerometers' rate sensitivity is that of model (2), whose sign is not that of eq. (12).
    Raises Unusable for a calibration without any of these items.
    """
    values, assumed = nominal_values(STANDARD_TERMS), []
    for term, place in zip(STANDARD_TERMS, places(STANDARD_TERMS), strict=True):
        for number, parameter in enumerate(term.parameters, start=place.start):
            value = _value_si(calibration, term.name, parameter)
            if value is None:
                assumed.append(f"{term.name} {parameter.name}")
            else:
                values[number] = value
    if len(assumed) == len(values):
        raise Unusable(
            f"the calibration of {calibration.recording_id} by {calibration.method} has no item of "
            "models (1) and (2) of JJF 2003; give one by the method jjf2003 or joint."
        )
    return values, tuple(assumed)


def _value_si(calibration: Calibration, term: str, parameter: Parameter) -> float | None:
    """One parameter in SI; a diagonal element of a matrix stands in the item under its axis."""
    name, element = term, parameter.name
    if term in ITEMS_OF:
        diagonal, off_diagonal = ITEMS_OF[term]
        name, element = (
            (diagonal, element[0]) if element[0] == element[-1] else (off_diagonal, element)
        )
    item = calibration.items.get(name)
    if item is None:
        return None
    value = item.value.get(element)
    if term == "accel_rate_sensitivity":
        by_clause = {} if value is None else {element: -value}
        return (item.value_model or by_clause).get(element)
    return None if value is None else value / PER_SI.get(item.unit, 1.0)
