"""Influences of the site: Earth's rotation, and a gravity other than the stated one."""

from dataclasses import dataclass, field

import numpy as np

from schemas.recording import Recording
from tasks.model.term import Inputs, Term, single
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

    def with_free_size(self) -> Term:
        """The same with its size free: its vertical part, the northward one in proportion."""
        return EstimatedEarthRotation(
            "earth_rotation", "site", "input", "ω = ω_table + Ω·(up + cot φ·north)",
            "rigid-body kinematics", single("vertical_rate", "Ω", ("deg/h", "rad/s", 1e-3)),
            latitude=self.latitude,
        )  # fmt: skip


@dataclass(frozen=True)
class EstimatedEarthRotation(Term):
    """A rotation of the ground about Earth's axis, as large as the data have it."""

    latitude: float = field(kw_only=True)  # rad

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        level = np.where(np.isfinite(motion.north), motion.north, 0.0)
        earth = motion.up + level / np.tan(self.latitude)
        return Inputs(inputs.rate + values[0] * earth, inputs.force)


def earth_rotation(latitude: float) -> EarthRotation:
    """Earth's rotation at a known latitude, rad."""
    return EarthRotation(
        "earth_rotation", "site", "input", "ω = ω_table + ωe·(cos φ·north + sin φ·up)",
        "WGS 84; JJF 2003-2022 is silent", (), latitude=latitude,
        confused_with=("magnetic_sensitivity", "gyro_g2_sensitivity"),
    )  # fmt: skip


@dataclass(frozen=True)
class GravityValue(Term):
    """Local gravity larger than stated; scale factors absorb it where gravity is the only force."""

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        return Inputs(inputs.rate, inputs.force + values[0] * motion.up)


GRAVITY_VALUE = GravityValue(
    "gravity_value", "site", "input", "f = (g + δg)·up",
    "definition of specific force; IEEE Std 1293",
    single("difference", "δg", ("m/s2", "m/s2", 0.05)),
    confused_with=("temperature_scale", "accel_nonlinearity"),
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """The site's effects; without a latitude none of Earth's rotation."""
    latitude = recording.manifest.station.latitude_deg
    earth = () if latitude is None else (earth_rotation(float(np.radians(latitude))),)
    return (*earth, GRAVITY_VALUE)
