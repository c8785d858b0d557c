"""Corrects readings for a unit's errors: models (1) and (2) of JJF 2003-2022 solved for the input.

The gyro reads ω′ = K_g·ω + B_g + G·f and the accelerometer a′ = K_a·f + B_a + P·ω², each with what
the other one is to find. They are solved in turn; a pass leaves |G|·|P|·2ω of the error before it,
some 1e-5 at 300 °/s.
"""

from dataclasses import dataclass

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Calibration
from tasks.coefficients.parameters import model_uncertainties, model_values
from tasks.model.parameters import MATRIX, OFF_DIAGONAL
from tasks.model.term import places
from tasks.model.terms.standard import STANDARD_TERMS

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
