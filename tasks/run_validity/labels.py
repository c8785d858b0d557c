"""The labels, checked against gravity, the table and the gyros."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from schemas.recording import AXES
from schemas.text import Remark
from tasks.motion.table import mean_rate
from tasks.motion.whole import attitude_stream
from tasks.run_validity.remark import run_remark
from tasks.segments.find import Conditions, shown_instead
from tasks.segments.rates import TurningPoint
from tasks.segments.summarise import ACCEL_COLUMNS, GYRO_COLUMNS, SegmentMean
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import message

LISTED_PAIRS = 5
TURNING = np.radians(2.0)  # rad/s: a gyro at rest reads no more than the usual rest does
CREEPING = np.radians(0.01)  # rad/s that a table at rest turns by its encoders
MIN_RESTS = 8  # twice the unknowns of a zero and its g-sensitivity
MAX_CONDITION = 100.0  # of attitudes in m/s²: six faces have 10, rests about one axis far more
FAST = np.radians(5.0)  # rad/s: below it a zero looks like a gain
FOLLOWS = 0.5  # of a rate, from which a gyro turns with it whatever its scale factor
ANGLE = 1e-3  # of a turn by an angle, by which the encoders may have it otherwise


def label_remarks(evidence: ClauseEvidence, conditions: Conditions) -> Iterator[Remark]:
    """Labels that nothing confirms, and labels that something contradicts."""
    yield from _no_reference(evidence)
    for i, segment in enumerate(evidence.segments):
        yield from _position(segment)
        yield from _turned_angle(evidence, segment)
        if i in evidence.turning_points:
            yield from _rate(evidence, segment, evidence.turning_points[i], conditions)
    yield from _input_axes(evidence)
    yield from _turning_rests(evidence)


def _no_reference(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Turns without encoders or pose: the labels are their only evidence."""
    turning = [label.name for label in evidence.labels if label.kind in ("rate", "rotation")]
    if turning and attitude_stream(evidence.recording) is None:
        yield run_remark("no_reference", *turning, count=len(turning))


def _position(segment: SegmentMean) -> Iterator[Remark]:
    """A labelled position that gravity contradicts."""
    accel = segment.mean[ACCEL_COLUMNS]
    name, label = segment.segment.name, segment.segment.up or ""
    shown, axis = shown_instead(segment.segment, accel), label[1:]
    if shown is None:
        return
    yield run_remark(
        "position_contradicted", name, run="invalid", segment=name, label=label, axis=axis,
        reading=f"{accel[AXES.index(axis)]:+.3f}", shown=shown,
    )  # fmt: skip


def _rate(
    evidence: ClauseEvidence, segment: SegmentMean, point: TurningPoint, conditions: Conditions
) -> Iterator[Remark]:
    """A rate that its witness contradicts, or that did not hold still."""
    name, axis = segment.segment.name, segment.segment.axis or ""
    witness = "table" if point.by_table else evidence.channel_names[AXES.index(axis)]
    if point.contradicted and point.shown is not None:
        yield run_remark(
            "rate_contradicted", name, run="invalid", segment=name, axis=axis, witness=witness,
            label=f"{np.degrees(point.label):+g}", shown=f"{np.degrees(point.shown):+.4f}",
        )  # fmt: skip
    if point.unsteady:
        yield run_remark(
            "unsteady_rate", name, segment=name, witness=witness,
            wander=f"{np.degrees(point.wander):.4f}", clause=conditions.steadiness_clause,
            percent=f"{100 * conditions.steadiness:g}",
        )  # fmt: skip


