"""Where the sensors sit: the lever arm from the rotation axes."""

from dataclasses import dataclass

import numpy as np

from schemas.recording import AXES
from tasks.model.term import Inputs, Parameter, Term
from tasks.motion.whole import Motion


@dataclass(frozen=True)
class LeverArm(Term):
    """The accelerometers at r, one common point, from where the rotation axes meet."""

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        turning = np.cross(motion.rate, np.cross(motion.rate, values))
        return Inputs(inputs.rate, inputs.force + np.cross(motion.acceleration, values) + turning)


LEVER_ARM = LeverArm(
    "lever_arm", "geometry", "input", "f = f₀ + ω̇×r + ω×(ω×r)", "rigid-body kinematics",
    tuple(Parameter(a, f"r_{a}", "m", 1.0, (-0.3, 0.3)) for a in AXES),
)  # fmt: skip
