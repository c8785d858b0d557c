"""Remarks on the reference, how it was smoothed, and on the unit's clock, for judging a delay."""

import numpy as np
from pydantic import ValidationError

from schemas.recording import ACCEL, Recording
from schemas.unit_link import ClockComparison
from tasks.explain.odds import COVERAGE
from tasks.model.terms.timing import TIME_OFFSET
from tasks.motion.pose_frames import BRIDGED
from tasks.motion.samples import SLOW, sample_interval
from tasks.motion.whole import Motion
from tasks.words import Sayable, message
from tasks.words.quantities import plain

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
