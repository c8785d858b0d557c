"""Empirical terms: readings or attitude that follow a regressor, with free factors."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product

import numpy as np

from tasks.explain.channels import EVERY
from tasks.explain.explanation import UNNAMED
from tasks.model.hysteresis_states import last_sign
from tasks.model.parameters import G
from tasks.model.term import Column, Inputs, Parameter, SensorTerm, Term
from tasks.model.terms.axes import turned_by
from tasks.motion.small_rotation import with_small_rotation
from tasks.motion.whole import Motion
from tasks.words import Sayable, message

LETTERS = "xyzxyz"
SLOW_DRIFT = message("explain-slow-drift")
READINGS = "rad/s", "m/s2"  # units of a gyro and of an accelerometer
# Chi-squared that a drift of scale factors must gain over one of biases, which is the same in a
# channel whose input does not change.
NEEDS_MOTION = 20.0
Regressors = Callable[[Motion, Inputs, int], Sequence[np.ndarray]]
WIDTH = 0.4  # rad of the table's angle
CENTRES = np.arange(0.0, 2.0 * np.pi, np.pi / 6.0)
TIPPING_FORCE = (
    1.0  # m/s² of specific force, a tenth of gravity, over which it tips to the other side
)
DIAGONALS = tuple((1.0, y, z) for y, z in product((1.0, -1.0), repeat=2))  # opposites are the same
STANDS = 0.02  # of the largest rate of an axis: slower is no turn to either side
PARAMETERS = tuple(Parameter(f"lean_{axis}", "lean", "rad", "rad", (-0.01, 0.01)) for axis in "xyz")


@dataclass(frozen=True)
class EmpiricalTilt(Term):
    """The unit is turned by a small rotation vector in proportion to a regressor."""

    regressor: Callable[[Motion], np.ndarray] = field(kw_only=True)

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        """Readings of an ideal unit per unit of each component, to which they are linear."""
        regressor = np.nan_to_num(self.regressor(motion))
        slope = np.gradient(regressor, motion.t)
        found = []
        for axis in range(3):
            j, k = (axis + 1) % 3, (axis + 2) % 3
            rate, force = inputs.rate, inputs.force
            found.append({
                axis: slope, j: regressor * rate[:, k], k: -regressor * rate[:, j],
                3 + j: regressor * force[:, k], 3 + k: -regressor * force[:, j],
            })  # fmt: skip
        return tuple(found)

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        regressor = np.nan_to_num(self.regressor(motion))
        slope = np.gradient(regressor, motion.t)
        for axis in range(3):
            if values[axis]:
                angle, speed = values[axis] * regressor, values[axis] * slope
                motion = with_small_rotation(motion, np.eye(3)[axis], angle, speed, motion.rate)
        return motion


def regression_term(
    key: str,
    title: Sayable,
    channels: tuple[int, ...],
    number: int,
    regressors: Regressors,
    shared: bool = False,
    units: tuple[str, str] = READINGS,
) -> SensorTerm:
    """Readings of some channels follow `number` regressors, each channel by its own factors.

    regressors: of motion, inputs and the channel, each (n,); shared: the same for every channel.
    units: of a gyro's factor and of an accelerometer's.
    """

    def columns(motion: Motion, inputs: Inputs, at: tuple[float, ...]) -> tuple[Column, ...]:
        first = [np.nan_to_num(each) for each in regressors(motion, inputs, channels[0])]
        own = [
            first
            if shared or channel == channels[0]
            else [np.nan_to_num(each) for each in regressors(motion, inputs, channel)]
            for channel in channels
        ]
        return tuple(
            {channel: each} for channel, some in zip(channels, own, strict=True) for each in some
        )

    return SensorTerm(
        UNNAMED, UNNAMED, "sensor", f"reading += c·{key}", "empirical",
        _factors(key, channels, number, units), own_title=title, reads=columns,
    )  # fmt: skip


def per(regressor: str) -> tuple[str, str]:
    """The units of factors of a regressor in that unit: readings over it."""
    under = f"({regressor})" if "/" in regressor and regressor[0] != "(" else regressor
    gyro, accel = ("1" if regressor == own else f"({own})/{under}" for own in READINGS)
    return gyro, accel


def _factors(
    key: str, channels: tuple[int, ...], number: int, units: tuple[str, str] = READINGS
) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(
            f"{'gyro' if c < 3 else 'accel'}_{LETTERS[c]}" + (f"_{k + 1}" if number > 1 else ""),
            key, units[c >= 3], units[c >= 3], (-1.0, 1.0),
        )
        for c in channels for k in range(number)
    )  # fmt: skip


@dataclass(frozen=True)
class Sinusoid(SensorTerm):
    """An oscillation of constant amplitude; shapes: the period."""

    def shaped(self, at: tuple[float, ...]) -> "Sinusoid":
        """The sinusoid of another period."""
        return replace(self, at=at, own_title=message("explain-wave", period=f"{at[0]:.3g}"))


def sinusoid(channels: tuple[int, ...], period: float = 100.0) -> Sinusoid:
    """A sinusoid in some channels, at any phase in each."""

    def columns(motion: Motion, inputs: Inputs, at: tuple[float, ...]) -> tuple[Column, ...]:
        phase = 2.0 * np.pi * motion.t / at[0]
        pair = (np.sin(phase), np.cos(phase))
        return tuple({channel: part} for channel in channels for part in pair)

    return Sinusoid(
        UNNAMED, UNNAMED, "sensor", "reading += a·sin(2πt/P) + b·cos(2πt/P)", "empirical",
        _factors("a wave", channels, 2), (Parameter("period", "P", "s", "s", (0.5, 2000.0)),),
        reads=columns,
    ).shaped((period,))  # fmt: skip


def slow_drift(walk: Term | None, waves: int) -> SensorTerm:
    """Cosines of half a period and more over the run, in every channel.

    walk: the catalogue's term whose name and texts it takes; without one it is `unnamed`.
    """

    def cosines(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
        return slow_waves(motion, waves)

    drift = regression_term("slow waves", SLOW_DRIFT, EVERY, waves, cosines, True)
    if walk is None:
        return drift
    same = ("name", "family", "equation", "source", "confused_with", "time_course", "own_title")
    return replace(drift, **{name: getattr(walk, name) for name in same})


def scale_factor_drift(waves: int) -> SensorTerm:
    """Scale factors that change by cosines of half a period and more over the run."""

    def scaled(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
        own = (inputs.rate if channel < 3 else inputs.force)[:, channel % 3]
        return [own * wave for wave in slow_waves(motion, waves)]

    title = message("explain-scale-factor-drift")
    drift = regression_term("input·slow waves", title, EVERY, waves, scaled, units=("1", "1"))
    return replace(drift, rarity=NEEDS_MOTION)


def slow_waves(motion: Motion, waves: int) -> list[np.ndarray]:
    """cos(πks) for k = 1 to waves, of the share s of the run that has passed."""
    share = (motion.t - motion.t[0]) / (motion.t[-1] - motion.t[0])
    first = np.cos(np.pi * share)
    found = [np.ones_like(first), first]
    while len(found) <= waves:  # Chebyshev's recurrence: a cosine costs twenty products
        found.append(2.0 * first * found[-1] - found[-2])
    return found[1 : waves + 1]


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
        side = np.tanh(G * motion.up @ self.direction / TIPPING_FORCE)
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
        (Parameter("half", "h", "rad", "rad", (-0.01, 0.01)),),
        own_title=message("explain-lost-motion", axis=axis + 1), axis=axis,
    )  # fmt: skip
