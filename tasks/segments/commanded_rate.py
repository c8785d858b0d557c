"""Which rate is the reference on a table whose angles are polled: theirs, or the commanded one.

The times of polled angles are known to ± τ, so that a mean rate over T is uncertain by √2·τ/T. A
table that holds the rate it is told to better than that is believed, where its angles agree.
"""

import math

from pydantic import ValidationError

from schemas.base import Unusable, first_fault
from schemas.equipment import ErrorBound
from schemas.recording import Recording, Segment

MOST_HALF_WIDTH_S = 3600.0


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


def is_by_command(recording: Recording, segment: Segment, seconds: float) -> bool:
    """Whether the commanded rate is known better than the one that the angles tell."""
    bound = commanded_bound(recording)
    if bound is None or segment.kind != "rate" or not segment.rate_deg_s:
        return False
    return bound.half_width < doubt_of_angles(recording, seconds)
