"""Geometry of sensors and fixture: lever arms, a compliant fixture, re-fixing."""

from dataclasses import dataclass

import numpy as np

from schemas.recording import AXES, Recording
from tasks.model.term import OFF_DIAGONAL, G, Inputs, Parameter, Term, each_axis, each_pair, turned
from tasks.model.terms.axes import turned_by
from tasks.motion.whole import Motion
from tasks.words import message


@dataclass(frozen=True)
class LeverArm(Term):
    """The accelerometers at r, one common point, relative to the intersection of the rotation axes.

    r is in the axes of the reported motion: for a tracked body, its own.
    """

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        turning = np.cross(motion.rate, np.cross(motion.rate, values))
        return Inputs(inputs.rate, inputs.force + np.cross(motion.acceleration, values) + turning)


LEVER_ARM = LeverArm(
    "lever_arm", "geometry", "input", "f = f₀ + ω̇×r + ω×(ω×r)", "rigid-body kinematics",
    each_axis("r", "r", ("m", "m", 0.3)),
    confused_with=("size_effect", "structural_compliance"),
)  # fmt: skip


@dataclass(frozen=True)
class SizeEffect(Term):
    """Each accelerometer at its own place; all at one place is the lever arm."""

    def felt(self, motion: Motion, inputs: Inputs, values: np.ndarray) -> Inputs:
        places = values.reshape(3, 3)  # accelerometer, component
        w, a = motion.rate, motion.acceleration
        along = w @ places.T  # ω·rᵢ
        square = (w**2).sum(axis=1)[:, None]
        force = inputs.force + w * along - square * np.diag(places)
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            force[:, i] += a[:, j] * places[i, k] - a[:, k] * places[i, j]
        return Inputs(inputs.rate, force)


SIZE_EFFECT = SizeEffect(
    "size_effect", "geometry", "input", "fᵢ = f₀ᵢ + [ω̇×rᵢ + ω×(ω×rᵢ)]ᵢ",
    "Titterton and Weston, Strapdown Inertial Navigation Technology, 2004; IEEE Std 836",
    each_pair("r", ("m", "m", 0.3)),
    confused_with=("lever_arm", "structural_compliance"),
)  # fmt: skip


@dataclass(frozen=True)
class StructuralCompliance(Term):
    """The fixture bends with the square of the rates: a small rotation φ = C·(ωx², ωy², ωz²)."""

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        bend = np.zeros((3, 3))
        for (i, j), value in zip(OFF_DIAGONAL, values, strict=True):
            bend[i, j] = value
        turn = motion.rate**2 @ bend.T
        change = 2.0 * (motion.rate * motion.acceleration) @ bend.T
        return turned_by(motion, turn, change, motion.rate)


STRUCTURAL_COMPLIANCE = StructuralCompliance(
    "structural_compliance", "geometry", "motion",
    "φᵢ = Σⱼ C_ij·ωⱼ², j ≠ i; v′ = v − φ×v for rate and force",
    "small rotation of an elastic fixture; IEEE Std 836",
    each_pair("C", ("rad/(rad/s)2", "rad/(rad/s)2", 1e-3), OFF_DIAGONAL),
    confused_with=("lever_arm", "size_effect", "gyro_scale_nonlinearity"),
)  # fmt: skip


@dataclass(frozen=True)
class Sag(Term):
    """The fixture hangs down under its load: a small rotation φ = C·f of the body's force f."""

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        force = G * motion.up
        turn = force @ values.reshape(3, 3).T
        change = np.cross(force, motion.rate) @ values.reshape(3, 3).T
        return turned_by(motion, turn, change, motion.rate)


SAG = Sag(
    "structural_compliance", "geometry", "motion",
    "φᵢ = Σⱼ C_ij·fⱼ; v′ = v − φ×v for rate and force",
    "small rotation of an elastic fixture; IEEE Std 836",
    each_pair("C", ("deg/g", "rad/(m/s2)", 0.005 / G)),
    own_title=message("effect-structural-compliance.sag"),
    confused_with=("axis_wobble", "remount_misalignment", "accel_nonlinearity"),
)  # fmt: skip


@dataclass(frozen=True)
class RemountMisalignment(Term):
    """After each re-fixing a constant small rotation against the first fixing."""

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        fixing = motion.recorded["fixing"]
        turn = np.zeros_like(motion.up)
        for number, vector in zip(_later_fixings(fixing), values.reshape(-1, 3), strict=True):
            turn[fixing == number] = vector
        return turned_by(motion, turn, None, motion.rate)


def _later_fixings(fixing: np.ndarray) -> np.ndarray:
    """The numbers of the fixings but the first, which the cross couplings absorb."""
    return np.unique(fixing[np.isfinite(fixing)])[1:]


def remount_misalignment(fixing: np.ndarray) -> RemountMisalignment:
    """A rotation vector for each fixing (n,) beyond the first: x_1, y_1, z_1, x_2 …"""
    return RemountMisalignment(
        "remount_misalignment", "geometry", "motion", "v′ = v − φₙ×v after re-fixing n",
        "JJF 2003-2022 is silent; small rotation",
        tuple(
            Parameter(f"{a}_{number:.0f}", f"φ_{a}{number:.0f}", "deg", "rad", (-0.02, 0.02))
            for number in _later_fixings(fixing) for a in AXES
        ),
        confused_with=("axis_nonorthogonality", "axis_tilt", "bias_step"),
    )  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Lever arms and compliance for rotation; re-fixing for a unit re-fixed on a table.

    Without encoders the attitude is that of the labels, and every position a separate fixing.
    Positions of a tracked body, differentiated twice, do not resolve three places millimetres
    apart.
    """
    places = (LEVER_ARM, SIZE_EFFECT) if motion.tracking is None else (LEVER_ARM,)
    turning = (*places, STRUCTURAL_COMPLIANCE, SAG) if turned(motion) else ()
    fixing = motion.recorded.get("fixing", np.zeros(1))
    refixed = motion.axes is not None and len(_later_fixings(fixing)) > 0
    again = (remount_misalignment(fixing),) if refixed else ()
    return (*turning, *again)
