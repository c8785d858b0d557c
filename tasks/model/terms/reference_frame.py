"""Frames of a tracked body: the vertical of the tracking system is not exactly upright.

Every recording of a tracked body has some of it: it is fitted in every model of one. So is a turn
of the tracked body against the unit, which the standard's matrices of both triads absorb whole.
"""

from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import Recording
from tasks.model.term import Term, single
from tasks.model.terms.axes import level_axes
from tasks.motion.whole import Motion, crossed


@dataclass(frozen=True)
class ReferenceFrame(Term):
    """The true vertical is tilted in the tracking system's room by a constant level vector.

    Positions are measured in that room: the motion of the body is unchanged. A rotation between the
    tracked body and the unit is not a parameter of this term, and cannot be distinguished from the
    standard's cross coupling: a remark states how far the gyros' matrix is rotated as a whole.
    """

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        level = level_axes(motion)
        if level is None:
            return motion
        lean = values[0] * level[0] + values[1] * level[1]
        return replace(motion, up=motion.up - crossed(lean, motion.up))


REFERENCE_FRAME = ReferenceFrame(
    "reference_frame", "table", "motion", "up′ = up − ψ×up, ψ = ψ_E·East + ψ_N·North",
    "small rotation; IEEE Std 1554",
    single("tilt_east", "ψ_E", ("deg", "rad", 0.1))
    + single("tilt_north", "ψ_N", ("deg", "rad", 0.1)),
    confused_with=("lever_arm",),
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Of poses alone; a table's axes have terms of their own."""
    return () if motion.tracking is None else (REFERENCE_FRAME,)
