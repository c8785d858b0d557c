"""What is read in each segment beside what the unit went through there."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.recording import ACCEL, AXES, GYRO, Recording, Segment
from tasks.motion.table import mean_rate, mount_of, table_vectors
from tasks.motion.whole import unit_vector
from tasks.readings.axes import TriadMatrix, matrix_of

NEAR = 0.08  # of a usual factor: as near as working units are
DEG = np.pi / 180.0
SPARE = 2  # segments more than a matrix of rates needs: what they leave shows whether it fits
FEW = 2  # segments that tell a unit
VARIED = 0.1  # standard deviation of a component of up that shows how it is read
WHOLE = 0.5  # of a direction: labels that gravity contradicts are read as less, for they cancel


@dataclass(frozen=True)
class SegmentMeans:
    """Of k segments: means of gyros and accelerometers (k, 3), rates and directions of up (k, 3)
    by encoders or else labels; NaN where not known. static: (k,) bool.
    """

    gyro: np.ndarray
    accel: np.ndarray
    rate: np.ndarray
    up: np.ndarray
    static: np.ndarray


def segment_means(
    recording: Recording, segments: Sequence[Segment], read: np.ndarray | None = None
) -> SegmentMeans:
    """Means and inputs of segments; read: (k, 6), where their means are known."""
    if read is None:
        imu = recording.imu
        rows = [imu.rows(s.t_start, s.t_end) for s in segments]
        read = np.array([
            [values.mean() if len(values) else np.nan for values in imu.views(GYRO + ACCEL, place)]
            for place in rows
        ]).reshape(-1, 6)  # fmt: skip
    static = np.array([s.kind == "static" for s in segments], bool)
    rates = np.zeros((len(segments), 3))
    for k in np.flatnonzero(~static).tolist():
        by_table = mean_rate(recording, segments[k])
        rates[k] = _labelled_rate(segments[k]) if by_table is None else by_table
    ups = np.full((len(segments), 3), np.nan)
    ups[static] = _ups(recording, [s for s in segments if s.kind == "static"])
    return SegmentMeans(read[:, :3], read[:, 3:], rates, ups, static)


def _labelled_rate(segment: Segment) -> np.ndarray:
    """(3,) rad/s; NaN where the label does not tell it."""
    degrees = segment.rate_deg_s
    if segment.kind == "rotation":
        degrees = (segment.angle_deg or 0.0) / max(segment.t_end - segment.t_start, 1e-9)
    if segment.axis is None or degrees is None:
        return np.full(3, np.nan)
    return np.eye(3)[AXES.index(segment.axis)] * degrees * DEG


def _ups(recording: Recording, rests: Sequence[Segment]) -> np.ndarray:
    """(k, 3) by the encoders at the middle of each rest, else by its label."""
    axes, table = recording.manifest.station.table_axes, recording.table
    if not axes or table is None:
        return np.array([unit_vector(rest.up) for rest in rests]).reshape(-1, 3)
    middle = np.array([0.5 * (rest.t_start + rest.t_end) for rest in rests])
    angles = [np.interp(middle, table.t, table.columns[f"{axis.name}_angle"]) for axis in axes]
    up = table_vectors(recording.manifest.station, np.array(angles).T)[0]
    up[(middle < table.t[0]) | (middle > table.t[-1])] = np.nan
    return np.array([
        one @ mount_of(recording.manifest, rest) for one, rest in zip(up, rests, strict=True)
    ]).reshape(-1, 3)  # fmt: skip


def directions_of(accel: np.ndarray) -> np.ndarray:
    """Unit vectors (k, 3) along what the accelerometers read."""
    size = np.linalg.norm(accel, axis=1)[:, None]
    return np.where(size > 0, accel / np.where(size > 0, size, 1.0), np.nan)


def matrix_by_segments(
    read: np.ndarray, felt: np.ndarray, excited: float, *, forces: bool
) -> TriadMatrix | None:
    both = np.isfinite(read).all(axis=1) & np.isfinite(felt).all(axis=1)
    if both.sum() < FEW:
        return None
    found = matrix_of(read[both], felt[both], excited, forces=forces)
    if found is not None and not forces and both.sum() < found.reads.shape[1] + SPARE:
        return None
    return found


def matrix_of_directions(read: np.ndarray, up: np.ndarray) -> TriadMatrix | None:
    """The matrix by unit vectors (k, 3) that are read and are up.

    None where a direction is not read as one: some of the labels are wrong, and not all axes.
    """
    found = matrix_by_segments(read, up, VARIED, forces=True)
    if found is None or np.linalg.norm(found.reads, axis=0).min() < WHOLE:
        return None
    return found


def common_factor(matrix: TriadMatrix) -> float | None:
    """The factor that all responses have in common; None where they differ."""
    sizes = np.linalg.svd(matrix.reads, compute_uv=False)
    if not sizes.min() > 0:
        return None
    common = float(np.exp(np.log(sizes).mean()))
    return common if np.abs(np.log(sizes / common)).max() < NEAR else None
