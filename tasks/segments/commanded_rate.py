"""Which rate is the reference on a table whose angles are polled: theirs, or the commanded one.

The times of polled angles are known to ± τ, so that a mean rate over T is uncertain by √2·τ/T. A
table that holds the rate it is told to better than that is believed, where its angles agree.
"""

import numpy as np
from pydantic import ValidationError

from schemas.base import Unusable, first_fault
from schemas.equipment import ErrorBound
from schemas.recording import Recording, Segment
from tasks.motion.polled import agreeing_rate, doubt_of_angles


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


def rate_by_command(recording: Recording, segment: Segment) -> np.ndarray | None:
    """The mean body rate (3,) rad/s of a held rate as commanded, about the axis that turns.

    None where the angles tell it better, or contradict it.
    """
    bound, seconds = commanded_bound(recording), segment.t_end - segment.t_start
    if bound is None or segment.kind != "rate":
        return None
    is_better = bound.half_width < doubt_of_angles(recording, seconds)
    return agreeing_rate(recording, segment) if is_better else None
