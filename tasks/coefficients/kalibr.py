"""A correction as kalibr's imu.yaml: noise densities and its scale-misalignment model.

kalibr: ω′ = M_g·C_g·ω + A·C_g·f + b, a′ = M_a·C_a·f + b with M lower triangular and C rotations
from the body. So K = M·C of each triad, C_gyro_i = C_g·C_aᵀ and A = G·C_gᵀ. It estimates biases
itself and knows no P. Source: kalibr's yaml formats, IMU noise model and intrinsics.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.correction import Correction
from schemas.recording import ACCEL, GYRO, Recording
from tasks.calibrate.information.allan import allan_curve
from tasks.coefficients.tables import dump_yaml, heading
from tasks.model.parameters import DEG

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
