"""Rows of a logger that hold no readings: zero in every channel, or what no unit reads.

Three gyros at rest may read zero; with accelerometers, which feel gravity, a row of zeros is none.
"""

from dataclasses import replace

import numpy as np

from schemas.recording import Recording
from tasks.explain.channels import CHANNELS
from tasks.model.parameters import ACCEL_FIRST
from tasks.words import Message, message

GYRO_LIMIT, ACCEL_LIMIT = 200.0, 5000.0  # rad/s, m/s²: units that read more are read so throughout
USUAL, BEYOND = 0.9, 30.0  # quantile of a channel's readings, and times it that one may be
MAX_SHARE = 0.1  # of the rows: more are no accident


def without_empty_rows(recording: Recording) -> tuple[Recording, tuple[Message, ...]]:
    """The recording with NaN in its empty rows, and a remark on them."""
    empty = empty_rows(recording.imu.stack(CHANNELS))
    if not empty.any():
        return recording, ()
    own = {name: recording.imu.columns[name] for name in CHANNELS if name in recording.imu.columns}
    torn = {name: np.where(empty, np.nan, signal) for name, signal in own.items()}
    imu = replace(recording.imu, columns={**recording.imu.columns, **torn})
    return replace(recording, imu=imu), (message("events-empty-rows", count=int(empty.sum())),)


def empty_rows(readings: np.ndarray) -> np.ndarray:
    """Which rows (n,) bool of readings (n, 6), rad/s and m/s², hold none."""
    size = np.abs(readings)
    recorded = np.isfinite(size).any(axis=0)
    if not recorded.any():
        return np.zeros(len(size), bool)
    known = np.where(np.isfinite(size), size, 0.0)
    limits = np.repeat([GYRO_LIMIT, ACCEL_LIMIT], ACCEL_FIRST)
    limits = np.maximum(limits, BEYOND * np.quantile(known, USUAL, axis=0))
    empty = (known > limits).any(axis=1)
    if recorded[ACCEL_FIRST:].any():
        empty |= (size[:, recorded] == 0.0).all(axis=1)
    return empty if empty.mean() <= MAX_SHARE else np.zeros(len(size), bool)
