"""A bias that depends on attitude in Earth's magnetic field."""

from dataclasses import dataclass, field

import numpy as np

from schemas.recording import Recording
from tasks.model.term import GYRO_FIRST, Column, Inputs, Parameter, Term, crossed, each_pair
from tasks.model.terms.axes import level_axes
from tasks.motion.whole import Motion

EQUATOR = 31.2e-6  # T, Earth's dipole field at the equator
SOMEWHERE = 45.0  # deg, the latitude taken where none is stated; the equation says so
AZIMUTHS = tuple(np.radians([0.0, 45.0, 90.0, 135.0]).tolist())  # of magnetic north, unknown


@dataclass(frozen=True)
class MagneticSensitivity(Term):
    """Gyros read M·B; B of Earth's dipole, B₀·(cos φ·north − 2·sin φ·up).

    shapes: azimuth of magnetic north, from North to East, or from the table's y axis where the
    heading is not known. latitude: rad.
    """

    latitude: float = field(kw_only=True)

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        return crossed(GYRO_FIRST, self._field(motion))

    def _field(self, motion: Motion) -> np.ndarray:
        """(n, 3) T in the body."""
        level = level_axes(motion)
        if level is None:
            return np.full_like(motion.up, np.nan)
        east, north = level
        magnetic = np.cos(self.at[0]) * north + np.sin(self.at[0]) * east
        level_part, vertical = np.cos(self.latitude), -2.0 * np.sin(self.latitude)
        return EQUATOR * (level_part * magnetic + vertical * motion.up)


def magnetic_sensitivity(latitude: float | None, azimuth: float = 0.0) -> MagneticSensitivity:
    """At a latitude (rad), and with magnetic north at an azimuth (rad)."""
    taken = np.radians(SOMEWHERE) if latitude is None else latitude
    unsure = f"; φ = {SOMEWHERE:.0f} deg taken, latitude not told" if latitude is None else ""
    return MagneticSensitivity(
        "magnetic_sensitivity", "environment", "sensor",
        f"ω′ᵢ = Σⱼ M_ij·Bⱼ, B = B₀·(cos φ·north − 2·sin φ·up){unsure}",
        "IEEE Std 952; Earth's field as a dipole",
        each_pair("M", ("(deg/s)/mT", "(rad/s)/T", 20.0)),
        (Parameter("azimuth", "ψ", "deg", "rad", (-np.pi, np.pi)),), (azimuth,),
        latitude=float(taken),
        confused_with=("earth_rotation", "gyro_g2_sensitivity"),
    )  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Where a level direction is known; at several azimuths where north is not."""
    if level_axes(motion) is None:
        return ()
    degrees = recording.manifest.station.latitude_deg
    latitude = None if degrees is None else float(np.radians(degrees))
    azimuths = AZIMUTHS[:1] if np.isfinite(motion.north).any() else AZIMUTHS
    return tuple(magnetic_sensitivity(latitude, azimuth) for azimuth in azimuths)
