"""What must be said of a reference that is not a table's: how it was smoothed, what it lacks."""

import numpy as np

from schemas.recording import ACCEL, Recording
from tasks.motion.pose import BRIDGED
from tasks.motion.whole import Motion
from tasks.words import Sayable, message

WORTH_SAYING = 0.005  # of the recording


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
    lost = 1.0 - float(motion.felt[:, 0].mean())
    if lost > WORTH_SAYING:
        percent, frames = f"{100.0 * lost:.0f}", int(BRIDGED) - 1
        remarks.append(message("reference-lost", percent=percent, frames=frames))
    return tuple(remarks)
