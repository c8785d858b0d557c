"""The readings predicted by another simulator, and whether they are of this run."""

from pathlib import Path

import numpy as np

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.motion.whole import whole_motion
from tasks.words import Message, message

# longest gap in another simulator's rows that is interpolated, in sample intervals of the unit
MAX_STEPS = 1.5
MIN_SHARE_OF_ROWS = 0.5  # of the unit's rows that a simulation must have
# of a table axis: a larger difference is another position, not a difference in timing
MAX_ANGLE_DIFFERENCE = np.radians(10.0)
MAX_SHARE_DIFFERENT = 0.1  # of the rows of the table
MIN_ROTATION = np.radians(1.0)  # rad/s rms: too little motion to distinguish one from another
MAX_RATE_DIFFERENCE = 0.5  # of the rms rate of the motion, by the rate that is simulated
NO_SERIAL = ("", "-")


def simulated_readings(recording: Recording, path: Path, other: Recording) -> np.ndarray:
    """What a simulation, read from a path, says of a recording: (n, 6) rad/s and m/s² at the
    unit's rows.

    Interpolated linearly where its rows are not the unit's; NaN where it says nothing. Raises
    Unusable for a simulation of another stretch of time or another motion, or without gyro and
    accelerometer.
    """
    t = recording.imu.t
    readings = np.full((len(t), len(GYRO + ACCEL)), np.nan)
    between = _within(other.imu.t, t)
    for channel, name in enumerate(GYRO + ACCEL):
        if name in other.imu.columns:
            values = np.interp(t, other.imu.t, other.imu.columns[name])
            readings[between, channel] = values[between]
    simulated = np.isfinite(readings).any(axis=1)
    if simulated.mean() < MIN_SHARE_OF_ROWS:
        percent = f"{100.0 * simulated.mean():.0f} %"
        raise Unusable(
            f"{path}: it says what the unit reads in {percent} of the rows of "
            f"{recording.manifest.recording_id} only, whose {len(t)} rows go from {t[0]:g} s to "
            f"{t[-1]:g} s; give gyro_* and accel_* at the times of the unit's own stream."
        )
    fault = _other_angles(recording, other) or _other_rates(recording, readings)
    if fault:
        raise Unusable(f"{path}: {fault}; give the simulation of this same run.")
    return readings


def other_unit(recording: Recording, other: Recording) -> tuple[Message, ...]:
    """A remark where a simulation names another unit; it need not name any."""
    own, its = recording.manifest.unit.serial, other.manifest.unit.serial
    if own == its or {own, its} & set(NO_SERIAL):
        return ()
    return (message("explain-simulation-of-other-unit", own=own, its=its),)


def _within(known: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(n,) bool: which times t fall on a known one or between two that are near each other."""
    longest = MAX_STEPS * float(np.median(np.diff(t))) if len(t) > 1 else np.inf
    after = np.clip(np.searchsorted(known, t), 0, len(known) - 1)
    before = np.clip(after - 1, 0, None)
    inside = (t > known[before]) & (t < known[after])
    return (known[after] == t) | (inside & (known[after] - known[before] <= longest))


def _other_angles(recording: Recording, other: Recording) -> str:
    """What the table's angles say against it; empty: nothing, or one of the two has none."""
    if recording.table is None or other.table is None:
        return ""
    for name in recording.table.columns:
        if name.endswith("_angle") and name in other.table.columns:
            fault = _other_angle(recording, other.table, name)
            if fault:
                return fault
    return ""


def _other_angle(recording: Recording, table: Stream, name: str) -> str:
    own = recording.table
    assert own is not None
    inside = (own.t >= table.t[0]) & (own.t <= table.t[-1])
    t, at = own.t[inside], own.columns[name][inside]
    turned = np.exp(1j * table.columns[name])  # whole turns do not count
    theirs = np.interp(t, table.t, turned.real) + 1j * np.interp(t, table.t, turned.imag)
    apart = np.abs(np.angle(np.exp(1j * at) * theirs.conj()))
    if not len(t) or np.mean(apart > MAX_ANGLE_DIFFERENCE) <= MAX_SHARE_DIFFERENT:
        return ""
    worst = int(np.argmax(apart))
    return (
        f"its table holds {name} at {np.degrees(np.angle(theirs[worst])):.1f}° at t = "
        f"{t[worst]:g} s, where that of {recording.manifest.recording_id} is at "
        f"{np.degrees(np.angle(np.exp(1j * at[worst]))):.1f}°, and differs by more than "
        f"{np.degrees(MAX_ANGLE_DIFFERENCE):.0f}° in "
        f"{100.0 * np.mean(apart > MAX_ANGLE_DIFFERENCE):.0f} % of the rows"
    )


def _other_rates(recording: Recording, readings: np.ndarray) -> str:
    """What the size of the rate says against it, which does not depend on how the unit sits."""
    moved = np.linalg.norm(whole_motion(recording).rate, axis=1)
    read = np.linalg.norm(readings[:, : len(GYRO)], axis=1)
    known = np.isfinite(moved) & np.isfinite(read)
    if not known.any():
        return ""
    missed, turned = np.where(known, np.abs(read - moved), 0.0), moved[known]
    rms, size = np.sqrt(np.mean(missed[known] ** 2)), np.sqrt(np.mean(turned**2))
    if max(rms, size) <= MIN_ROTATION or rms <= MAX_RATE_DIFFERENCE * size:
        return ""
    worst = int(np.argmax(missed))
    return (
        f"its gyro_* reads a rate of {np.degrees(read[worst]):.3g} °/s at t = "
        f"{recording.imu.t[worst]:g} s, where {recording.manifest.recording_id} turns at "
        f"{np.degrees(moved[worst]):.3g} °/s, and differs by {np.degrees(rms):.3g} °/s rms from "
        "its motion"
    )
