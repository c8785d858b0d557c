"""Remarks on the reference, how it was smoothed, and on the unit's clock, for judging a delay."""

import numpy as np
from pydantic import ValidationError

from schemas.recording import ACCEL, GYRO, Recording
from schemas.unit_link import ClockComparison
from tasks.model.parameters import DEG
from tasks.model.terms.timing import TIME_OFFSET
from tasks.motion.pose_frames import BRIDGED
from tasks.motion.whole import Motion
from tasks.words import Sayable, message

WORTH_SAYING = 0.005  # of the recording
DISTINCT = 0.1  # least ratio of the gains of a triad's axes: else it has no attitude
TURNED = 5.0  # deg: a delay of the poses alone looks like one or two
COVERAGE = 2.0


def reference_remarks(recording: Recording, motion: Motion) -> tuple[Sayable, ...]:
    """Remarks on tracked poses; none for a table or labels."""
    tracking = motion.tracking
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
    if (turn := _turn(recording, motion)) is not None and turn > TURNED:
        remarks.append(message("reference-turned", degrees=f"{turn:.1f}"))
    lost = 1.0 - float(motion.felt[:, 0].mean())
    if lost > WORTH_SAYING:
        percent, frames = f"{100.0 * lost:.0f}", int(BRIDGED) - 1
        remarks.append(message("reference-lost", percent=percent, frames=frames))
    return tuple(remarks)


def _turn(recording: Recording, motion: Motion) -> float | None:
    """Angle (deg) between the tracked body and the gyros' triad: of the rotation that is nearest
    to the matrix that makes the gyros' readings of the poses' rates. None where none does.
    """
    gyro = recording.imu.stack(GYRO)
    known = motion.felt[:, 0] & np.isfinite(gyro).all(axis=1)
    columns = np.column_stack([motion.rate, np.ones(len(gyro))])[known]
    if len(columns) < columns.shape[1]:
        return None
    fitted, _, rank, _ = np.linalg.lstsq(columns, gyro[known], rcond=None)
    left, gains, right = np.linalg.svd(fitted[:3])
    if rank < columns.shape[1] or gains[-1] < DISTINCT * gains[0]:
        return None
    rotation = left @ right
    return float(DEG * np.arccos(np.clip(0.5 * (np.trace(rotation) - 1.0), -1.0, 1.0)))


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
