"""Earth's rotation in the table's own directions, where the site is unknown."""

from dataclasses import dataclass

import numpy as np

from schemas.recording import Recording
from tasks.model.parameters import single
from tasks.model.term import Inputs, Term
from tasks.model.terms.axes import level_axes
from tasks.motion.whole import Motion

NAME = "ground_rotation"


@dataclass(frozen=True)
class GroundRotation(Term):
    """A rate (3,) of the ground: along the table's x and y axes with all angles zero, and up."""

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        level = level_axes(motion)
        rate = values[2] * motion.up
        if level is not None:
            rate = rate + values[0] * level[0] + values[1] * level[1]
        return Inputs(inputs.rate + rate, inputs.force)


PRINTED = ("deg/h", "rad/s", 1e-3)
GROUND_ROTATION = GroundRotation(
    NAME, "site", "input", "ω = ω_table + Ω_x·x + Ω_y·y + Ω_z·up", "rigid-body kinematics",
    single("x", "Ω_x", PRINTED) + single("y", "Ω_y", PRINTED) + single("up", "Ω_z", PRINTED),
)  # fmt: skip


def ground_rotation(recording: Recording) -> tuple[Term, ...]:
    """The term of a run whose manifest omits latitude and heading."""
    station = recording.manifest.station
    if station.latitude_deg is not None and station.heading_deg is not None:
        return ()
    return (GROUND_ROTATION,)
