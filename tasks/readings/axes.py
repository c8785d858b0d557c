"""The matrix by which a triad reads its inputs, and the signed permutation that it is near.

A working unit reads each axis along itself, to within a few degrees: a matrix that does so only
after some axes are exchanged or inverted tells which.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from schemas.recording import ACCEL, AXES, GYRO, Recording, Segment
from tasks.motion.samples import in_blocks
from tasks.motion.table import mean_rate, mount_of, table_vectors
from tasks.motion.whole import Motion, unit_vector

TRIADS = ((0, 1, 2), (3, 4, 5))
WINDOW = 0.25  # s of a mean
EXCITED = (0.05, 0.5)  # rad/s, m/s²: standard deviation of an input that shows how it is read
SLOW_RATE = 0.5  # rad/s below which an accelerometer off the axis feels next to nothing of a turn
MIN_WINDOWS = 20
MAX_LEFT = 0.25  # of what is read: root of the share of its power that the matrix leaves
WORKING_ANGLE = np.radians(20.0)  # from the axis it should be on: a working unit, roughly fixed
ASTRAY = np.radians(60.0)  # from there: another axis, or the other way round
MATRICES = tuple(
    np.eye(3)[list(order)] * np.array(signs)[:, None]
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
)


@dataclass(frozen=True)
class TriadMatrix:
    """directions: (3, r) orthonormal inputs that vary; reads: (3, r) what is read of each."""

    directions: np.ndarray
    reads: np.ndarray


def triad_matrix(readings: np.ndarray, motion: Motion, triad: int) -> TriadMatrix | None:
    """The matrix of a triad, 0 or 1, from readings (n, 6) rad/s, m/s²; None if it does not fit.

    A single attitude shows the response of the accelerometers to gravity except for their bias.
    """
    means = _means(readings[:, list(TRIADS[triad])], motion, triad)
    if means is None:
        return None
    read, felt = means
    return matrix_of(read, felt, EXCITED[triad], forces=triad == 1)


def matrix_of(
    read: np.ndarray, felt: np.ndarray, excited: float, *, forces: bool
) -> TriadMatrix | None:
    """The matrix by means of readings and inputs (m, 3); None where it leaves much of them.

    excited: standard deviation of an input that shows how it is read. forces: whether a single
    input shows the response, too.
    """
    centre, middle = read.mean(axis=0), felt.mean(axis=0)
    sizes, axes = np.linalg.eigh(np.cov((felt - middle).T))
    directions = axes[:, sizes > excited**2]
    if not directions.size:
        if not forces:
            return None
        size = float(np.linalg.norm(middle))
        return TriadMatrix(middle[:, None] / size, centre[:, None] / size)
    along = (felt - middle) @ directions
    reads = np.linalg.lstsq(along, read - centre, rcond=None)[0].T
    left = read - centre - along @ reads.T
    if np.sum(left**2) > MAX_LEFT**2 * np.sum((read - centre) ** 2):
        return None
    return TriadMatrix(directions, reads)


def _means(
    readings: np.ndarray, motion: Motion, triad: int
) -> tuple[np.ndarray, np.ndarray] | None:
    """Readings and inputs (m, 3) over whole windows in which both are known."""
    rows = max(1, round(WINDOW / max(motion.interval, 1e-9)))
    inputs = (motion.rate, motion.force)[triad]
    both = np.hstack([readings, inputs])
    if triad == 1:  # while it turns fast, only where nothing else was recorded
        slow = np.linalg.norm(motion.rate, axis=1) < SLOW_RATE
        still = np.where(slow[:, None], both, np.nan)
        if np.isfinite(in_blocks(still, rows)).all(axis=(1, 2)).sum() >= MIN_WINDOWS:
            both = still
    blocks = in_blocks(both, rows)
    blocks = blocks[np.isfinite(blocks).all(axis=(1, 2))]
    if len(blocks) < MIN_WINDOWS:
        return None
    means = blocks.mean(axis=1)
    return means[:, :3], means[:, 3:]


def fitting(found: TriadMatrix) -> list[np.ndarray]:
    """The signed permutations with which a triad reads along its axes, fewest changes first."""
    if _astray(found, np.eye(3)) < ASTRAY:
        return [np.eye(3)]
    good = [matrix for matrix in MATRICES if _astray(found, matrix) < WORKING_ANGLE]
    return sorted(good, key=_changes)


def _astray(found: TriadMatrix, matrix: np.ndarray) -> float:
    """The largest angle between the response to an input and that of a permutation."""
    expected = matrix @ found.directions
    size = np.linalg.norm(found.reads, axis=0)
    cosine = np.sum(expected * found.reads, axis=0) / np.where(size > 0, size, 1.0)
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)).max())


def _changes(matrix: np.ndarray) -> tuple[int, int]:
    """How many axes are not read as they should be, and how many of them are inverted."""
    return int(3 - np.sum(np.diag(matrix) == 1.0)), int(np.sum(matrix < 0))


# What is read in each segment beside what the unit went through there.

NEAR_FACTOR = 0.08  # of a usual factor: as near as working units are
DEG = np.pi / 180.0
SPARE = 2  # segments more than a matrix of rates needs: what they leave shows whether it fits
FEWEST_SEGMENTS = 2  # segments that tell a unit
VARIED = 0.1  # standard deviation of a component of up that shows how it is read
NOT_SLOW = 0.2  # of the fastest rate: biases hide what is read of slower ones
EVERY = 0.25  # s over which gyros and poses turn as far
POSE_AT_REST, FAST = 0.05, 0.5  # rad/s of a pose: it rests, and it turns by far more than biases
MOSTLY = 0.9  # of a turn that is about one axis
FEWEST_TURNS = 8  # that tell what an axis reads
LEAST_DIRECTION = 0.5  # labels that gravity contradicts are read as less, for they cancel


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
    if both.sum() < FEWEST_SEGMENTS:
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
    if found is None or np.linalg.norm(found.reads, axis=0).min() < LEAST_DIRECTION:
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
    slow = near_by & (rate < POSE_AT_REST)
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
    return common if np.abs(np.log(sizes / common)).max() < NEAR_FACTOR else None


# Steady turns that the gyros alone show, for recordings that nobody labelled.

BLOCK = 0.2  # s of a mean
SHORTEST = 1.5  # s
SLOWEST = np.radians(3.0)  # rad/s from rest
STEADY = 0.01  # of the rate, by which neighbouring means of a held rate differ at the most
ALIGNED_TURN = np.cos(np.radians(10.0))  # about one axis of the unit
MARGIN = 0.3  # s left off at both ends
NOMINAL = 0.03  # of a rate, by which the gyro may read another than was set


def steady_turns(recording: Recording, rests: tuple[Segment, ...]) -> tuple[Segment, ...]:
    """Turns at a held rate about one axis, in the order of time.

    The rate is the roundest number near to what the gyro reads: a proposal, for the gyro is
    not its own reference. rests: where it rests.
    """
    imu = recording.imu
    rows = max(1, round(BLOCK / max(float(np.median(np.diff(imu.t))), 1e-9)))
    means = in_blocks(np.column_stack([imu.t, imu.stack(GYRO)]), rows).mean(axis=1)
    t, rate = means[:, 0], means[:, 1:]
    at_rest = np.zeros(len(t), bool)
    for rest in rests:
        at_rest |= (t >= rest.t_start) & (t < rest.t_end)
    if not at_rest.any() or not np.isfinite(rate).all():
        return ()
    rate = rate - np.median(rate[at_rest], axis=0)
    speed = np.linalg.norm(rate, axis=1)
    change = np.linalg.norm(np.diff(rate, axis=0), axis=1)
    held = (speed[1:] > SLOWEST) & (change < STEADY * speed[1:] + 0.1 * SLOWEST)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], held.astype(int), [0]])))
    turns: list[Segment] = []
    for first, last in edges.reshape(-1, 2):
        start, end = float(t[first]) + MARGIN, float(t[last]) - MARGIN
        mean = rate[first : last + 1].mean(axis=0)
        axis = int(np.abs(mean).argmax())
        if end - start < SHORTEST or abs(mean[axis]) < ALIGNED_TURN * np.linalg.norm(mean):
            continue
        read = float(np.degrees(mean[axis]))
        rounded = (float(f"{read:.1g}"), float(f"{read:.2g}"), round(read, 3))
        nominal = next(one for one in rounded if abs(read - one) < NOMINAL * abs(read))
        name = f"turn_{len(turns) + 1:03d}"
        turns.append(Segment(name=name, kind="rate", axis=AXES[axis], rate_deg_s=nominal,
                             t_start=start, t_end=end))  # fmt: skip
    return tuple(turns)
