"""Empirical tilts of the unit: near an angle of the table, where it has play, or its drive has."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product

import numpy as np

from tasks.explain.explanation import UNNAMED
from tasks.explain.search.empirical_terms import EmpiricalTilt
from tasks.model.hysteresis_states import last_sign
from tasks.model.parameters import G
from tasks.model.term import Parameter, Term
from tasks.model.terms.axes import turned_by
from tasks.motion.small_rotation import with_small_rotation
from tasks.motion.whole import Motion
from tasks.words import message

WIDTH = 0.4  # rad of the table's angle
CENTRES = np.arange(0.0, 2.0 * np.pi, np.pi / 6.0)
GIVES_WAY = 1.0  # m/s² of specific force, a tenth of gravity, over which it tips to the other side
DIAGONALS = tuple((1.0, y, z) for y, z in product((1.0, -1.0), repeat=2))  # opposites are the same
STANDS = 0.02  # of the largest rate of an axis: slower is no turn to either side
PARAMETERS = tuple(Parameter(f"lean_{axis}", "lean", "rad", 1.0, (-0.01, 0.01)) for axis in "xyz")


def leans(axis: int) -> Iterator[Term]:
    """Tilts near some angles of a table axis."""
    for centre in CENTRES:
        degrees = f"{np.degrees(centre):.0f}"
        yield EmpiricalTilt(
            UNNAMED, UNNAMED, "motion", f"the unit leans near θ{axis + 1} = {degrees}°",
            "empirical", PARAMETERS,
            own_title=message("explain-lean", axis=axis + 1, angle=degrees),
            regressor=partial(_bump, axis, centre),
        )  # fmt: skip


def _bump(axis: int, centre: float, motion: Motion) -> np.ndarray:
    assert motion.axes is not None
    return np.asarray(np.exp((np.cos(motion.axes.angles[:, axis] - centre) - 1.0) / WIDTH**2))


@dataclass(frozen=True)
class Tip(Term):
    """A tilt of one size to either side, as gravity pulls along a direction (3,) or against it: of
    what has play, where `structural_compliance` bends in proportion.

    It snaps over: the turn itself, of milliseconds, is not in it.
    """

    direction: np.ndarray = field(kw_only=True)

    @classmethod
    def along(cls, direction: np.ndarray) -> "Tip":
        """For a direction of any length."""
        return cls(
            UNNAMED, UNNAMED, "motion", "φ = φ₀·tanh(g·up·d / 1 m/s²)", "empirical", PARAMETERS,
            direction=direction,
        ).towards(direction)  # fmt: skip

    def towards(self, direction: np.ndarray) -> "Tip":
        """The same term with another direction."""
        unit = direction / np.linalg.norm(direction)
        parts = ", ".join(f"{round(part, 1) + 0.0:+.1f}" for part in unit.tolist())
        title = message("explain-tip", side=parts.replace("-", "−"))
        return replace(self, own_title=title, direction=unit)

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        side = np.tanh(G * motion.up @ self.direction / GIVES_WAY)
        return turned_by(motion, side[:, None] * values, None, motion.rate)


def tips() -> Iterator[Tip]:
    """Along the four diagonals: where the unit rests level, no more of a direction shows than the
    signs of its components.
    """
    yield from (Tip.along(np.array(diagonal)) for diagonal in DIAGONALS)


@dataclass(frozen=True)
class LostMotion(Term):
    """The unit lags behind the encoder by one angle, whichever way a table axis turns last: a gear
    or a coupling between them has play. The short stop at each reversal is not in it.
    """

    axis: int = field(kw_only=True)

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        axes = motion.axes
        assert axes is not None
        speed = axes.speeds[:, self.axis]
        way = last_sign(speed, STANDS * float(np.nanmax(np.abs(speed))))
        return with_small_rotation(
            motion, axes.directions[:, self.axis], -values[0] * way, np.zeros_like(way),
            axes.outside(self.axis),
        )  # fmt: skip


def lost_motion(axis: int) -> LostMotion:
    """The play in the drive of a table axis, counted from 0."""
    return LostMotion(
        UNNAMED, UNNAMED, "motion", f"θ{axis + 1} = θ_enc − h·(way it turned last)", "empirical",
        (Parameter("half", "h", "rad", 1.0, (-0.01, 0.01)),),
        own_title=message("explain-lost-motion", axis=axis + 1), axis=axis,
    )  # fmt: skip
