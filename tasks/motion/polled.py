"""A table whose angles are polled: their times are known to ± τ, as the manifest says.

A mean rate over T is uncertain by √2·τ/T of itself, and no derivative of such angles is a rate.
What is known of the motion is what the labels say is held: rests, and rates that the angles agree
with.
"""

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from schemas.base import Unusable
from schemas.recording import Recording, Segment
from tasks.motion.table import mean_rate

if TYPE_CHECKING:
    from tasks.motion.whole import Motion

MOST_HALF_WIDTH_S = 3600.0
STEADINESS = 5e-4  # 0.05 % rate stability, JJF 2003-2022, Table 1


def polled_within(recording: Recording) -> float:
    """Within how many seconds the times of polled angles are known; 0 where they are captured.

    Raises Unusable for a `table_time` that says no such time.
    """
    stated = (recording.manifest.model_extra or {}).get("table_time")
    if stated is None or recording.table is None:
        return 0.0
    captured = 0.0 if isinstance(stated, dict) and "commanded_rate" in stated else None
    half_width_s = stated.get("half_width_s", captured) if isinstance(stated, dict) else stated
    if not isinstance(half_width_s, int | float) or not 0.0 <= half_width_s < MOST_HALF_WIDTH_S:
        raise Unusable(
            f"the manifest's table_time.half_width_s is {half_width_s!r}: give the half-width in s "
            f"(0 to {MOST_HALF_WIDTH_S:g}) by which the encoders' times are known"
        )
    return float(half_width_s)


def doubt_of_angles(recording: Recording, seconds: float) -> float:
    """By how much of itself a mean rate over some seconds may be wrong, by the angles' times."""
    return math.sqrt(2.0) * polled_within(recording) / max(seconds, 1e-3)


def agreeing_rate(recording: Recording, segment: Segment) -> np.ndarray | None:
    """The mean body rate (3,) rad/s of a held rate as labelled, about the axis that turns.

    None where the angles contradict it.
    """
    shown = mean_rate(recording, segment)
    if shown is None or not shown.any() or not segment.rate_deg_s:
        return None
    labelled = abs(np.radians(segment.rate_deg_s)) / np.linalg.norm(shown)
    doubt = doubt_of_angles(recording, segment.t_end - segment.t_start)
    return shown * labelled if abs(labelled - 1.0) < STEADINESS + doubt else None


def as_held(recording: Recording, motion: "Motion") -> "Motion":
    """The motion with the rates that are held, unknown in between; the angles are no course."""
    rate = np.full_like(motion.rate, np.nan)
    for segment in recording.manifest.segments or ():
        rows = slice(*np.searchsorted(motion.t, (segment.t_start, segment.t_end)))
        if segment.kind == "static":
            rate[rows] = 0.0
        elif segment.kind == "rate":
            held = agreeing_rate(recording, segment)
            rate[rows] = np.nan if held is None else held
    return replace(motion, rate=rate, acceleration=0.0 * rate, axes=None)
