"""Leaves out labels that gravity, encoders or gyros contradict, as a calibration does.

Where most labels of a kind are contradicted, or all of one axis, it is not the labels that are
wrong: axes exchanged or inverted, a range set wrong. Then they are used, and what is wrong is
looked for.
"""

from dataclasses import replace

import numpy as np

from schemas.recording import Recording
from tasks.readings.label_shift import LabelShift
from tasks.readings.standing import steps
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
