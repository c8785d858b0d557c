"""Which rate is the reference on a table whose angles are polled: theirs, or the commanded one.

The times of polled angles are known to ± τ, so that a mean rate over T is uncertain by √2·τ/T. A
table that holds the rate it is told to better than that is believed, where its angles agree.
"""

import math

import numpy as np
from pydantic import ValidationError

from schemas.base import Unusable, first_fault
from schemas.equipment import ErrorBound
from schemas.recording import Recording, Segment
from tasks.motion.table import mean_rate

MOST_HALF_WIDTH_S = 3600.0
STEADINESS = 5e-4  # 0.05 % rate stability, JJF 2003-2022, Table 1


def polled_within(recording: Recording) -> float:
    """Within how many seconds the times of polled angles are known; 0 where they are captured.

    Raises Unusable for a `table_time` that says no such time.
    """
    stated = (recording.manifest.model_extra or {}).get("table_time")
    if stated is None or recording.table is None:
        return 0.0
    half_width_s = stated.get("half_width_s") if isinstance(stated, dict) else stated
    if not isinstance(half_width_s, int | float) or not 0.0 <= half_width_s < MOST_HALF_WIDTH_S:
        raise Unusable(
            f"the manifest's table_time.half_width_s is {half_width_s!r}: give the half-width in s "
            f"(0 to {MOST_HALF_WIDTH_S:g}) by which the encoders' times are known"
        )
    return float(half_width_s)


def commanded_bound(recording: Recording) -> ErrorBound | None:
    """How far a held rate may be from the commanded one, relative; None where it is not said.

    Raises Unusable where the manifest's `table_time.commanded_rate` is no such bound.
    """
    stated = (recording.manifest.model_extra or {}).get("table_time")
    bound = stated.get("commanded_rate") if isinstance(stated, dict) else None
    try:
        return None if bound is None else ErrorBound.model_validate(bound)
    except ValidationError as error:
        raise Unusable(
            f"the manifest's table_time.commanded_rate: {first_fault(error)}; give half_width and "
            f"distribution, or leave it out"
        ) from error


def doubt_of_angles(recording: Recording, seconds: float) -> float:
    """By how much of itself a mean rate over some seconds may be wrong, by the angles' times."""
    return math.sqrt(2.0) * polled_within(recording) / max(seconds, 1e-3)


def rate_by_command(recording: Recording, segment: Segment) -> np.ndarray | None:
    """The mean body rate (3,) rad/s of a held rate as commanded, about the axis that turns.

    None where the angles tell it better, or contradict it.
    """
    bound, seconds = commanded_bound(recording), segment.t_end - segment.t_start
    doubt = doubt_of_angles(recording, seconds)
    if bound is None or segment.kind != "rate" or bound.half_width >= doubt:
        return None
    shown = mean_rate(recording, segment)
    if shown is None or not shown.any() or not segment.rate_deg_s:
        return None
    commanded = abs(np.radians(segment.rate_deg_s)) / np.linalg.norm(shown)
    return shown * commanded if abs(commanded - 1.0) < STEADINESS + doubt else None
