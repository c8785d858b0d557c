"""A correction for other software: YAML, ROS 2 parameters, CSV, a C header, kalibr."""

import csv
import io
from dataclasses import dataclass
from typing import Any

import numpy as np

from schemas.base import Unusable
from schemas.calibration import (
    Calibration,
    Coefficient,
    CorrectedUnit,
    Correction,
    CorrectionExample,
)
from schemas.recording import ACCEL, AXES, GYRO, Recording, Unit
from tasks.calibrate.information.noise import allan_curve
from tasks.coefficients.correct import PASSES, Coefficients, coefficients, correct, local_gravity
from tasks.model.term import DEG

# A correction, and as text for other software: YAML, ROS 2 parameters, CSV, a C header.

FORCES = ("accel", "force")
FUNCTION = """
/* Corrects one reading: gyro rad/s, accel m/s2 into rate rad/s, force m/s2. */
static inline void mimu_correct(const double gyro[3], const double accel[3],
                                double rate[3], double force[3])
{
    double squared[3] = {0.0, 0.0, 0.0};
    int pass, i, j;
    for (pass = 0; pass <= MIMU_PASSES; pass++) {
        double without[3];
        for (i = 0; i < 3; i++) {
            without[i] = accel[i] - MIMU_B_a[i];
            for (j = 0; j < 3; j++)
                without[i] -= MIMU_P[i][j] * squared[j];
        }
        for (i = 0; i < 3; i++) {
            force[i] = 0.0;
            for (j = 0; j < 3; j++)
                force[i] += MIMU_C_a[i][j] * without[j];
        }
        if (pass == MIMU_PASSES)
            return;
        for (i = 0; i < 3; i++) {
            without[i] = gyro[i] - MIMU_B_g[i];
            for (j = 0; j < 3; j++)
                without[i] -= MIMU_G[i][j] * force[j];
        }
        for (i = 0; i < 3; i++) {
            rate[i] = 0.0;
            for (j = 0; j < 3; j++)
                rate[i] += MIMU_C_g[i][j] * without[j];
        }
        for (i = 0; i < 3; i++)
            squared[i] = rate[i] * rate[i];
    }
}
"""
MODEL = ("gyro = K_g*rate + B_g + G*force", "accel = K_a*force + B_a + P*rate^2")
FIRST = "force = C_a*(accel - B_a)"
PASS = ("rate = C_g*(gyro - B_g - G*force)", "force = C_a*(accel - B_a - P*rate^2)")
# rad/s and m/s² within every unit's range, different on each axis.
EXAMPLE_GYRO = np.array([[0.5, -1.0, 2.0]])
EXAMPLE_ACCEL = np.array([[1.0, -2.0, 9.5]])
WIDTH = 100  # characters of a line of YAML


def as_json(correction: Correction) -> str:
    """The document itself."""
    return correction.model_dump_json(indent=1) + "\n"


def as_yaml(correction: Correction) -> str:
    """The document in YAML."""
    return dump_yaml(correction.model_dump(mode="json"))


def as_ros(correction: Correction) -> str:
    """A parameter file of ROS 2, for whatever node corrects.

    Its parameters are lists of one type, so matrices stand row by row; the wildcard gives them to
    every node. Source: docs.ros.org, migrating parameters.
    """
    flat = {name: _flat(coefficient.value) for name, coefficient in correction.coefficients.items()}
    parameters = {"imu_correction": flat | {"formulas": list(correction.correction)}}
    return heading(correction, "# ") + dump_yaml({"/**": {"ros__parameters": parameters}})


