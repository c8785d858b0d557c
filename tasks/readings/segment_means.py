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
NOT_SLOW = 0.2  # of the fastest rate: biases hide what is read of slower ones
EVERY = 0.25  # s over which gyros and poses turn as far
SLOW, FAST = 0.05, 0.5  # rad/s of a pose: it rests, and it turns by far more than biases
MOSTLY = 0.9  # of a turn that is about one axis
FEWEST_TURNS = 8  # that tell what an axis reads
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
            [_mean(values) for values in imu.views(GYRO + ACCEL, place)]
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


def _mean(values: np.ndarray) -> float:
    """Of what was read: rows without a triad say nothing."""
    mean = float(values.mean()) if len(values) else np.nan
    known = values[np.isfinite(values)] if np.isnan(mean) else values
    return float(known.mean()) if len(known) else np.nan


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


def sizes_by_rates(means: SegmentMeans) -> np.ndarray:
    """(r,) how much the gyros read of each rate that is not slow beside the fastest."""
    rest = means.gyro[means.static] if means.static.any() else means.gyro
    zero = np.nanmedian(rest, axis=0) if np.isfinite(rest).any() else np.zeros(3)
    rate = np.linalg.norm(np.nan_to_num(means.rate), axis=1)
    used = (rate > NOT_SLOW * rate.max(initial=0.0)) & np.isfinite(means.gyro).all(axis=1)
    return np.asarray(np.linalg.norm(means.gyro[used] - zero, axis=1) / rate[used])


def responses(matrix: TriadMatrix | None) -> np.ndarray:
    """(r,) how much is read of each of the inputs that vary; (0,) of none."""
    return np.zeros(0) if matrix is None else np.linalg.svd(matrix.reads, compute_uv=False)


def sizes_beside_poses(recording: Recording) -> np.ndarray:
    """(r,) how far the gyros turn over how far the poses do while each axis turns most, of those
    axes that do so for long enough: whatever the pose's own axes are, both turn as far.
    """
    poses, imu = recording.reference, recording.imu
    gyro = imu.stack(GYRO)
    if poses is None or not np.isfinite(gyro).all():
        return np.zeros(0)
    at = np.arange(max(poses.t[0], imu.t[0]), min(poses.t[-1], imu.t[-1]), EVERY)
    near = np.searchsorted(poses.t, at).clip(0, len(poses.t) - 1)
    seconds = np.diff(poses.t[near])
    q = poses.stack(("qw", "qx", "qy", "qz"), None)[near]
    cosine = np.abs((q[1:] * q[:-1]).sum(axis=1) / np.linalg.norm(q[1:], axis=1))
    turned = 2.0 * np.arccos(np.clip(cosine / np.linalg.norm(q[:-1], axis=1), 0.0, 1.0))
    path = np.vstack([np.zeros(3), np.cumsum(
        0.5 * (gyro[1:] + gyro[:-1]) * np.diff(imu.t)[:, None], axis=0
    )])  # fmt: skip
    read = np.array([np.diff(np.interp(poses.t[near], imu.t, way)) for way in path.T])
    near_by = (seconds > 0.5 * EVERY) & (seconds < 2.0 * EVERY)
    rate = turned / np.maximum(seconds, 1e-9)
    slow = near_by & (rate < SLOW)
    if slow.any():
        read = read - np.median(read[:, slow] / seconds[slow], axis=1)[:, None] * seconds
    size = np.linalg.norm(read, axis=0)
    fast = near_by & (rate > FAST)
    along = np.abs(read) > MOSTLY * size
    each = [fast & along[k] for k in range(3)]
    return np.array(
        [np.median(size[one] / turned[one]) for one in each if one.sum() > FEWEST_TURNS]
    )


def common_factor(sizes: np.ndarray) -> float | None:
    """The factor that all responses (r,) have in common; None where they differ."""
    if not len(sizes) or not sizes.min() > 0:
        return None
    common = float(np.exp(np.log(sizes).mean()))
    return common if np.abs(np.log(sizes / common)).max() < NEAR else None
