"""A bench's run as a recording, with its table, its labels, both or neither."""

import numpy as np

from schemas.recording import ACCEL, GYRO, Manifest, Recording, Stream

from .bench import Bench

AXES = ("outer", "middle", "inner")


def recorded(made: Bench, *, table: bool = False, labels: bool = True) -> Recording:
    columns = dict(zip(GYRO + ACCEL, np.hstack([made.gyro, made.accel]).T, strict=True))
    angles = {f"{name}_angle": angle for name, angle in zip(AXES, made.angle.T, strict=True)}
    return Recording(
        Manifest.model_validate(made.manifest(table=table, labels=labels)),
        Stream(made.t, columns),
        Stream(made.t, angles) if table else None,
    )
