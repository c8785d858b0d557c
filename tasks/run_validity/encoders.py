"""The table's encoders, checked against themselves, gravity and the gyros."""

from collections.abc import Iterator

import numpy as np

from schemas.recording import AXES, Stream
from schemas.text import Remark
from tasks.motion.polled import polled_within
from tasks.motion.table import mount_of, payload_attitude, table_angles
from tasks.run_validity.remark import run_remark
from tasks.segments.summarise import ACCEL_COLUMNS, GYRO_COLUMNS
from tasks.specifications.evidence import ClauseEvidence

JUMP = np.radians(0.5)  # rad: no encoder's noise or step
ACCELERATION = np.radians(2000.0)  # rad/s² that no turntable has
ADJACENT = 1.5  # usual intervals: what lies farther apart is no step of the encoder
ATTITUDE = 0.3  # m/s²: two degrees of tilt beside what unit and mounting do in all rests
GAIN = 0.05  # of a held rate, by which the gyro may follow otherwise than in the other runs
SLOW = np.radians(5.0)  # rad/s: below it a zero looks like a gain


def encoder_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Encoders that jump, or that show another attitude or rate than the unit feels."""
    recording = evidence.recording
    axes, table = recording.manifest.station.table_axes, recording.table
    if table is None or not axes:
        return
    for axis in axes:
        yield from _jumps(axis.name, table, polled_within(recording))
    yield from _attitude(evidence)
    yield from _gain(evidence)


def _jumps(axis: str, table: Stream, half_width_s: float) -> Iterator[Remark]:
    """Samples between which no table can have turned so far.

    half_width_s: of the time of an angle that is polled, at any interval.
    """
    if len(table) < 4:
        return
    steps, angle = np.diff(table.t), table.columns[f"{axis}_angle"]
    usual = float(np.median(steps))
    turned = np.diff(angle)
    bend = np.abs((np.diff(turned) + np.pi) % (2.0 * np.pi) - np.pi)  # encoders may start anew
    near = np.maximum(steps[1:], steps[:-1]) < ADJACENT * usual
    limit = np.full(len(bend), max(JUMP, ACCELERATION * usual**2))
    if half_width_s:
        speed = np.abs(turned / steps)
        off = np.abs(np.diff(steps)) + 4.0 * half_width_s
        limit += off * np.maximum(speed[1:], speed[:-1])
    jumps = np.flatnonzero(near & (bend > limit))
    if len(jumps):
        worst = int(jumps[bend[jumps].argmax()])
        yield run_remark(
            "encoder_jump", run="invalid", axis=axis, count=len(jumps),
            size=f"{np.degrees(bend[worst]):.2f}", time=f"{table.t[worst + 1]:.2f}",
        )  # fmt: skip


def _attitude(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Rests in which gravity lies otherwise in the unit than the encoders have it."""
    recording, rests, up = evidence.recording, [], []
    for segment in evidence.segments:
        angles = table_angles(recording, segment.segment)
        if segment.segment.kind == "static" and segment.has_accel and len(angles):
            payload = payload_attitude(recording.manifest.station, angles.mean(axis=0))
            rests.append(segment)
            up.append((payload @ mount_of(recording.manifest, segment.segment))[2])
    if len(rests) <= 4:
        return
    design = np.column_stack([np.ones(len(rests)), up])
    felt = np.array([rest.mean[ACCEL_COLUMNS] for rest in rests])
    left = felt - design @ np.linalg.lstsq(design, felt, rcond=None)[0]
    away = np.abs(left).max(axis=1)
    if away.max() > ATTITUDE:
        names = [rests[i].segment.name for i in np.flatnonzero(away > ATTITUDE)]
        yield run_remark(
            "attitude_contradicted", *names, run="invalid", count=len(names), first=names[0],
            left=f"{away.max():.2f}", limit=f"{ATTITUDE:g}",
        )  # fmt: skip


def _gain(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Held rates by the encoders that the gyro follows otherwise than the other rates."""
    rests = evidence.means[evidence.of_kind("static")][:, GYRO_COLUMNS]
    rests = rests[np.isfinite(rests).all(axis=1)]
    zero = np.median(rests, axis=0) if len(rests) else np.zeros(3)
    for number, axis in enumerate(AXES):
        points = [
            i
            for i, point in evidence.turning_points.items()
            if evidence.labels[i].axis == axis and point.by_table and abs(point.rate) > SLOW
        ]
        if len(points) < 3 or not len(rests):
            continue
        rates = np.array([evidence.turning_points[i].rate for i in points])
        gains = (evidence.means[points, number] - zero[number]) / rates
        away = np.abs(gains - np.median(gains)) > GAIN * abs(np.median(gains))
        names = [evidence.labels[points[i]].name for i in np.flatnonzero(away)]
        if names:
            yield run_remark(
                "gyro_contradicts_encoder", *names, run="invalid", axis=axis, count=len(names),
                first=names[0], percent=f"{100 * GAIN:g}",
            )  # fmt: skip
