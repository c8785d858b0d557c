"""An empirical basis for residuals that no catalogued physics fits.

Each is a term named `unnamed` whose title describes its regressors: relaxations after moves, lags,
harmonics of the table's angle, products and powers, sinusoids, and everything recorded.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from types import MappingProxyType

import numpy as np

from tasks.explain.explanation import ACCELS, EVERY, GYROS, UNNAMED
from tasks.model.term import Column, G, Inputs, Parameter, SensorTerm, Term
from tasks.model.terms.axes import turned_by
from tasks.model.terms.hysteresis import last_sign
from tasks.motion.samples import first_order_lag
from tasks.motion.whole import Motion, with_small_rotation
from tasks.words import Sayable, message

# Empirical terms: readings or attitude that follow a regressor, with free factors.

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
        return tuple(tilt_columns(self.regressor(motion), motion, inputs))

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        regressor = np.nan_to_num(self.regressor(motion))
        slope = np.gradient(regressor, motion.t)
        for axis in range(3):
            if values[axis]:
                angle, speed = values[axis] * regressor, values[axis] * slope
                motion = with_small_rotation(motion, np.eye(3)[axis], angle, speed, motion.rate)
        return motion


def tilt_columns(regressor: np.ndarray, motion: Motion, inputs: Inputs) -> Iterator[Column]:
    """Readings of an ideal unit per rad of each component of a turn by a regressor (n,)."""
    known = np.nan_to_num(regressor)
    slope = np.gradient(known, motion.t)
    rate, force = inputs.rate, inputs.force
    for axis in range(3):
        j, k = others(axis)
        yield {
            axis: slope, j: known * rate[:, k], k: -known * rate[:, j],
            3 + j: known * force[:, k], 3 + k: -known * force[:, j],
        }  # fmt: skip


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


ONE_TURN = 2.0 * np.pi  # rad: an axis that turned further has harmonics
RELAXATIONS = (1.5, 4.0, 8.0, 16.0, 40.0)  # s
LAGS = (3.0, 7.0, 18.0, 45.0, 120.0)  # s
HARMONICS = range(1, 7)
SINUSOIDS = 2  # periods that are tried for each set of channels
RECORDED = {"humidity": "%", "pressure": "hPa", "air_temperature": "K"}  # with their units
RATE, RATE_2, TURNING, FORCE, FORCE_2 = "rad/s", "(rad/s)^2", "rad/s^2", "m/s2", "(m/s2)^2"
Signal = Callable[[Motion, Inputs, int], np.ndarray]
LeftOut = Mapping[str, tuple[int, ...]]
NOTHING: LeftOut = MappingProxyType({})
TURNING_UP = 0.02  # of a unit vector in a second: gravity's direction changes
AT_REST = 1e-3  # rad/s: slower is not a motion
MAX_MOVE = 20.0  # s; what turns longer is a run


def time_since(motion: Motion, events: np.ndarray) -> np.ndarray:
    """(n,) s since the last event (n,) bool was over; infinite before the first."""
    rows = np.flatnonzero(np.diff(events.astype(int)) == -1) + 1
    if not len(rows):
        return np.full(len(motion.t), np.inf)
    last = np.searchsorted(rows, np.arange(len(motion.t)), "right") - 1
    elapsed = motion.t - motion.t[rows[np.maximum(last, 0)]]
    return np.where(last >= 0, elapsed, np.inf)


def gravity_turns(motion: Motion) -> np.ndarray:
    """(n,) bool: gravity's direction in the unit changes. A turn about a level axis is one move."""
    up = np.nan_to_num(motion.up)
    speed = np.linalg.norm(np.gradient(up, motion.interval, axis=0), axis=1)
    return np.asarray(speed > TURNING_UP)


def turning(motion: Motion) -> np.ndarray:
    """(n,) bool: the unit turns, in whatever way."""
    return np.asarray(np.linalg.norm(np.nan_to_num(motion.rate), axis=1) > AT_REST)


def repositioning(motion: Motion) -> np.ndarray:
    """(n,) bool: the unit turns from one rest to another, without a steady turn between."""
    moving = turning(motion)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], moving.astype(int), [0]])))
    steady = motion.recorded.get("steady_turn", np.zeros(len(moving)))
    found = moving.copy()
    for start, stop in edges.reshape(-1, 2):
        if steady[start:stop].any() or motion.t[stop - 1] - motion.t[start] > MAX_MOVE:
            found[start:stop] = False
    return found


