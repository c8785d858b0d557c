"""Leaves out labels that gravity, encoders or gyros contradict, as a calibration does.

Where most labels of a kind are contradicted, or all of one axis, it is not the labels that are
wrong: axes exchanged or inverted, a range set wrong. Then they are used, and what is wrong is
looked for.
"""

from dataclasses import replace

import numpy as np
from pydantic import ValidationError

from schemas.recording import ACCEL, Recording
from schemas.unit_link import ClockComparison
from tasks.explain.explanation import COVERAGE
from tasks.model.terms.timing import TIME_OFFSET
from tasks.motion.pose import BRIDGED
from tasks.motion.samples import SLOW, sample_interval
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
