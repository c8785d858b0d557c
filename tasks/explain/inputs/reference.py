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
from pydantic import ValidationError

from schemas.recording import ACCEL, GYRO, Recording, Stream
from schemas.unit_link import ClockComparison
from tasks.explain.explanation import COVERAGE
from tasks.model.model import predict
from tasks.model.term import DEG, nominal_values
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.model.terms.timing import TIME_OFFSET
from tasks.motion.pose import (
    BRIDGED,
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
from tasks.motion.samples import SLOW, interpolated, sample_interval
from tasks.motion.whole import Motion
from tasks.readings.plausibility import LabelShift, steps
from tasks.segments.find import shown_instead
from tasks.segments.rates import OFF_LINE, OFF_LINE_LEAST, TurningPoint, turning_points
from tasks.segments.summarise import (
    ACCEL_COLUMNS,
    CHANNELS,
    MIN_ROWS,
    far_rows,
    summarise_all,
    widened,
)
from tasks.words import Message, Sayable, message
from tasks.words.numbers import plain


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


# Leaves out labels that gravity, encoders or gyros contradict, as a calibration does.
#
# Where most labels of a kind are contradicted, or all of one axis, it is not the labels that are
# wrong: axes exchanged or inverted, a range set wrong. Then they are used, and what is wrong is
# looked for.

MOST = 0.5  # of the labels that can be checked: more contradictions are not theirs


def moved_labels(recording: Recording, shift: LabelShift) -> Recording:
    """The recording with all labels shifted, and shortened at both ends by what is unsure of it."""
    moved = tuple(
        label.model_copy(update={
            "t_start": label.t_start + shift.seconds + shift.within,
            "t_end": label.t_end + shift.seconds - shift.within,
        })
        for label in recording.manifest.segments or ()
        if label.t_end - label.t_start > 2.0 * shift.within
    )  # fmt: skip
    manifest = recording.manifest.model_copy(update={"segments": moved})
    return replace(recording, manifest=manifest)


def with_usable_labels(recording: Recording) -> tuple[Recording, tuple[Sayable, ...]]:
    """The recording without contradicted labels, and remarks that name them."""
    labels = recording.manifest.segments or ()
    summaries = summarise_all(recording, labels, "label")
    means = tuple(one for one in summaries if one.rows >= MIN_ROWS)
    points = turning_points(recording, means)
    by_gravity = _if_few({
        (mean.segment.up[1], mean.segment.name): shown_instead(
            mean.segment, mean.mean[ACCEL_COLUMNS]
        ) is not None
        for mean in means
        if mean.segment.kind == "static" and mean.segment.up is not None and mean.has_accel
    })  # fmt: skip
    by_rate = _if_few({
        (means[k].segment.axis or "", means[k].segment.name): _another_rate(point)
        for k, point in points.items()
    })  # fmt: skip
    if not by_gravity and not by_rate:
        return recording, ()
    kept = tuple(label for label in labels if label.name not in {*by_gravity, *by_rate})
    manifest = recording.manifest.model_copy(update={"segments": kept})
    remarks: list[Sayable] = []
    if by_gravity:
        listed = ", ".join(by_gravity)
        remarks.append(message("reference-labels-against-gravity", segments=listed))
    if by_rate:
        listed = ", ".join(by_rate)
        table = "yes" if any(point.by_table for point in points.values()) else "no"
        remarks.append(message("reference-labels-against-rate", segments=listed, table=table))
    return replace(recording, manifest=manifest), tuple(remarks)


def disturbed_rows(recording: Recording) -> tuple[np.ndarray, tuple[Message, ...]]:
    """The rows (n,) bool of rests that lie far from the rest of them, as a calibration leaves them
    out, with a remark that names the rests.

    Where labels alone tell the motion: nothing else would show that the unit was touched, or moved
    already, and a few rows of that outweigh all that the others show. Where encoders or poses tell
    the motion, no row is.
    """
    disturbed = np.zeros(len(recording.imu), bool)
    if recording.table is not None or recording.reference is not None:
        return disturbed, ()
    step, named = steps(recording.imu), list[str]()
    for label in recording.manifest.segments or ():
        place = recording.imu.rows(label.t_start, label.t_end)
        if label.kind != "static" or place.stop - place.start < MIN_ROWS:
            continue
        views = zip(recording.imu.views(CHANNELS, place), step.tolist(), strict=True)
        far = [rows for channel, one in views if (rows := far_rows(channel, one)) is not None]
        if far:
            disturbed[place] = widened(np.any(far, axis=0))
            named.append(label.name)
    if not named:
        return disturbed, ()
    count, listed = int(disturbed.sum()), ", ".join(named)
    return disturbed, (message("reference-rests-disturbed", rows=count, segments=listed),)


def _another_rate(point: TurningPoint) -> bool:
    """Whether a witness shows another rate than the label's, and not a scale factor or a bias."""
    if not point.by_table or point.shown is None:
        return point.contradicted
    return abs(point.shown - point.label) > max(OFF_LINE * abs(point.label), OFF_LINE_LEAST)


def _if_few(contradicted: dict[tuple[str, str], bool]) -> tuple[str, ...]:
    """The names of contradicted labels, by axis and name; none where they are most of those that
    were checked, and none of an axis of which several were checked and all are contradicted.
    """
    by_axis: dict[str, list[bool]] = {}
    for (axis, _), wrong in contradicted.items():
        by_axis.setdefault(axis, []).append(wrong)
    whole = {axis for axis, wrong in by_axis.items() if len(wrong) > 1 and all(wrong)}
    names = tuple(n for (axis, n), wrong in contradicted.items() if wrong and axis not in whole)
    return names if sum(contradicted.values()) <= MOST * len(contradicted) else ()


# Remarks on the reference, how it was smoothed, and on the unit's clock, for judging a delay.

WORTH_SAYING = 0.005  # of the recording


def reference_remarks(recording: Recording, motion: Motion) -> tuple[Sayable, ...]:
    """Remarks on tracked poses; none for a table or labels."""
    tracking = motion.tracking
    slow = recording.table
    if motion.axes is not None and slow is not None and sample_interval(slow.t) >= SLOW:
        unknown = (np.isfinite(motion.up) & ~np.isfinite(motion.rate)).any(axis=1)
        percent = f"{100.0 * float(unknown.mean()):.0f}"
        return (message("reference-slow", every=plain(sample_interval(slow.t)), percent=percent),)
    if tracking is None or not np.isfinite(tracking.edge):
        return ()
    attitude = f"{tracking.attitude:.1f}"
    remarks: list[Sayable] = []
    if tracking.place is not None:
        place = f"{tracking.place:.1f}"
        remarks.append(message("reference-smoothed", attitude=attitude, place=place))
    else:
        remarks.append(message("reference-smoothed-attitude", attitude=attitude))
        if not recording.manifest.station.table_axes and set(ACCEL) <= set(recording.imu.columns):
            percent = f"{100.0 * motion.felt[:, 3].mean():.0f}"
            remarks.append(message("reference-without-positions", percent=percent))
    remarks.append(message("reference-nuisances"))
    unknown = 1.0 - float(motion.felt[:, 0].mean())
    if unknown > WORTH_SAYING and recording.reference is not None:
        steps = np.diff(recording.reference.t)
        missing = float(steps[steps > BRIDGED * tracking.interval].sum() / steps.sum())
        shares = {"unknown": unknown, "missing": missing}
        given = {name: f"{100.0 * share:.0f}" for name, share in shares.items()}
        remarks.append(message("reference-lost", frames=int(BRIDGED) - 1, **given))
    return tuple(remarks)


def clock_remarks(recording: Recording) -> tuple[Sayable, ...]:
    """The part of a delay due to the clocks, τ = −offset of the recorded stamps, with its U.

    It is reported, but not used as a prior of the delay, since the unit's own filter is not part of
    it. None if the recording has no comparison with its half-width; if U exceeds a plausible delay,
    as on a virtual station that runs fast; and for a unit that was switched on again, whose clock
    was reset.
    """
    kept = recording.manifest.model_extra or {}
    try:
        clock = ClockComparison.model_validate(kept.get("unit_clock"))
        moved_s = float(kept.get("unit_clock_shift_s", 0.0))
    except (ValidationError, TypeError, ValueError):
        return ()
    expanded_s = COVERAGE * clock.u_offset_s
    _, largest_s = TIME_OFFSET.parameters[0].plausible
    if "unit_power_on_s" in kept or expanded_s > largest_s:
        return ()
    delay, U = (f"{1e3 * seconds:.1f}" for seconds in (moved_s - clock.offset_s, expanded_s))
    return (message("reference-unit-clock", delay=delay, U=U),)
