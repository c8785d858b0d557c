"""Geometry of the table's axes: base not level, axes not square, an axis that wobbles."""

from dataclasses import dataclass, field, replace

import numpy as np

from schemas.recording import Recording
from tasks.model.term import Parameter, Term, single
from tasks.motion.table import TableAxes
from tasks.motion.whole import Motion, with_small_rotation

PARALLEL = 0.1  # sine of the angle between axes below which they have no common normal
UPRIGHT = 0.7  # share of the first axis along the vertical above which it is a vertical one


def turned_by(
    motion: Motion, turn: np.ndarray, change: np.ndarray | None, outside: np.ndarray | None
) -> Motion:
    """The motion with a small rotation vector more.

    turn: (n, 3) rad in the body, change: (n, 3) rad/s, the rate that it adds, if any; outside:
    (n, 3) rad/s of what turns outside of it, if anything does.
    """
    still = np.zeros(len(motion.t))
    carried = np.zeros_like(turn) if outside is None else outside
    moved = with_small_rotation(motion, turn, still + 1.0, still, carried)
    return moved if change is None else replace(moved, rate=moved.rate + change)


def level_axes(motion: Motion) -> tuple[np.ndarray, np.ndarray] | None:
    """East and North in the body, (n, 3) each; None if no level direction is known.

    If the heading is unknown, the table's own y axis represents North.
    """
    north = motion.north
    if not np.isfinite(north).any():
        if motion.axes is None:
            return None
        north = motion.axes.base
    return np.cross(north, motion.up), north


@dataclass(frozen=True)
class AxisTilt(Term):
    """The base turned by a small rotation vector that is level."""

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        level = level_axes(motion)
        if level is None:
            return motion
        return turned_by(motion, values[0] * level[0] + values[1] * level[1], None, None)


AXIS_TILT = AxisTilt(
    "axis_tilt", "geometry", "motion", "up′ = up − φ×up, φ = φ_E·East + φ_N·North",
    "IEEE Std 1554; small rotation",
    single("east", "φ_E", ("deg", "rad", 0.02)) + single("north", "φ_N", ("deg", "rad", 0.02)),
    confused_with=("axis_wobble", "axis_nonorthogonality", "remount_misalignment"),
)  # fmt: skip


@dataclass(frozen=True)
class AxisNonorthogonality(Term):
    """Neighbouring axes not square: at each joint a small turn about their common normal."""

    joints: tuple[int, ...] = field(kw_only=True)  # the outer axis of each, from 0

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        axes = motion.axes
        if axes is None:
            return motion
        for k, angle in zip(self.joints, values, strict=True):
            normal = np.cross(axes.directions[:, k], axes.directions[:, k + 1])
            normal /= np.linalg.norm(normal, axis=1)[:, None]
            motion = turned_by(motion, angle * normal, None, axes.outside(k + 1))
        return motion


def axis_nonorthogonality(joints: tuple[int, ...]) -> AxisNonorthogonality:
    """An angle for each joint, between table axes k and k + 1, counted from 1."""
    return AxisNonorthogonality(
        "axis_nonorthogonality", "geometry", "motion", "φₖ = δₖ·(aₖ×aₖ₊₁)/|aₖ×aₖ₊₁| between axes",
        "IEEE Std 1554; small rotation",
        tuple(
            p for k in joints for p in single(f"angle_{k + 1}", f"δ_{k + 1}", ("deg", "rad", 0.02))
        ),
        joints=joints,
        confused_with=("axis_tilt", "axis_wobble", "remount_misalignment"),
    )  # fmt: skip


@dataclass(frozen=True)
class AxisWobble(Term):
    """The upright first axis leans to East and North as sine and cosine of m·θ₀."""

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        level, axes = level_axes(motion), motion.axes
        if level is None or axes is None:
            return motion
        m = self.at[0]
        sin, cos = np.sin(m * axes.angles[:, 0]), np.cos(m * axes.angles[:, 0])
        speed = m * axes.speeds[:, 0]
        turn, change = np.zeros_like(motion.up), np.zeros_like(motion.up)
        for direction, (s, c) in zip(level, values.reshape(2, 2), strict=True):
            turn += (s * sin + c * cos)[:, None] * direction
            change += ((s * cos - c * sin) * speed)[:, None] * direction
        return turned_by(motion, turn, change, None)


def axis_wobble(per_turn: int) -> AxisWobble:
    """A wobble of the first axis once or twice a turn."""
    return AxisWobble(
        "axis_wobble", "geometry", "motion",
        "φ = Σ (s·sin mθ + c·cos mθ)·East, North; rate φ̇ besides", "IEEE Std 1554",
        tuple(
            p for side in ("east", "north") for part in ("sin", "cos")
            for p in single(f"{side}_{part}", f"φ_{side[0].upper()},{part}", ("deg", "rad", 0.01))
        ),
        (Parameter("per_turn", "m", "1", "1", (1.0, 2.0)),), (float(per_turn),),
        confused_with=("encoder_eccentricity", "axis_tilt", "rate_ripple"),
    )  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """A tilt where a level direction is known; the rest where the table's axes are.

    The vertical of a room in which a body is tracked is a nuisance of `reference_frame`.
    """
    level = level_axes(motion) is not None and motion.tracking is None
    tilt = (AXIS_TILT,) if level else ()
    axes = motion.axes
    if axes is None:
        return tilt
    joints = _joints(axes)
    square = (axis_nonorthogonality(joints),) if joints else ()
    upright = abs(_known_mean(np.abs((axes.directions[:, 0] * motion.up).sum(axis=1)))) > UPRIGHT
    wobbles = (axis_wobble(1), axis_wobble(2)) if upright and axes.speeds[:, 0].any() else ()
    return (*tilt, *square, *wobbles)


def _joints(axes: TableAxes) -> tuple[int, ...]:
    """The axes that are not parallel to the next one inside them."""
    normals = np.cross(axes.directions[:, :-1], axes.directions[:, 1:])
    sines = np.linalg.norm(normals, axis=2)
    return tuple(k for k in range(sines.shape[1]) if _known_mean(sines[:, k]) > PARALLEL)


def _known_mean(signal: np.ndarray) -> float:
    known = signal[np.isfinite(signal)]
    return float(known.mean()) if len(known) else 0.0
