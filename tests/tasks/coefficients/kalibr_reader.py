"""An imu.yaml held against what kalibr's reader and its inertial models do with it.

Source: ethz-asl/kalibr, kalibr_common/ConfigReader.py (ParametersBase, ImuParameters) and
kalibr_imu_camera_calibration/IccSensors.py (IccScaledMisalignedImu).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml

STATISTICS = (
    "accelerometer_noise_density", "accelerometer_random_walk",
    "gyroscope_noise_density", "gyroscope_random_walk",
)  # fmt: skip


class KalibrRefusesError(Exception):
    """kalibr ends with this sentence."""


@dataclass(frozen=True)
class KalibrImu:
    """What kalibr takes out of a file; matrices (3, 3), discrete noise at the update rate."""

    discrete_noise: dict[str, float]
    m_gyro: np.ndarray
    a_gyro: np.ndarray
    c_gyro_i: np.ndarray
    m_accel: np.ndarray
    c_i_b: np.ndarray

    def reads(self, rate: np.ndarray, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Readings (3,) of both triads by the scale-misalignment model, without biases."""
        c_gyro_b = self.c_gyro_i @ self.c_i_b
        gyro = self.m_gyro @ (c_gyro_b @ rate) + self.a_gyro @ (c_gyro_b @ force)
        return gyro, self.m_accel @ (self.c_i_b @ force)


def read(text: str) -> KalibrImu:
    """As kalibr reads it; raises KalibrRefusesError where it would end."""
    data = yaml.safe_load(text)
    try:
        if not isinstance(data["rostopic"], str):
            raise KalibrRefusesError("rostopic has to be a string")
        rate = _positive(data, "update_rate")
        values = {name: _positive(data, name) for name in STATISTICS}
        noise = {triad: values[f"{triad}_noise_density"] / np.sqrt(1.0 / rate)
                 for triad in ("accelerometer", "gyroscope")}  # fmt: skip
        if data["model"] != "scale-misalignment":
            raise KalibrRefusesError(f"another model: {data['model']}")
        gyros, accels = data["gyroscopes"], data["accelerometers"]
        c_i_b = _rigid(data["T_i_b"])
        return KalibrImu(
            noise, _lower(gyros["M"]), _matrix(gyros["A"], 3), _rotation(gyros["C_gyro_i"]),
            _lower(accels["M"]), c_i_b,
        )  # fmt: skip
    except KeyError as missing:
        raise KalibrRefusesError(f"Field {missing} missing in file") from None


def _positive(data: dict[str, Any], name: str) -> float:
    """A field that is compared with 0.0 and divided by: text, as YAML 1.1 reads 1e-5, is none."""
    value = data[name]
    if not isinstance(value, float):
        raise KalibrRefusesError(f"{name} is no float: {value!r}")
    if value <= 0.0:
        raise KalibrRefusesError(f"invalid {name}")
    return value


def _matrix(values: Any, size: int) -> np.ndarray:
    matrix = np.array(values)
    if matrix.shape != (size, size) or matrix.dtype != float:
        raise KalibrRefusesError(f"no {size} by {size} matrix of floats")
    return matrix


def _lower(values: Any) -> np.ndarray:
    """The elements above the diagonal are no design variables: they must be zero."""
    matrix = _matrix(values, 3)
    if np.triu(matrix, 1).any():
        raise KalibrRefusesError("M is not lower triangular")
    return matrix


def _rotation(values: Any) -> np.ndarray:
    """A rotation, because kalibr makes a quaternion of it."""
    matrix = _matrix(values, 3)
    if not np.allclose(matrix @ matrix.T, np.eye(3)) or np.linalg.det(matrix) < 0.0:
        raise KalibrRefusesError("no rotation")
    return matrix


def _rigid(values: Any) -> np.ndarray:
    """The rotation of sm.Transformation(4 × 4)."""
    matrix = _matrix(values, 4)
    if matrix[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise KalibrRefusesError("no transformation")
    return _rotation(matrix[:3, :3].tolist())
