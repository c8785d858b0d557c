"""The angle of a turn and how fast it was: by the table's encoders, else by the label."""

import numpy as np

from schemas.recording import AXES, Recording, Segment
from tasks.motion.table import mean_rate


def turned_angle(recording: Recording, segment: Segment) -> float:
    """Angle (rad) turned about the segment's axis: by the encoders, else by the label."""
    if recording.table is not None and segment.axis is not None:
        t = recording.table.t
        interval = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
        # The reading at the very end is the one that closes the turn.
        whole = segment.model_copy(update={"t_end": segment.t_end + 0.5 * interval})
        rate, rows = mean_rate(recording, whole), recording.table.rows(whole.t_start, whole.t_end)
        if rate is not None:
            return float(rate[AXES.index(segment.axis)] * (t[rows.stop - 1] - t[rows.start]))
    return label_angle(segment)


def label_angle(segment: Segment) -> float:
    """Angle (rad) that the label says was turned."""
    if segment.angle_deg is not None:
        return float(np.radians(segment.angle_deg))
    return float(np.radians(segment.rate_deg_s or 0.0)) * (segment.t_end - segment.t_start)


def rate_in_the_middle(recording: Recording, turn: Segment) -> float:
    """Rate (deg/s) in the middle third of a turn by the encoders, else over the whole of it."""
    third = (turn.t_end - turn.t_start) / 3.0
    edges = {"t_start": turn.t_start + third, "t_end": turn.t_end - third}
    by_table = mean_rate(recording, turn.model_copy(update=edges))
    if by_table is not None:
        return float(np.degrees(np.linalg.norm(by_table)))
    return float(np.degrees(abs(label_angle(turn)))) / (turn.t_end - turn.t_start)
