"""The parameters of models (1) and (2) that a calibration's items give, in SI."""

from collections.abc import Mapping

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Calibration, Elements
from tasks.model.parameters import DEG
from tasks.model.term import Parameter, nominal_values, places
from tasks.model.terms.standard import STANDARD_TERMS

PER_SI: Mapping[str, float] = {"deg/s": DEG, "(deg/s)/g": DEG}  # of the model's unit, else 1
ITEMS_OF: Mapping[str, tuple[str, str]] = {
    "gyro_matrix": ("gyro_scale_factor", "gyro_cross_coupling"),
    "accel_matrix": ("accel_scale_factor", "accel_cross_coupling"),
}  # of the other terms the item has the term's name
OPPOSITE = "accel_rate_sensitivity"  # its sign by eq. (12) is not that of model (2)


def model_values(
    calibration: Calibration, *, earth_in_sensitivity: bool = True
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Parameters (p,), SI, of models (1) and (2) from a calibration's items.

    Also the elements that it does not give and that are taken as those of an ideal unit. The
    accelerometers' rate sensitivity is that of model (2), whose sign is not that of eq. (12).
    earth_in_sensitivity: whether the g-sensitivity is that of eq. (7), which contains the vertical
    part of Earth's rotation. Raises Unusable for a calibration without any of these items.
    """
    values, assumed = nominal_values(STANDARD_TERMS), []
    for number, term, parameter in _numbered():
        item, element = _item_and_element(term, parameter)
        value = _values(calibration, item, earth_in_sensitivity).get(element)
        if value is None:
            assumed.append(f"{term} {parameter.name}")
        else:
            values[number] = value * _to_si(calibration, item)
    if len(assumed) == len(values):
        raise Unusable(
            f"the calibration of {calibration.recording_id} by {calibration.method} has no item of "
            "models (1) and (2) of JJF 2003; give one by the method jjf2003 or joint."
        )
    return values, tuple(assumed)


def model_uncertainties(calibration: Calibration) -> np.ndarray:
    """Expanded uncertainties (p,), SI, of the same parameters; NaN if there is none.

    That of the g-sensitivity is the one without Earth's rotation, if there are both.
    """
    expanded = np.full(len(nominal_values(STANDARD_TERMS)), np.nan)
    for number, term, parameter in _numbered():
        name, element = _item_and_element(term, parameter)
        item = calibration.items.get(name)
        known = (item.U_without_earth_rotation or item.U) if item else {}
        value = known.get(element)
        if value is not None:
            expanded[number] = value * _to_si(calibration, name)
    return expanded


def parameter_covariance(calibration: Calibration) -> np.ndarray | None:
    """Covariance (p, p), SI, of the parameters; None where the calibration has none.

    NaN in row and column of a parameter without an uncertainty. Signs are those of the models.
    """
    covariance = calibration.covariance
    if covariance is None:
        return None
    place = {name: i for i, name in enumerate(covariance.elements)}
    matrix = np.zeros((len(place), len(place)))
    matrix[np.tril_indices(len(place))] = [each for row in covariance.rows for each in row]
    matrix += np.tril(matrix, -1).T
    every = _numbered()
    taken, factors = np.full(len(every), -1), np.full(len(every), np.nan)
    for number, term, parameter in every:
        item, element = _item_and_element(term, parameter)
        if f"{item}.{element}" in place:
            taken[number] = place[f"{item}.{element}"]
            sign = -1.0 if item == OPPOSITE else 1.0
            factors[number] = sign * _to_si(calibration, item)
    return matrix[np.ix_(taken, taken)] * np.outer(factors, factors)


def _numbered() -> list[tuple[int, str, Parameter]]:
    """Every parameter with its place among all and its term's name."""
    return [
        (number, term.name, parameter)
        for term, place in zip(STANDARD_TERMS, places(STANDARD_TERMS), strict=True)
        for number, parameter in enumerate(term.parameters, start=place.start)
    ]


def _item_and_element(term: str, parameter: Parameter) -> tuple[str, str]:
    """Where a parameter stands; a diagonal element of a matrix stands under its axis."""
    name = parameter.name
    if term not in ITEMS_OF:
        return term, name
    diagonal, off_diagonal = ITEMS_OF[term]
    return (diagonal, name[0]) if name[0] == name[-1] else (off_diagonal, name)


def _values(calibration: Calibration, name: str, earth_in_sensitivity: bool) -> Elements:
    """An item's values as the models have them."""
    item = calibration.items.get(name)
    if item is None:
        return {}
    if name == OPPOSITE:
        opposite = {e: None if value is None else -value for e, value in item.value.items()}
        return item.value_model or opposite
    if name == "gyro_g_sensitivity" and not earth_in_sensitivity:
        return item.value_without_earth_rotation or item.value
    return item.value


def _to_si(calibration: Calibration, name: str) -> float:
    return 1.0 / PER_SI.get(calibration.items[name].unit, 1.0)
