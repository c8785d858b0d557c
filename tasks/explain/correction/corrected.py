"""A recording corrected for the contribution of findings to its readings."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.recording import Recording, Stream
from tasks.explain.channels import CHANNELS


def corrected(recording: Recording, contributions: Sequence[np.ndarray]) -> Recording:
    """The recording less what each contribution (n, 6), rad/s and m/s², added to its readings.

    Rows where a contribution is not known stay as they were read.
    """
    added = np.zeros((len(recording.imu), len(CHANNELS)))
    for contribution in contributions:
        added += np.nan_to_num(contribution, nan=0.0)
    columns = dict(recording.imu.columns)
    for channel, name in enumerate(CHANNELS):
        if name in columns and added[:, channel].any():
            columns[name] = columns[name] - added[:, channel]
    return replace(recording, imu=Stream(recording.imu.t, columns))
