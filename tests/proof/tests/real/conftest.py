"""A shaft by plain algebra: a unit that swings to and fro beside its encoder."""

from pathlib import Path

import numpy as np
import pytest

from schemas.recording import Recording, Stream
from tests.manifests import manifest_of

GRAVITY = 9.80665
LATE = 0.008  # s


@pytest.fixture(scope="session")
def shaft() -> Recording:
    """A minute at 100 Hz: gyro and accelerometers late by LATE, noise of an MPU-6050.

    As in the real one the shaft points East, the unit's y along it.
    """
    rng = np.random.default_rng(5)
    t = np.round(np.arange(0.0, 60.0, 0.01), 9)

    def angle(at: np.ndarray) -> np.ndarray:
        return (
            1.5 - 1.5 * np.cos(2.0 * np.pi * at / 7.808) + 0.02 * np.sin(2.0 * np.pi * 2.0 * at)
            + 0.004 * np.sin(2.0 * np.pi * 4.3 * at) + 0.002 * np.sin(2.0 * np.pi * 12.8 * at)
        )  # fmt: skip

    observation = angle(t - LATE)
    rate = (angle(t - LATE + 5e-4) - angle(t - LATE - 5e-4)) / 1e-3
    columns = {
        "gyro_x": np.zeros_like(t), "gyro_y": rate, "gyro_z": np.zeros_like(t),
        "accel_x": GRAVITY * np.cos(observation), "accel_y": np.zeros_like(t),
        "accel_z": GRAVITY * np.sin(observation),
    }  # fmt: skip
    columns |= {
        name: value + rng.normal(0.0, 0.003 if name.startswith("gyro") else 0.03, len(t))
        for name, value in columns.items()
    }
    manifest = manifest_of(
        "shaft",
        {"gravity_m_s2": GRAVITY},
        {"shaft": (1, 0, 0)},
        mount={"quaternion_wxyz": [0.5, -0.5, -0.5, -0.5]},
    )
    table = Stream(t, {"shaft_angle": angle(t)})
    return Recording(manifest, Stream(t, columns), table=table)


@pytest.fixture(scope="session")
def shared_real(shared: Path) -> Path:
    """The folder of the real recordings."""
    return shared / "real"