def as_csv(correction: Correction) -> str:
    """A row for each element: coefficient, axes, value, U and how that was evaluated, unit."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("coefficient", "reads", "input", "value", "U", "evaluation", "unit"))
    for name, coefficient in correction.coefficients.items():
        values = _flat(coefficient.value)
        expanded = _flat(coefficient.U) if coefficient.U else [None] * len(values)
        for n, (value, U) in enumerate(zip(values, expanded, strict=True)):
            axes = (AXES[n], "") if len(values) == len(AXES) else (AXES[n // 3], AXES[n % 3])
            shown = "" if U is None else repr(U)
            evaluation = correction.uncertainty if shown else ""
            writer.writerow((name, *axes, repr(value), shown, evaluation, coefficient.unit))
    return text.getvalue()


def heading(correction: Correction, mark: str) -> str:
    """The unit, the omissions and the formulas of a correction, as lines of comment."""
    unit = correction.unit
    lines = [
        f"unit: {unit.manufacturer} {unit.model} {unit.serial}" if unit else "unit: unknown",
        f"recording: {correction.recording_id} (run {correction.run}), method {correction.method}",
        f"U: {correction.uncertainty}",
        "model:",
        *(f"  {formula}" for formula in correction.model),
        "correction, in this order (rad/s, m/s2):",
        *(f"  {formula}" for formula in correction.correction),
    ]
    if correction.assumed_ideal:
        lines.append(f"taken as ideal, not calibrated: {', '.join(correction.assumed_ideal)}")
    if correction.left_in:
        lines.append(f"not corrected: {', '.join(correction.left_in)}")
    return "".join(f"{mark}{' '.join(line.split()) if n < 2 else line}\n"
                   for n, line in enumerate(lines))  # fmt: skip


def dump_yaml(document: Any) -> str:
    """A document as YAML, lists of numbers on one line."""
    import yaml

    return str(
        yaml.safe_dump(
            document, sort_keys=False, default_flow_style=None, allow_unicode=True, width=WIDTH
        )
    )


def _flat(values: Any) -> list[Any]:
    """The elements of a vector, or of a matrix row by row."""
    return [each for row in values for each in (row if isinstance(row, tuple) else (row,))]


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
        uncertainty=next(iter(calibration.items.values())).uncertainty_kind,
        covariance=calibration.covariance,
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


def as_c(correction: Correction) -> str:
    """A header for C99 and C++; doubles are written so that they are read back as they are."""
    comment = heading(correction, " * ").replace("*/", "* /").replace("/*", "/ *")
    constants = [
        _array(f"MIMU_{name}", coefficient.value, coefficient.unit)
        for name, coefficient in correction.coefficients.items()
    ]
    example = [
        _array(f"MIMU_EXAMPLE_{name.upper()}", value, "m/s2" if name in FORCES else "rad/s")
        for name, value in correction.example
    ]
    return "\n".join([
        f"/*\n{comment} */",
        "#ifndef MIMU_CORRECTION_H\n#define MIMU_CORRECTION_H\n",
        f"#define MIMU_PASSES {PASSES}\n",
        *constants,
        FUNCTION,
        "/* mimu_correct(MIMU_EXAMPLE_GYRO, MIMU_EXAMPLE_ACCEL, ...) gives these. */",
        *example,
        "\n#endif\n",
    ])  # fmt: skip


def _array(name: str, values: tuple[Any, ...], unit: str) -> str:
    if isinstance(values[0], tuple):
        rows = ",\n".join(f"    {_braced(row)}" for row in values)
        return f"static const double {name}[3][3] = {{ /* {unit} */\n{rows}\n}};"
    return f"static const double {name}[3] = {_braced(values)}; /* {unit} */"


def _braced(values: tuple[float, ...]) -> str:
    return f"{{{', '.join(map(repr, values))}}}"


# A correction as kalibr's imu.yaml: noise densities and its scale-misalignment model.
#
# kalibr: ω′ = M_g·C_g·ω + A·C_g·f + b, a′ = M_a·C_a·f + b with M lower triangular and C rotations
# from the body. So K = M·C of each triad, C_gyro_i = C_g·C_aᵀ and A = G·C_gᵀ. It estimates biases
# itself and knows no P. Source: kalibr's yaml formats, IMU noise model and intrinsics.

TOPIC = "/imu0"
AS_LONG = 0.9  # of the longest rest: rests as long as it is
SQRT_HOUR = 60.0  # √(3600 s)
# Key of the random walk among a calibration's information, and its factor from SI.
WALKS = {
    "gyro": ("gyro_angle_random_walk", DEG * SQRT_HOUR, GYRO),
    "accel": ("accel_velocity_random_walk", 1.0, ACCEL),
}


@dataclass(frozen=True)
class TriadNoise:
    """Of a triad's worst axis: density (unit/√Hz), and what its random walk is at most."""

    density: float
    walk: float


