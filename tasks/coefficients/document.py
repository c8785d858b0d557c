"""The correction as a document: coefficients with units and U, formulas, an example."""

import numpy as np

from schemas.calibration import Calibration
from schemas.correction import Coefficient, CorrectedUnit, Correction, CorrectionExample
from schemas.recording import Unit
from tasks.coefficients.correct import PASSES, Coefficients, coefficients, correct, local_gravity

MODEL = ("gyro = K_g*rate + B_g + G*force", "accel = K_a*force + B_a + P*rate^2")
FIRST = "force = C_a*(accel - B_a)"
PASS = ("rate = C_g*(gyro - B_g - G*force)", "force = C_a*(accel - B_a - P*rate^2)")
# rad/s and m/s² within every unit's range, different on each axis.
EXAMPLE_GYRO = np.array([[0.5, -1.0, 2.0]])
EXAMPLE_ACCEL = np.array([[1.0, -2.0, 9.5]])


def document(calibration: Calibration, unit: Unit | None) -> Correction:
    """The correction that a calibration gives; raises Unusable where it gives none."""
    known, expanded, assumed = coefficients(calibration)
    return Correction(
        unit=_named(unit) if unit else None,
        recording_id=calibration.recording_id,
        run=calibration.run,
        digest=calibration.digest,
        method=calibration.method,
        code_version=calibration.code_version,
        gravity_m_s2=local_gravity(calibration),
        model=MODEL,
        correction=(FIRST, *PASS * PASSES),
        coefficients=_coefficients(known, expanded),
        assumed_ideal=assumed,
        left_in=tuple(term.name for term in calibration.terms),
        example=_example(known),
    )


def _named(unit: Unit) -> CorrectedUnit:
    return CorrectedUnit(manufacturer=unit.manufacturer, model=unit.model, serial=unit.serial)


def _coefficients(known: Coefficients, expanded: Coefficients) -> dict[str, Coefficient]:
    """Those of the model with U, and the inverse matrices of the correction."""

    def one(unit: str, name: str) -> Coefficient:
        U: np.ndarray = getattr(expanded, name).astype(object)
        U[np.isnan(getattr(expanded, name))] = None
        return Coefficient(unit=unit, value=getattr(known, name).tolist(), U=U.tolist())

    return {
        "K_g": one("1", "gyro_matrix"),
        "B_g": one("rad/s", "gyro_bias"),
        "G": one("(rad/s)/(m/s2)", "gyro_g_sensitivity"),
        "K_a": one("1", "accel_matrix"),
        "B_a": one("m/s2", "accel_bias"),
        "P": one("m", "accel_rate_sensitivity"),
        "C_g": Coefficient(unit="1", value=np.linalg.inv(known.gyro_matrix).tolist()),
        "C_a": Coefficient(unit="1", value=np.linalg.inv(known.accel_matrix).tolist()),
    }


def _example(known: Coefficients) -> CorrectionExample:
    rate, force = correct(known, EXAMPLE_GYRO, EXAMPLE_ACCEL)
    rows = (EXAMPLE_GYRO[0], EXAMPLE_ACCEL[0], rate[0], force[0])
    gyro, accel, corrected_rate, corrected_force = (tuple(row.tolist()) for row in rows)
    return CorrectionExample(gyro=gyro, accel=accel, rate=corrected_rate, force=corrected_force)