def lagged(signal: np.ndarray, t: np.ndarray, tau: float) -> np.ndarray:
    """First-order lag of a signal (n,), from rest."""
    return first_order_lag(np.nan_to_num(signal), float(np.median(np.diff(t))), tau)


EVENTS = {
    "each move to another position": ("reposition", repositioning),
    "each turn of gravity's direction": ("gravity-turn", gravity_turns),
    "each stop": ("stop", turning),
}


def empirical(motion: Motion, left_out: LeftOut = NOTHING) -> tuple[Term, ...]:
    """Every empirical term that a recording could need.

    left_out: what is followed by readings of some channels that are not to follow it.
    """
    return (
        *_relaxations(), *_lags(left_out), *_products(left_out), *_recorded(motion, left_out),
        *_sinusoids(), *_of_table(motion), *tips(),
    )  # fmt: skip


def _relaxations() -> Iterator[Term]:
    for event, (name, detect) in EVENTS.items():
        for tau in RELAXATIONS:
            title = message(
                "explain-relaxation", event=message(f"explain-event-{name}"), tau=f"{tau:g}"
            )
            decay = partial(_decay, detect, tau)
            yield regression_term(f"exp(−t/{tau:g} s) after {event}", title, EVERY, 1, decay, True)


def _decay(
    detect: Callable[[Motion], np.ndarray], tau: float, motion: Motion, inputs: Inputs, channel: int
) -> list[np.ndarray]:
    return [np.exp(-time_since(motion, detect(motion)) / tau)]


def _lags(left_out: LeftOut) -> Iterator[Term]:
    signals: list[tuple[str, str, str, tuple[int, ...], bool, Signal]] = [
        ("ω", "own-rate", RATE, GYROS, False, lambda m, u, c: u.rate[:, c]),
        ("ω²", "squared-rate", RATE_2, EVERY, True, lambda m, u, c: (u.rate**2).sum(axis=1)),
        ("|ω|", "rate-size", RATE, EVERY, True, lambda m, u, c: np.sqrt((u.rate**2).sum(axis=1))),
        ("f", "own-force", FORCE, EVERY, False, lambda m, u, c: u.force[:, c % 3]),
        ("|f|", "own-force-size", FORCE, ACCELS, False, lambda m, u, c: np.abs(u.force[:, c % 3])),
    ]
    for key, name, unit, every, shared, signal in signals:
        channels = _remaining(every, f"lag({key})", left_out)
        for tau in LAGS if channels else ():
            title = message("explain-lag", signal=message(f"explain-signal-{name}"), tau=f"{tau:g}")
            lag = partial(_lag, signal, tau)
            form = f"lag({key}, {tau:g} s)"
            yield regression_term(form, title, channels, 1, lag, shared, per(unit))


def _lag(
    signal: Signal, tau: float, motion: Motion, inputs: Inputs, channel: int
) -> list[np.ndarray]:
    return [lagged(signal(motion, inputs, channel), motion.t, tau)]


def others(channel: int) -> tuple[int, int]:
    axis = channel % 3
    return (axis + 1) % 3, (axis + 2) % 3


