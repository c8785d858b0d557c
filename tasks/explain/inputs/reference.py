"""A prediction from another source, instead of the standard's model fitted to the recording.

Only what the prediction and an ideal unit differ by is taken off the readings. So the standard's
own parameters, fitted to what is left, are those of an ideal unit where the prediction has them
right, and the search for missing physics is the same.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.fft import rfft, rfftfreq

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.model.model import predict
from tasks.model.term import DEG, nominal_values
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.pose import (
    HIGHEST,
    LOWEST,
    MARGIN,
    PER_OCTAVE,
    POSE,
    SHARED,
    WINDOW,
    Course,
    Stretch,
    Tracking,
    frames_of,
    noise_variance,
    seen_by_gyros,
)
from tasks.motion.samples import interpolated
from tasks.motion.whole import Motion
from tasks.words import Sayable, message


@dataclass(frozen=True)
class ReferencePrediction:
    """readings: (n, 6) rad/s and m/s² at the unit's rows, NaN where nothing is predicted.

    model: whose prediction it is, for the report.
    """

    readings: np.ndarray
    model: Sayable

    def beyond_ideal(self, motion: Motion) -> np.ndarray:
        """(n, 6) what is predicted less what an ideal unit would read."""
        return self.readings - predict(STANDARD_TERMS, motion, nominal_values(STANDARD_TERMS))


# Up to which frequency a unit sees the body turn and move that it is fixed to, and its motion.
#
# The spectrum of the positions alone does not tell where their noise begins: a hand that moves
# slowly and trembles has a dip between. What gyros and accelerometers see as well is motion.

LEVERS = np.eye(3)  # m, along each axis
HALF = 0.45  # of a sampling frequency: what lies above is not told by samples


def with_seen_places(recording: Recording, motion: Motion) -> Motion:
    """The motion of poses smoothed less, where the accelerometers see more of it than is left."""
    tracking, pose = motion.tracking, recording.reference
    if tracking is None or tracking.place is None or pose is None or recording.imu.span:
        return motion
    wider = _wider(tracking, pose, recording.imu)
    if wider is tracking:
        return motion
    return smoothed_motion(motion, pose, motion.t, wider)


def smoothed_motion(
    motion: Motion, pose: Stream, at: np.ndarray, tracking: Tracking, *, twice: bool = False
) -> Motion:
    """The motion at times `at` (n,) s by poses with positions, smoothed as `tracking` has it.

    twice: of poses that were already smoothed so.
    """
    course = Course.of(frames_of(pose), tracking)
    course = course.smoothed_again() if twice else course
    courses, margin = np.full((5, len(at), 3), np.nan), MARGIN / tracking.edge
    for stretch in course.parts:
        rows = (at >= stretch.t[0] + margin) & (at <= stretch.t[-1] - margin)
        if rows.any():
            courses[:, rows] = stretch.at(at[rows])
    up, north, rate, acceleration, translation = courses
    return replace(
        motion, up=up, north=north, rate=rate, acceleration=acceleration,
        translation=translation, tracking=tracking,
    )  # fmt: skip


@lru_cache(maxsize=4)  # a recording's motion is asked for again and again
def _wider(tracking: Tracking, pose: Stream, imu: Stream) -> Tracking:
    """The same, with attitude and place up to where the unit sees them if that is further."""
    if tracking.place is None or not set(GYRO + ACCEL) <= set(imu.columns):
        return tracking
    frames = frames_of(pose)
    known = np.isfinite(imu.stack(GYRO + ACCEL)).all(axis=1)
    t, read = imu.t[known], imu.stack(GYRO + ACCEL)[known]
    # Of a stretch that goes on before or after the readings, the part that they accompany.
    spans = [each for one in frames.spans if (each := _within(one, t)) is not None]
    if not spans:
        return tracking
    top, interval = HALF / float(np.median(np.diff(t))), frames.interval
    reads = [interpolated(each.t, t, read) for each in spans]
    turned = [each.turned for each in spans]
    attitude = min(seen_by_gyros(turned, [each[:, :3] for each in reads], interval), top)
    place = _seen_edge(spans, reads, interval, min(HIGHEST, HALF / interval, top))
    if attitude > tracking.attitude:
        courses = [each.turned for each in frames.spans]
        variance = noise_variance(courses, interval, attitude)
        tracking = replace(tracking, attitude=attitude, attitude_variance=variance)
    if tracking.place is not None and place > tracking.place:
        courses = [each.place for each in frames.spans]
        variance = noise_variance(courses, interval, place)
        tracking = replace(tracking, place=place, place_variance=variance)
    return tracking


def _within(span: Stretch, t: np.ndarray) -> Stretch | None:
    if len(t) < 2 or not (inside := (span.t >= t[0]) & (span.t <= t[-1])).any():
        return None
    rows = slice(*(np.flatnonzero(inside)[[0, -1]] + (0, 1)).tolist())
    return Stretch(span.t[rows], span.attitude[rows], span.turned[rows], span.place[rows])


def _seen_edge(
    spans: Sequence[Stretch], reads: Sequence[np.ndarray], interval: float, top: float
) -> float:
    """Hz up to where readings (n, 6) see the places of stretches move; 0: nowhere.

    By the multiple coherence (Bendat, Piersol, Random Data, 2010, 7.3) of the accelerations in the
    room with the accelerometers' readings turned into it, and with what a lever arm would add by
    the gyros: up to where the power that both have in common exceeds SHARED of all by most.
    """
    length = round(WINDOW / interval)
    window, count = np.hanning(length)[:, None], length // 2 + 1
    columns = 1 + len(LEVERS)
    power = np.zeros((count, columns, columns), complex)
    crossed, own = np.zeros((count, columns), complex), np.zeros(count)
    for span, read in zip(spans, reads, strict=True):
        felt, bends = _in_room(span, read, interval)
        for first in range(0, len(span.t) - length + 1, max(1, length // 2)):
            rows = slice(first, first + length)
            # (frequencies, room's axes, columns): each axis of the room is a realisation.
            x, y = (
                rfft(window[..., None] * (each[rows] - each[rows].mean(axis=0)), axis=0)
                for each in (felt, bends[..., None])
            )
            power += np.einsum("fri,frj->fij", x.conj(), x)
            crossed += np.einsum("fri,fr->fi", x.conj(), y[..., 0])
            own += (np.abs(y[..., 0]) ** 2).sum(axis=1)
    frequency = rfftfreq(length, interval)
    edges = np.geomspace(LOWEST, top, max(2, round(PER_OCTAVE * np.log2(top / LOWEST))) + 1)
    gain = [0.0]
    for low, high in pairwise(edges):
        rows = (frequency >= low) & (frequency < high)
        a, b = power[rows].sum(axis=0), crossed[rows].sum(axis=0)
        shared = float((b.conj() @ np.linalg.lstsq(a, b, rcond=None)[0]).real)
        gain.append(gain[-1] + shared - SHARED * own[rows].sum())
    best = int(np.argmax(gain))
    return float(np.sqrt(edges[best - 1] * edges[best])) if best else 0.0


def _in_room(span: Stretch, read: np.ndarray, interval: float) -> tuple[np.ndarray, np.ndarray]:
    """What the readings (n, 6) tell of accelerations in the room, columns (n, 3, 4): by the
    accelerometers and by a lever arm along each axis; and those of the places (n, 3).
    """
    turn = span.attitude.as_matrix()
    rate = read[:, :3]
    change = np.gradient(rate, interval, axis=0)
    arms = [np.cross(change, r) + np.cross(rate, np.cross(rate, r)) for r in LEVERS]
    # Whatever is wrong with scale factors and axes is far less than the share that is asked for.
    columns = [read[:, 3:], *arms]
    turned = [np.einsum("nij,nj->ni", turn, each) for each in columns]
    bends = np.zeros_like(span.place)
    bends[1:-1] = np.diff(span.place, 2, axis=0) / interval**2
    return np.stack(turned, axis=2), bends


# The axes of a tracked body, turned into those of the unit that is fixed to it.
#
# Markers are stuck on somehow. The standard's matrices absorb the turn between the two triads
# whole; what else follows rates or forces, as a lever arm or an error of one accelerometer, does
# not. Where the triads tell different turns, columns are exchanged or inverted, and nothing is
# turned.

DISTINCT = 0.1  # least ratio of the gains of a triad's axes: else it has no attitude
TURNED = 5.0  # deg: a delay of the poses alone looks like one or two
EXCHANGED = 0.7  # cosine between axes of the triads: of half a right angle
HELD = 3  # rows at the largest or least value of a channel from which it is a limit
ROUNDS = 20  # of a fit by absolute deviations, which torn rows hardly move


def in_unit_axes(recording: Recording, motion: Motion) -> tuple[Stream | None, tuple[Sayable, ...]]:
    """The poses of the unit, from those of the body that was tracked, and a remark on a large turn.

    motion: by those poses. None where no poses tell the motion, where gyros do not determine the
    turn, or where accelerometers contradict it.
    """
    pose, imu = recording.reference, recording.imu
    if pose is None or motion.tracking is None:
        return None, ()
    from scipy.spatial.transform import Rotation

    by_gyros = _arrangement(motion.rate, imu.stack(GYRO), motion.felt[:, 0])
    by_accels = _arrangement(motion.force, imu.stack(ACCEL), motion.felt[:, 3])
    if by_gyros is None:
        return None, ()
    if by_accels is not None and (by_gyros * by_accels).sum(axis=0).min() < EXCHANGED:
        return None, (message("reference-triads-apart"),)
    if np.linalg.det(by_gyros) < 0.0:
        return None, ()
    turn = Rotation.from_matrix(by_gyros)
    attitude = Rotation.from_quat(pose.stack(POSE), scalar_first=True) * turn
    columns = dict(zip(POSE, attitude.as_quat(scalar_first=True).T, strict=True))
    degrees = DEG * turn.magnitude()
    remarks = (message("reference-turned", degrees=f"{degrees:.1f}"),) if degrees > TURNED else ()
    return replace(pose, columns={**pose.columns, **columns}), remarks


def _arrangement(by_poses: np.ndarray, read: np.ndarray, known: np.ndarray) -> np.ndarray | None:
    """(3, 3) orthogonal, from a triad's axes to the body's: the nearest to the matrix that makes
    the triad's readings (n, 3) of what the poses tell (n, 3). None where they do not determine it.

    Of absolute deviations, by weights that are the inverse of each row's deviation.
    """
    used = known & np.isfinite(by_poses).all(axis=1) & np.isfinite(read).all(axis=1)
    used &= ~_at_limits(read).any(axis=1)
    if not used.any():
        return None
    columns, readings = np.column_stack([by_poses, np.ones(len(by_poses))])[used], read[used]
    weight = np.ones((len(columns), 1))
    for _ in range(ROUNDS):
        fitted, _, rank, _ = np.linalg.lstsq(columns * weight, readings * weight, rcond=None)
        size = np.linalg.norm(readings - columns @ fitted, axis=1, keepdims=True)
        weight = 1.0 / np.sqrt(np.maximum(size, 1e-3 * size.mean() + 1e-12))
    left, gains, right = np.linalg.svd(fitted[:3])
    if rank < columns.shape[1] or gains[-1] < DISTINCT * gains[0]:
        return None
    return np.asarray(left @ right)


def _at_limits(read: np.ndarray) -> np.ndarray:
    """(n, 3) bool: readings at the largest or least value of their channel, if it has several."""
    ends = [read == extreme.reduce(read, axis=0) for extreme in (np.fmax, np.fmin)]
    return np.asarray(np.any([end & (end.sum(axis=0) >= HELD) for end in ends], axis=0))
