"""What the place adds: Earth's rotation, and a gravity that is not the one told."""

from dataclasses import dataclass, field

import numpy as np

from schemas.recording import Recording
from tasks.model.parameters import DEG, one
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

    def freed(self) -> Term:
        """The same with its size free: its vertical part, the northward one in proportion."""
        return EarthAsSeen(
            "earth_rotation", "site", "input", "ω = ω_table + Ω·(up + cot φ·north)",
            "rigid-body kinematics", one("vertical_rate", "Ω", ("deg/h", 3600.0 * DEG, 1e-3)),
            latitude=self.latitude,
        )  # fmt: skip


@dataclass(frozen=True)
class EarthAsSeen(Term):
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
        title=("Earth's rotation", "地球自转角速度"),
        confused_with=("magnetic_sensitivity", "gyro_g2_sensitivity"),
        separated_by=(
            "the twelve positions again at two headings of the table 90 deg apart: Earth's rate "
            "keeps its size and follows true north",
            "转台基座转过90°前后各做一次十二位置试验：地球自转分量大小已知且随真北方向变化",
        ),
    )  # fmt: skip


@dataclass(frozen=True)
class GravityValue(Term):
    """Local gravity larger than told. Scale factors soak it up wherever gravity is all there is."""

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        return Inputs(inputs.rate, inputs.force + values[0] * motion.up)


GRAVITY_VALUE = GravityValue(
    "gravity_value", "site", "input", "f = (g + δg)·up",
    "definition of specific force; IEEE Std 1293", one("difference", "δg", ("m/s2", 1.0, 0.05)),
    title=("local gravity differs from the value told", "当地重力加速度值与给定值不符"),
    confused_with=("temperature_scale", "accel_nonlinearity"),
    separated_by=(
        "local gravity by a gravimeter or a gravity map; or turns on a known lever arm, whose "
        "acceleration does not depend on gravity",
        "用重力仪或重力图给出当地重力加速度；或在已知半径上匀速旋转，其向心加速度与重力无关",
    ),
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """The site's effects; without a latitude none of Earth's rotation."""
    latitude = recording.manifest.station.latitude_deg
    earth = () if latitude is None else (earth_rotation(float(np.radians(latitude))),)
    return (*earth, GRAVITY_VALUE)