def _products(left_out: LeftOut) -> Iterator[Term]:
    products: list[tuple[str, str, str, tuple[int, ...], int, Regressors]] = [
        ("ω_j·ω_k", "other-rates", RATE_2, EVERY, 1,
         lambda m, u, c: [u.rate[:, others(c)[0]] * u.rate[:, others(c)[1]]]),
        ("ω_i·ω_j", "own-rate", RATE_2, EVERY, 2,
         lambda m, u, c: [u.rate[:, c % 3] * u.rate[:, j] for j in others(c)]),
        ("f_j·f_k", "other-forces", FORCE_2, EVERY, 1,
         lambda m, u, c: [u.force[:, others(c)[0]] * u.force[:, others(c)[1]]]),
        ("f_i·f_j", "own-force", FORCE_2, EVERY, 2,
         lambda m, u, c: [u.force[:, c % 3] * u.force[:, j] for j in others(c)]),
        ("f_j²", "squared-other-forces", FORCE_2, ACCELS, 2,
         lambda m, u, c: [u.force[:, j] ** 2 for j in others(c)]),
        ("ω_j²", "squared-other-rates", RATE_2, GYROS, 2,
         lambda m, u, c: [u.rate[:, j] ** 2 for j in others(c)]),
        ("ω_i²", "squared-own-rate", RATE_2, ACCELS, 1,
         lambda m, u, c: [u.rate[:, c % 3] ** 2]),
        ("ω", "rates", RATE, ACCELS, 3, lambda m, u, c: list(u.rate.T)),
        ("|ω_j|", "other-rate-sizes", RATE, EVERY, 2,
         lambda m, u, c: [np.abs(u.rate[:, j]) for j in others(c)]),
        ("ω⁴", "fourth-power", "(rad/s)^4", EVERY, 1,
         lambda m, u, c: [(u.rate**2).sum(axis=1) ** 2]),
        ("ω̇", "angular-acceleration", TURNING, ACCELS, 3,
         lambda m, u, c: list(m.acceleration.T)),
        ("|ω̇|", "angular-acceleration-size", TURNING, EVERY, 1,
         lambda m, u, c: [np.sqrt((m.acceleration**2).sum(axis=1))]),
    ]  # fmt: skip
    for key, name, unit, every, number, regressors in products:
        channels = _remaining(every, key, left_out)
        title = message(f"explain-product-{name}")
        if channels:
            yield regression_term(key, title, channels, number, regressors, units=per(unit))


def _remaining(every: tuple[int, ...], key: str, left_out: LeftOut) -> tuple[int, ...]:
    return tuple(c for c in every if c not in left_out.get(key, ()))


def _recorded(motion: Motion, left_out: LeftOut) -> Iterator[Term]:
    for key in RECORDED:
        signal = motion.recorded.get(key)
        if signal is None or np.nanstd(signal) < 1e-9:
            continue
        recorded = message(f"explain-recorded-{key.replace('_', '-')}")
        title = message("explain-follows", signal=recorded)
        follows = partial(_deviation, key)
        channels = _remaining(EVERY, key, left_out)
        if channels:
            yield regression_term(key, title, channels, 1, follows, True, per(RECORDED[key]))
        product = message("explain-recorded-times-input", signal=recorded)
        title = message("explain-follows", signal=product)
        scaled, unit = partial(_scaled_input, key), f"1/{RECORDED[key]}"
        yield regression_term(f"{key}·input", title, EVERY, 1, scaled, units=(unit, unit))


def _deviation(key: str, motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    return [motion.recorded[key] - np.nanmean(motion.recorded[key])]


def _scaled_input(key: str, motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
    own = (inputs.rate if channel < 3 else inputs.force)[:, channel % 3]
    return [_deviation(key, motion, inputs, channel)[0] * own]


def _sinusoids() -> Iterator[Term]:
    for channels in (EVERY, GYROS, ACCELS):
        for _ in range(SINUSOIDS):
            yield sinusoid(channels)


def _of_table(motion: Motion) -> Iterator[Term]:
    if motion.axes is None:
        return
    for axis, (angle, speed) in enumerate(
        zip(motion.axes.angles.T, motion.axes.speeds.T, strict=True)
    ):
        if np.nanmin(speed, initial=0.0) < 0.0 < np.nanmax(speed, initial=0.0):
            yield lost_motion(axis)
        if np.isfinite(angle).any() and np.nanmax(angle) - np.nanmin(angle) >= ONE_TURN:
            yield from _harmonics(axis)
            yield from leans(axis)


def _harmonics(axis: int) -> Iterator[Term]:
    for order in HARMONICS:
        title = message("explain-harmonic", axis=axis + 1, order=order)
        harmonic = partial(_harmonic, axis, order)
        yield regression_term(f"cos {order}θ{axis + 1}", title, EVERY, 2, harmonic, True)


def _harmonic(
    axis: int, order: int, motion: Motion, inputs: Inputs, channel: int
) -> list[np.ndarray]:
    assert motion.axes is not None
    angle = order * motion.axes.angles[:, axis]
    return [np.sin(angle), np.cos(angle)]
