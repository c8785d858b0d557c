"""A small recording with all streams and columns that there are."""

import numpy as np

from schemas.recording import (
    ACCEL,
    GYRO,
    Manifest,
    Recording,
    Stream,
)
from tests.manifests import manifest_of


def manifest() -> Manifest:
    return manifest_of("small", axes={"outer": (0, 0, 1)})


def imu_stream(rows: int = 300, start: float = 0.0, **more: np.ndarray) -> Stream:
    t = start + np.arange(rows) / 100
    values = {name: np.sin(t + k) for k, name in enumerate(GYRO + ACCEL)}
    return Stream(t, values | more)


def recording() -> Recording:
    """All streams and columns there are, with holes where holes may be."""
    imu = imu_stream(temperature=np.linspace(20, 21, 300))
    for name in GYRO:
        imu.columns[name][50:70] = np.nan
    t = np.arange(100) / 33
    table = Stream(t, {"outer_angle": t, "outer_rate": np.cos(t)})
    pose = {
        name: np.sin(t + k) for k, name in enumerate(("qw", "qx", "qy", "qz", "px", "py", "pz"))
    }
    air = dict.fromkeys(("temperature", "humidity", "supply_voltage", "pressure"), 20.1 + t / 7)
    return Recording(manifest(), imu, table, Stream(t + 0.007, pose), Stream(t + 3, air))