def as_kalibr(correction: Correction, calibration: Calibration, recording: Recording) -> str:
    """kalibr's imu.yaml; raises Unusable where the run does not show the noise that it asks for."""
    gyro, accel = (noise(calibration, recording, triad) for triad in WALKS)
    document = {
        "rostopic": TOPIC,
        "update_rate": float(1.0 / np.median(np.diff(recording.imu.t))),
        "accelerometer_noise_density": accel.density,
        "accelerometer_random_walk": accel.walk,
        "gyroscope_noise_density": gyro.density,
        "gyroscope_random_walk": gyro.walk,
        "model": "scale-misalignment",
        **_intrinsics(correction),
    }
    remarks = (
        "# the random walks are upper bounds: the run's rests show no more\n"
        "# biases (kalibr estimates them) and P stand in the other forms of this correction\n"
    )
    return heading(correction, "# ") + remarks + dump_yaml(document)


def noise(calibration: Calibration, recording: Recording, triad: str) -> TriadNoise:
    """White noise as the calibration gives it, and a bound of the random walk.

    All of the Allan variance at the longest averaging time is taken for K²·τ/3 (IEEE Std 952).
    """
    name, per_si, channels = WALKS[triad]
    shown = calibration.information.get(name)
    densities = [value for value in (shown.value if shown else {}).values() if value is not None]
    rests = [s for s in calibration.segments if s.kind == "static" and not s.rows_left_out]
    longest = max((rest.t_end - rest.t_start for rest in rests), default=0.0)
    readings = [
        recording.imu.views(channels, recording.imu.rows(rest.t_start, rest.t_end))
        for rest in rests
        if rest.t_end - rest.t_start >= AS_LONG * longest
    ]
    if not densities or not readings:
        raise Unusable(
            f"{calibration.recording_id} shows no white noise of the {triad} triad in its rests, "
            "which kalibr needs; export --as yaml or ros, or record longer rests."
        )
    interval = float(np.median(np.diff(recording.imu.t)))
    curve = allan_curve(readings, interval)
    walk = np.sqrt(3.0 * curve.variance[-1].max() / curve.tau[-1])
    return TriadNoise(max(densities) / per_si, float(walk))


def _intrinsics(correction: Correction) -> dict[str, Any]:
    gyro, accel, sensitivity = (
        np.array(correction.coefficients[name].value) for name in ("K_g", "K_a", "G")
    )
    (m_gyro, c_gyro), (m_accel, c_accel) = lower_and_rotation(gyro), lower_and_rotation(accel)
    return {
        "accelerometers": {"M": m_accel.tolist()},
        "gyroscopes": {
            "M": m_gyro.tolist(),
            "A": (sensitivity @ c_gyro.T).tolist(),
            "C_gyro_i": (c_gyro @ c_accel.T).tolist(),
        },
        "T_i_b": np.block([[c_accel, np.zeros((3, 1))], [np.zeros((1, 3)), 1.0]]).tolist(),
    }


def lower_and_rotation(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower triangular M with a positive diagonal and rotation C of matrix = M·C, each (3, 3)."""
    rotation, upper = np.linalg.qr(matrix.T)
    signs = np.sign(np.diag(upper))
    return np.tril(upper.T * signs), (rotation * signs).T
