"""Corrects readings for a unit's errors: models (1) and (2) of JJF 2003-2022 solved for the input.

The gyro reads ω′ = K_g·ω + B_g + G·f and the accelerometer a′ = K_a·f + B_a + P·ω², each with what
the other one is to find. They are solved in turn; a pass leaves |G|·|P|·2ω of the error before it,
some 1e-5 at 300 °/s.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Calibration, Elements
from schemas.recording import AXES
from tasks.model.term import DEG, MATRIX, OFF_DIAGONAL, Parameter, nominal_values, places
from tasks.model.terms.standard import GYRO_G_SENSITIVITY, STANDARD_TERMS
from tasks.segments.summarise import CHANNELS

# The parameters of models (1) and (2) that a calibration's items give, in SI.

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


PASSES = 2
GRAVITY = "gravity_m_s2"  # among a calibration's settings


@dataclass(frozen=True)
class Coefficients:
    """What models (1) and (2) have: matrices (3, 3) and vectors (3,), SI.

    gyro_g_sensitivity: (rad/s)/(m/s²), without Earth's rotation.
    """

    gyro_matrix: np.ndarray
    gyro_bias: np.ndarray
    gyro_g_sensitivity: np.ndarray
    accel_matrix: np.ndarray
    accel_bias: np.ndarray
    accel_rate_sensitivity: np.ndarray


def coefficients(calibration: Calibration) -> tuple[Coefficients, Coefficients, tuple[str, ...]]:
    """A calibration's coefficients, their U (NaN where none), the elements taken as ideal.

    Raises Unusable for a calibration that has no item of models (1) and (2).
    """
    gravity = local_gravity(calibration)
    values, assumed = model_values(calibration, earth_in_sensitivity=False)
    return (
        _arranged(values, gravity, absent=0.0),
        _arranged(model_uncertainties(calibration), gravity, absent=np.nan),
        assumed,
    )


def local_gravity(calibration: Calibration) -> float:
    """The local gravity (m/s²) that a calibration was made with; Unusable where it says none."""
    gravity = calibration.settings.get(GRAVITY)
    if isinstance(gravity, float) and gravity > 0.0:
        return gravity
    raise Unusable(
        f"the calibration of {calibration.recording_id}: settings.{GRAVITY} is {gravity!r}; "
        f"calibrate run {calibration.run} again."
    )


def correct(
    known: Coefficients, gyro: np.ndarray, accel: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Rate (n, 3) rad/s and specific force (n, 3) m/s² from readings (n, 3) of both triads.

    The rate is that against inertial space, Earth's rotation included. A row of which one triad
    is NaN is NaN in both, unless the other's term in it is zero throughout.
    """
    gyro, accel = gyro - known.gyro_bias, accel - known.accel_bias
    force = np.linalg.solve(known.accel_matrix, accel.T).T
    rate = gyro
    for _ in range(PASSES):
        felt = _product(known.gyro_g_sensitivity, force)
        rate = np.linalg.solve(known.gyro_matrix, (gyro - felt).T).T
        turned = _product(known.accel_rate_sensitivity, rate**2)
        force = np.linalg.solve(known.accel_matrix, (accel - turned).T).T
    return rate, force