def _input_axes(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Runs about an axis that another gyro follows, or its own gyro the other way round."""
    rests = evidence.means[evidence.of_kind("static")][:, GYRO_COLUMNS]
    zero = np.median(rests, axis=0) if len(rests) else np.zeros(len(AXES))
    for axis in AXES:
        points = [*evidence.points[axis], *evidence.turns[axis]]
        rates = np.array([_rate_of(evidence, i) for i in points])
        if not len(rates) or np.abs(rates).max() < FAST:
            continue
        gains = rates @ (evidence.means[points][:, GYRO_COLUMNS] - zero) / (rates @ rates)
        largest = int(np.abs(gains).argmax())
        if abs(gains[largest]) > FOLLOWS and (AXES[largest] != axis or gains[largest] < 0.0):
            yield run_remark(
                "input_axis", *(evidence.labels[i].name for i in points), run="invalid",
                axis=axis, gyro=AXES[largest], gain=f"{gains[largest]:+.2f}",
            )  # fmt: skip


def _rate_of(evidence: ClauseEvidence, i: int) -> float:
    """The rate of a held rate, or the mean one of a turn (rad/s)."""
    label = evidence.labels[i]
    if label.kind == "rate":
        return float(evidence.rate[i])
    return float(np.radians(label.angle_deg or 0.0) / evidence.segments[i].seconds)


def _turned_angle(evidence: ClauseEvidence, segment: SegmentMean) -> Iterator[Remark]:
    """A turn by an angle that the encoders have otherwise."""
    label = segment.segment
    rate = mean_rate(evidence.recording, label) if label.kind == "rotation" else None
    if rate is None or label.axis is None or label.angle_deg is None:
        return
    table = evidence.recording.table
    assert table is not None  # it gave the rate
    t = table.t[table.rows(label.t_start, label.t_end)]
    shown = float(np.degrees(rate[AXES.index(label.axis)]) * (t[-1] - t[0]))
    if abs(shown - label.angle_deg) > ANGLE * abs(label.angle_deg):
        yield run_remark(
            "angle_contradicted", label.name, run="invalid", segment=label.name,
            label=f"{label.angle_deg:+g}", shown=f"{shown:+.2f}",
        )  # fmt: skip


def _turning_rests(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Rests in which the table turns; without one, those whose gyros read another rate.

    Of a rest whose encoders stand still a gyro may read what it likes: that is its g-sensitivity.
    """
    rests = [evidence.segments[i] for i in evidence.of_kind("static")]
    table = [mean_rate(evidence.recording, rest.segment) for rest in rests]
    moved = [
        rest.segment.name
        for rest, rate in zip(rests, table, strict=True)
        if rate is not None and np.linalg.norm(rate) > CREEPING
    ]
    unseen = [rest for rest, rate in zip(rests, table, strict=True) if rate is None]
    away = np.abs(_unlike_others(unseen)) > TURNING
    moved += [r.segment.name for r, far in zip(unseen, away, strict=True) if far.any()]
    if moved:
        names = tuple(dict.fromkeys(moved))
        yield run_remark("rest_turns", *names, run="invalid", count=len(names), first=names[0])


def _unlike_others(rests: list[SegmentMean]) -> np.ndarray:
    """(rests, 3) rad/s: what the gyros read beside what most rests agree on.

    Most agree on a zero and, where there are enough rests in enough attitudes to tell, on its
    g-sensitivity: a fit of least absolute differences, which a few rests that turn do not draw.
    """
    gyro = np.array([rest.mean[GYRO_COLUMNS] for rest in rests]).reshape(-1, 3)
    accel = np.array([rest.mean[ACCEL_COLUMNS] for rest in rests]).reshape(-1, 3)
    columns = np.column_stack([np.ones(len(rests)), accel])
    unlike = gyro - (np.nanmedian(gyro, axis=0) if np.isfinite(gyro).any() else 0.0)
    if not (np.abs(unlike) > TURNING).any():
        return unlike
    can_tell = len(rests) >= MIN_RESTS and np.isfinite(columns).all() and np.isfinite(gyro).all()
    if not can_tell or np.linalg.cond(columns) > MAX_CONDITION:
        return unlike
    return np.column_stack([each - columns @ _least_absolute(columns, each) for each in gyro.T])


def _least_absolute(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(k,) coefficients with the least sum of |values − columns @ coefficients|."""
    from scipy.optimize import linprog  # 0.2 s, and few recordings have rests that differ

    rows, k = columns.shape
    bound = np.eye(rows)
    found = linprog(
        np.r_[np.zeros(k), np.ones(rows)],
        A_ub=np.block([[columns, -bound], [-columns, -bound]]), b_ub=np.r_[values, -values],
        bounds=[(None, None)] * k + [(0.0, None)] * rows,
    )  # fmt: skip
    return np.asarray(found.x[:k])


def point_remarks(evidence: ClauseEvidence, conditions: Conditions) -> Iterator[Remark]:
    """Points that are too short, and points that share their samples."""
    yield from _short(evidence.segments, conditions)
    yield from _overlapping(evidence.segments)


def _short(segments: tuple[SegmentMean, ...], conditions: Conditions) -> Iterator[Remark]:
    """Every segment that lasts less than each point must last."""
    held = [segment for segment in segments if segment.segment.kind != "rotation"]
    short = {s.segment.name: _lasts(s) for s in held if _lasts(s) < conditions.dwell_s - 1e-6}
    if short:
        yield run_remark(
            "short_dwell", *short, short=len(short), held=len(held),
            asked=f"{conditions.dwell_s:.0f}", clause=conditions.dwell_clause,
            listed=", ".join(f"{name} {lasts:.1f} s" for name, lasts in short.items()),
        )  # fmt: skip


def _lasts(segment: SegmentMean) -> float:
    """How long a segment lasts (s): its samples, and up to two intervals that its label adds."""
    interval = segment.seconds / segment.rows
    asked = segment.segment.t_end - segment.segment.t_start
    return max(segment.seconds, min(asked, segment.seconds + 2 * interval))


def _overlapping(segments: tuple[SegmentMean, ...]) -> Iterator[Remark]:
    """Segments that share more than one row: the same noise would be counted as new evidence."""
    ordered = sorted(segments, key=lambda s: s.t_start)
    pairs = [
        (first.segment.name, second.segment.name)
        for first, second in pairwise(ordered)
        if second.t_start < first.t_end - 1.5 * first.seconds / first.rows
    ]
    if pairs:
        listed = [message("validity-pair", first=a, second=b) for a, b in pairs[:LISTED_PAIRS]]
        names = dict.fromkeys(name for pair in pairs for name in pair)
        yield run_remark(
            "overlapping_segments", *names,
            pairs=tuple(listed), more=max(len(pairs) - LISTED_PAIRS, 0),
        )  # fmt: skip
