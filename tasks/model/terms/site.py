"""What the place adds: Earth's rotation."""

from dataclasses import dataclass, field

import numpy as np

from tasks.model.term import Inputs, Term
from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import Motion


@dataclass(frozen=True)
class EarthRotation(Term):
    """Earth's rate in the gyros' input, with no free parameter.

    Where north is not known in the body only the vertical part is added.
    """

    latitude: float = field(kw_only=True)  # rad

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        level = np.where(np.isfinite(motion.north), motion.north, 0.0)
        earth = np.cos(self.latitude) * level + np.sin(self.latitude) * motion.up
        return Inputs(inputs.rate + EARTH_RATE * earth, inputs.force)


def earth_rotation(latitude: float) -> EarthRotation:
    """Earth's rotation at a known latitude, rad."""
    return EarthRotation(
        "earth_rotation", "site", "input", "ω = ω_table + ωe·(cos φ·north + sin φ·up)",
        "WGS 84; JJF 2003-2022 is silent", (), latitude=latitude,
    )  # fmt: skip