def _product(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Matrix times each row (n, 3); zero for a matrix of zeros, whatever the rows."""
    return vectors @ matrix.T if matrix.any() else np.zeros_like(vectors)


def _arranged(values: np.ndarray, gravity: float, absent: float) -> Coefficients:
    """Parameters (p,) of the standard's terms as matrices; `absent` where P has no element."""
    gyro, bias, sensitivity, accel, offset, squared = (
        values[place] for place in places(STANDARD_TERMS)
    )
    return Coefficients(
        _matrix(gyro, MATRIX, absent), bias, _matrix(sensitivity / gravity, MATRIX, absent),
        _matrix(accel, MATRIX, absent), offset, _matrix(squared, OFF_DIAGONAL, absent),
    )  # fmt: skip


def _matrix(values: np.ndarray, elements: tuple[tuple[int, int], ...], absent: float) -> np.ndarray:
    matrix = np.full((3, 3), absent)
    matrix[tuple(np.transpose(elements))] = values
    return matrix


# The standard uncertainty of corrected readings, from the covariance of the calibration.
#
# Of models (1) and (2) an error of the parameters leaves, in what is corrected by them,
#
# δf = −K_a⁻¹·(δK_a·f + δB_a + δP·ω²), δω = −K_g⁻¹·(δK_g·ω + δB_g + δG·f + G·δf):
#
# for each channel a sum over 1, ω, f and ω² with coefficients that are linear in the parameters.
# Its variance is a quadratic form in these ten numbers, constant for the calibration. What δω
# does to P·ω² is left out: of a unit with P = 1 cm at 300 °/s a tenth of the least that K_a
# leaves.

ONE, RATE, FORCE, SQUARED = 0, 1, 4, 7  # first places among 1, ω, f, ω²
FEATURES = 10
# Where each term stands: first channel, and the first of what it multiplies.
TERMS = {
    "gyro_matrix": (0, RATE), "gyro_bias": (0, ONE), "gyro_g_sensitivity": (0, FORCE),
    "accel_matrix": (3, FORCE), "accel_bias": (3, ONE), "accel_rate_sensitivity": (3, SQUARED),
}  # fmt: skip
AT_ONCE = 1 << 12  # rows: what is made of them stays in the processor's cache


@dataclass(frozen=True)
class ReadingUncertainty:
    """The variance of each corrected channel as a quadratic form in (1, ω, f, ω²), SI.

    forms: (6, 10, 10); NaN for a channel of which a parameter has no uncertainty.
    """

    forms: np.ndarray

    @property
    def unknown(self) -> tuple[str, ...]:
        """The channels of which the calibration does not give it."""
        known = np.isfinite(self.forms).all(axis=(1, 2))
        return tuple(name for name, is_known in zip(CHANNELS, known, strict=True) if not is_known)

    def of_rows(self, rate: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Standard uncertainties (n, 6) of corrected rates and forces (n, 3), rad/s and m/s².

        The errors are those of the calibration: common to all rows, and the readings' own noise is
        not in them.
        """
        u = np.empty((len(rate), len(CHANNELS)))
        for begin in range(0, len(rate), AT_ONCE):
            rows = slice(begin, begin + AT_ONCE)
            basis = _basis(rate[rows], force[rows])
            for channel, form in enumerate(self.forms):
                u[rows, channel] = np.einsum("nf,nf->n", basis @ form, basis)
        return np.asarray(np.sqrt(np.maximum(u, 0.0, out=u), out=u))

    def rms(self, rate: np.ndarray, force: np.ndarray) -> dict[str, float]:
        """Root mean square of `of_rows` for each channel that has it, without making the rows."""
        moment, count = np.zeros((FEATURES, FEATURES)), 0
        for begin in range(0, len(rate), AT_ONCE):
            basis = _basis(rate[begin : begin + AT_ONCE], force[begin : begin + AT_ONCE])
            basis = basis[np.isfinite(basis).all(axis=1)]
            moment += basis.T @ basis
            count += len(basis)
        mean = np.sqrt(np.maximum((self.forms * moment).sum(axis=(1, 2)) / max(count, 1), 0.0))
        every = dict(zip(CHANNELS, mean.tolist(), strict=True))
        return {name: u for name, u in every.items() if name not in self.unknown}


def reading_uncertainty(calibration: Calibration, known: Coefficients) -> ReadingUncertainty | None:
    """How well readings are corrected by a calibration; None where it has no covariance."""
    covariance = parameter_covariance(calibration)
    if covariance is None:
        return None
    per_g = 1.0 / local_gravity(calibration)
    design = np.zeros((len(CHANNELS), FEATURES, len(covariance)))
    for term, place in zip(STANDARD_TERMS, places(STANDARD_TERMS), strict=True):
        channel, feature = TERMS[term.name]
        for number, parameter in enumerate(term.parameters, start=place.start):
            reads, *of = (AXES.index(axis) for axis in parameter.name)
            weight = per_g if term is GYRO_G_SENSITIVITY else 1.0
            design[channel + reads, feature + (of[0] if of else 0), number] = weight
    has_none = np.isnan(np.diag(covariance))
    unknown = (design[:, :, has_none] != 0.0).any(axis=(1, 2))
    weights = np.tensordot(_solved(known), design, axes=1)
    forms = weights @ np.nan_to_num(covariance) @ weights.swapaxes(1, 2)
    forms[unknown] = np.nan
    return ReadingUncertainty(forms)


def _solved(known: Coefficients) -> np.ndarray:
    """(6, 6): corrected rates and forces per what is wrong with both sums that are taken off."""
    by_gyro, by_accel = np.linalg.inv(known.gyro_matrix), np.linalg.inv(known.accel_matrix)
    through = -by_gyro @ known.gyro_g_sensitivity @ by_accel
    return -np.block([[by_gyro, through], [np.zeros((3, 3)), by_accel]])


def _basis(rate: np.ndarray, force: np.ndarray) -> np.ndarray:
    """1, ω, f and ω² (n, 10)."""
    return np.hstack([np.ones((len(rate), 1)), rate, force, rate**2])
