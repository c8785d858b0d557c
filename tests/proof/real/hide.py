"""Known transformations that are concealed in a real recording: pure functions with a size.

Each does to the data what the physics would have done to it, without a word in the manifest.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.recording import ACCEL, Recording, Stream

SPREAD = 0.2  # share by which a drawn size differs at most from its grade
MIDDLE = (0.3, 0.7)  # where in the recording samples are lost


@dataclass(frozen=True)
class Size:
    """How much is hidden, in `unit`. at: s, when (lost samples only)."""

    value: float
    unit: str
    at: float = 0.0


Hide = Callable[[Recording, Size], Recording]


def shifted_clock(recording: Recording, size: Size) -> Recording:
    """The unit's stamps are late by size.value s; labels and table keep their own clock."""
    return replace(recording, imu=replace(recording.imu, t=_whole(recording.imu.t + size.value)))


def scaled_table(recording: Recording, size: Size) -> Recording:
    """Every angle and rate that the table tells is (1 + size.value) of what it turned.

    Encoder columns, or the labels of the segments where there is no encoder.
    """
    factor = 1.0 + size.value
    manifest, table = recording.manifest, recording.table
    if table is not None:
        table = replace(table, columns={k: v * factor for k, v in table.columns.items()})
        return replace(recording, table=table)
    segments = tuple(
        each.model_copy(
            update={
                name: factor * declared
                for name in ("rate_deg_s", "angle_deg")
                if (declared := getattr(each, name)) is not None
            }
        )
        for each in manifest.segments or ()
    )
    return replace(recording, manifest=manifest.model_copy(update={"segments": segments}))


def tilted_base(recording: Recording, size: Size) -> Recording:
    """The base leans by size.value rad about North: what the accelerometers would have read.

    The unit is carried by table axes as in `mimu-recording/1`, so that gravity leans by
    R_bᵀ·(up′ − up)·g in the body; scale and cross coupling of the unit are left aside.
    Raises ValueError without table angles: nothing tells then where the lean lies in the body.
    """
    axes, table, imu = recording.manifest.station.table_axes, recording.table, recording.imu
    if table is None or not axes:
        raise ValueError("a tilt needs table angles")
    attitude = Rotation.identity(len(imu))
    for axis in axes:
        direction = np.array(axis.direction) / np.linalg.norm(axis.direction)
        angle = np.interp(imu.t, table.t, table.columns[f"{axis.name}_angle"])
        attitude = attitude * Rotation.from_rotvec(angle[:, None] * direction)
    mount = recording.manifest.mount.quaternion_wxyz
    attitude = attitude * Rotation.from_quat(mount, scalar_first=True)
    lean = Rotation.from_rotvec([0.0, size.value, 0.0]).inv().apply([0.0, 0.0, 1.0])
    gravity = recording.manifest.station.gravity_m_s2 or 9.80665
    more = gravity * attitude.inv().apply(lean - np.array([0.0, 0.0, 1.0]))
    columns = dict(imu.columns) | {
        name: imu.columns[name] + more[:, i] for i, name in enumerate(ACCEL)
    }
    return replace(recording, imu=replace(imu, columns=columns))


def lost_samples(recording: Recording, size: Size) -> Recording:
    """size.value samples from size.at on are gone, and later stamps close the gap: they slip."""
    imu, count = recording.imu, round(size.value)
    if not count:
        return recording
    first = int(np.searchsorted(imu.t, size.at))
    slip = imu.t[first + count] - imu.t[first]
    kept = np.r_[0:first, first + count : len(imu)]
    t = imu.t[kept].copy()
    t[first:] -= slip
    return replace(recording, imu=Stream(_whole(t), {k: v[kept] for k, v in imu.columns.items()}))


def first_part(recording: Recording, seconds: float) -> Recording:
    """The beginning of a recording without labels, to be quick."""
    return replace(
        recording,
        imu=_until(recording.imu, seconds),
        table=recording.table and _until(recording.table, seconds),
    )


TRANSFORMATIONS: Mapping[str, Hide] = {
    "time_offset": shifted_clock,
    "table_scale": scaled_table,
    "axis_tilt": tilted_base,
    "dropped_samples": lost_samples,
}
GRADES: Mapping[str, tuple[float, ...]] = {
    "time_offset": (0.0, 0.003, 0.010, 0.030),  # s
    "table_scale": (0.0, 0.005, 0.010, 0.020),  # 1
    "axis_tilt": (0.0, 0.002, 0.005, 0.015),  # rad
    "dropped_samples": (0.0, 3.0, 8.0, 20.0),  # samples
}
UNITS = {"time_offset": "s", "table_scale": "1", "axis_tilt": "rad", "dropped_samples": "1"}


def drawn_sizes(seed: int, name: str, duration: float) -> tuple[Size, ...]:
    """A size near each grade of a transformation, drawn from the seed; the first is zero."""
    rng = np.random.default_rng([seed, list(TRANSFORMATIONS).index(name)])
    sizes = []
    for grade in GRADES[name]:
        value = grade * (1.0 + rng.uniform(-SPREAD, SPREAD))
        at = round(float(duration * rng.uniform(*MIDDLE)), 2)
        lost = name == "dropped_samples"
        sizes.append(Size(float(round(value)) if lost else value, UNITS[name], at if lost else 0.0))
    return tuple(sizes)


def _until(stream: Stream, seconds: float) -> Stream:
    rows = slice(0, int(np.searchsorted(stream.t, seconds)))
    return Stream(stream.t[rows], {k: v[rows] for k, v in stream.columns.items()})


def _whole(t: np.ndarray) -> np.ndarray:
    """Times in whole nanoseconds."""
    return np.asarray(np.round(t, 9))
