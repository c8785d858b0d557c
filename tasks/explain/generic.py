"""What a mismatch may follow when no catalogued physics fits: an empirical basis.

Each is a term named `unnamed` whose title says what it follows: relaxations after moves, lags,
harmonics of the table's angle, products and powers, slow waves, and everything recorded.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.signal import lfilter

from tasks.model.term import Column, Inputs, Parameter, Term, Text
from tasks.motion.nudge import nudged
from tasks.motion.whole import Motion

UNNAMED = "unnamed"
GYROS, ACCELS = (0, 1, 2), (3, 4, 5)
EVERY = GYROS + ACCELS
LETTERS = "xyzxyz"
TURNED = 2.0 * np.pi  # rad: an axis that turned further has harmonics
MOVED = 0.02  # of a unit vector in a second: gravity's direction changes
AT_REST = 1e-3  # rad/s: slower is not a motion
LONGEST_MOVE = 20.0  # s; what turns longer is a run
RELAXATIONS = (1.5, 4.0, 8.0, 16.0, 40.0)  # s
LAGS = (3.0, 7.0, 18.0, 45.0, 120.0)  # s
WAVES_TRIED = 2  # periods for each set of channels
RECORDED: dict[str, Text] = {
    "humidity": ("the humidity", "湿度"),
    "pressure": ("the air pressure", "气压"),
    "air_temperature": ("the air temperature", "环境温度"),
}

Courses = Callable[[Motion, Inputs, int], Sequence[np.ndarray]]
Driver = Callable[[Motion, Inputs, int], np.ndarray]


@dataclass(frozen=True)
class Follows(Term):
    """Readings of some channels follow one or more courses, each channel with its own factors.

    courses: of motion, inputs and the channel, each (n,); alike: the same for every channel.
    """

    channels: tuple[int, ...] = field(kw_only=True)
    courses: Courses = field(kw_only=True)
    alike: bool = field(default=False, kw_only=True)

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        first = self.courses(motion, inputs, self.channels[0])
        return tuple(
            {channel: np.nan_to_num(course)}
            for channel in self.channels
            for course in (first if self.alike else self.courses(motion, inputs, channel))
        )


@dataclass(frozen=True)
class Askew(Term):
    """The unit is turned by a small rotation vector that follows a course."""

    course: Callable[[Motion], np.ndarray] = field(kw_only=True)

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        course = np.nan_to_num(self.course(motion))
        change = np.gradient(course, motion.t)
        for axis in range(3):
            if values[axis]:
                turned, speed = values[axis] * course, values[axis] * change
                motion = nudged(motion, np.eye(3)[axis], turned, speed, motion.rate)
        return motion


def follows(
    key: str,
    title: Text,
    channels: tuple[int, ...],
    number: int,
    courses: Courses,
    alike: bool = False,
) -> Follows:
    """An empirical term with `number` courses in each channel."""
    parameters = tuple(
        Parameter(
            f"{'gyro' if c < 3 else 'accel'}_{LETTERS[c]}" + (f"_{k + 1}" if number > 1 else ""),
            key, "rad/s" if c < 3 else "m/s2", 1.0, (-1.0, 1.0),
        )
        for c in channels for k in range(number)
    )  # fmt: skip
    return Follows(
        UNNAMED, "unnamed", "sensor", f"reading += c·{key}", "empirical", parameters,
        title=title, channels=channels, courses=courses, alike=alike,
    )  # fmt: skip


def empirical(motion: Motion) -> tuple[Term, ...]:
    """Every empirical term that a recording could need."""
    return (
        *_after_moves(), *_lags(), *_products(), *_recorded(motion), *_waves(),
        *_of_table(motion),
    )  # fmt: skip


def since_last(motion: Motion, events: np.ndarray) -> np.ndarray:
    """(n,) s since the last event (n,) bool was over; infinite before the first."""
    rows = np.flatnonzero(np.diff(events.astype(int)) == -1) + 1
    if not len(rows):
        return np.full(len(motion.t), np.inf)
    last = np.searchsorted(rows, np.arange(len(motion.t)), "right") - 1
    since = motion.t - motion.t[rows[np.maximum(last, 0)]]
    return np.where(last >= 0, since, np.inf)


def turned_over(motion: Motion) -> np.ndarray:
    """(n,) bool: gravity's direction in the unit changes. A turn about a level axis is one move."""
    up = np.nan_to_num(motion.up)
    step = float(np.median(np.diff(motion.t)))
    return np.asarray(np.linalg.norm(np.gradient(up, step, axis=0), axis=1) > MOVED)


def turning(motion: Motion) -> np.ndarray:
    """(n,) bool: the unit turns, in whatever way."""
    return np.asarray(np.linalg.norm(np.nan_to_num(motion.rate), axis=1) > AT_REST)


def repositioned(motion: Motion) -> np.ndarray:
    """(n,) bool: the unit turns from one rest to another, without a steady turn between."""
    moving = turning(motion)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], moving.astype(int), [0]])))
    steady = motion.recorded.get("steady_turn", np.zeros(len(moving)))
    found = moving.copy()
    for start, stop in edges.reshape(-1, 2):
        if steady[start:stop].any() or motion.t[stop - 1] - motion.t[start] > LONGEST_MOVE:
            found[start:stop] = False
    return found


def lagged(course: np.ndarray, t: np.ndarray, tau: float) -> np.ndarray:
    """First-order lag of a course (n,), from rest."""
    keep = np.exp(-float(np.median(np.diff(t))) / tau)
    return np.asarray(lfilter([1.0 - keep], [1.0, -keep], np.nan_to_num(course)))


def _after_moves() -> Iterator[Term]:
    kinds: tuple[tuple[Text, Callable[[Motion], np.ndarray]], ...] = (
        (("each move to another position", "每次转位"), repositioned),
        (("each turn of gravity's direction", "每次重力方向改变"), turned_over),
        (("each stop", "每次停止转动"), turning),
    )
    for of, events in kinds:
        for tau in RELAXATIONS:

            def courses(
                motion: Motion,
                inputs: Inputs,
                channel: int,
                events: Callable[[Motion], np.ndarray] = events,
                tau: float = tau,
            ) -> list[np.ndarray]:
                return [np.exp(-since_last(motion, events(motion)) / tau)]

            title = (
                f"a relaxation after {of[0]}, e-folding in about {tau:g} s",
                f"{of[1]}后的弛豫，时间常数约 {tau:g} s",
            )
            yield follows(f"exp(−t/{tau:g} s) after {of[0]}", title, EVERY, 1, courses, True)


def _lags() -> Iterator[Term]:
    drivers: dict[str, tuple[Text, tuple[int, ...], Driver]] = {
        "ω": (("the rate about its own axis", "自身轴角速率"), GYROS, lambda m, u, c: u.rate[:, c]),
        "ω²": (
            ("the square of the rate", "角速率平方"), EVERY,
            lambda m, u, c: (u.rate**2).sum(axis=1),
        ),
        "|ω|": (
            ("the size of the rate", "角速率大小"), EVERY,
            lambda m, u, c: np.sqrt((u.rate**2).sum(axis=1)),
        ),
        "f": (
            ("the specific force along its own axis", "自身轴比力"), EVERY,
            lambda m, u, c: u.force[:, c % 3],
        ),
        "|f|": (
            ("the size of the specific force along its own axis", "自身轴比力大小"), ACCELS,
            lambda m, u, c: np.abs(u.force[:, c % 3]),
        ),
    }  # fmt: skip
    for key, (of, channels, driver) in drivers.items():
        for tau in LAGS:

            def courses(
                motion: Motion,
                inputs: Inputs,
                channel: int,
                driver: Driver = driver,
                tau: float = tau,
            ) -> list[np.ndarray]:
                return [lagged(driver(motion, inputs, channel), motion.t, tau)]

            title = (
                f"{of[0]}, lagging by about {tau:g} s",
                f"{of[1]}，滞后约 {tau:g} s",
            )
            yield follows(
                f"lag({key}, {tau:g} s)", title, channels, 1, courses, key in ("ω²", "|ω|")
            )


def _others(channel: int) -> tuple[int, int]:
    axis = channel % 3
    return (axis + 1) % 3, (axis + 2) % 3


def _products() -> Iterator[Term]:
    made: list[tuple[str, Text, tuple[int, ...], int, Courses]] = [
        ("ω_j·ω_k", ("the product of the rates about the two other axes", "另两轴角速率之积"),
         EVERY, 1, lambda m, u, c: [u.rate[:, _others(c)[0]] * u.rate[:, _others(c)[1]]]),
        ("ω_i·ω_j", ("products of the own rate with the others", "自身轴与其他轴角速率之积"),
         EVERY, 2, lambda m, u, c: [u.rate[:, c % 3] * u.rate[:, j] for j in _others(c)]),
        ("f_j·f_k", ("the product of the specific forces on the two other axes", "另两轴比力之积"),
         EVERY, 1, lambda m, u, c: [u.force[:, _others(c)[0]] * u.force[:, _others(c)[1]]]),
        ("f_i·f_j", ("products of its own specific force with the others", "自身与其他轴比力之积"),
         EVERY, 2, lambda m, u, c: [u.force[:, c % 3] * u.force[:, j] for j in _others(c)]),
        ("f_j²", ("the squares of the other specific forces", "其他轴比力的平方"),
         ACCELS, 2, lambda m, u, c: [u.force[:, j] ** 2 for j in _others(c)]),
        ("ω_j²", ("the squares of the rates", "角速率的平方"),
         GYROS, 2, lambda m, u, c: [u.rate[:, j] ** 2 for j in _others(c)]),
        ("ω_i²", ("the square of the own rate", "自身轴角速率的平方"),
         ACCELS, 1, lambda m, u, c: [u.rate[:, c % 3] ** 2]),
        ("ω", ("the rates", "角速率"), ACCELS, 3, lambda m, u, c: list(u.rate.T)),
        ("|ω_j|", ("the sizes of the other rates", "其他轴角速率的大小"),
         EVERY, 2, lambda m, u, c: [np.abs(u.rate[:, j]) for j in _others(c)]),
        ("ω⁴", ("the fourth power of the rate", "角速率的四次方"),
         EVERY, 1, lambda m, u, c: [(u.rate**2).sum(axis=1) ** 2]),
        ("ω̇", ("the angular acceleration", "角加速度"),
         ACCELS, 3, lambda m, u, c: list(m.acceleration.T)),
        ("|ω̇|", ("the size of the angular acceleration", "角加速度的大小"),
         EVERY, 1, lambda m, u, c: [np.sqrt((m.acceleration**2).sum(axis=1))]),
    ]  # fmt: skip
    for entry in made:
        yield follows(*entry)


def _recorded(motion: Motion) -> Iterator[Term]:
    for key, of in RECORDED.items():
        course = motion.recorded.get(key)
        if course is None or np.nanstd(course) < 1e-9:
            continue

        def courses(
            motion: Motion, inputs: Inputs, channel: int, key: str = key
        ) -> list[np.ndarray]:
            return [motion.recorded[key] - np.nanmean(motion.recorded[key])]

        def scaled(
            motion: Motion, inputs: Inputs, channel: int, key: str = key
        ) -> list[np.ndarray]:
            felt = inputs.rate if channel < 3 else inputs.force
            course = motion.recorded[key] - np.nanmean(motion.recorded[key])
            return [course * felt[:, channel % 3]]

        yield follows(key, of, EVERY, 1, courses, True)
        title = (f"{of[0]} times the input", f"{of[1]}与输入之积")
        yield follows(f"{key}·input", title, EVERY, 1, scaled)


def _waves() -> Iterator[Term]:
    for channels in (EVERY, GYROS, ACCELS):
        for _ in range(WAVES_TRIED):
            yield wave(channels)


@dataclass(frozen=True)
class Wave(Follows):
    """Something that comes and goes with a period; shapes: the period."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        turned = 2.0 * np.pi * motion.t / self.at[0]
        pair = (np.sin(turned), np.cos(turned))
        return tuple({channel: course} for channel in self.channels for course in pair)

    def shaped(self, at: tuple[float, ...]) -> "Wave":
        """The wave of another period."""
        said = f"{at[0]:.3g} s"
        title = (f"a wave with a period of about {said}", f"周期约 {said} 的波动")
        return replace(self, at=at, title=title)


def wave(channels: tuple[int, ...], period: float = 100.0) -> Wave:
    """A wave in some channels, at any phase in each."""
    plain = follows("a wave", ("", ""), channels, 2, lambda motion, inputs, channel: ())
    shape = Parameter("period", "P", "s", 1.0, (0.5, 2000.0))
    return Wave(
        plain.name, plain.family, plain.stage, "reading += a·sin(2πt/P) + b·cos(2πt/P)",
        plain.source, plain.parameters, (shape,), (period,),
        channels=channels, courses=plain.courses,
    ).shaped((period,))  # fmt: skip


def _of_table(motion: Motion) -> Iterator[Term]:
    if motion.axes is None:
        return
    for axis in range(motion.axes.angles.shape[1]):
        angle = motion.axes.angles[:, axis]
        if not np.isfinite(angle).any() or np.nanmax(angle) - np.nanmin(angle) < TURNED:
            continue
        yield from _harmonics(axis)
        yield from _bumps(axis)


def _harmonics(axis: int) -> Iterator[Term]:
    for wave in range(1, 7):

        def courses(
            motion: Motion, inputs: Inputs, channel: int, wave: int = wave
        ) -> list[np.ndarray]:
            assert motion.axes is not None
            turned = wave * motion.axes.angles[:, axis]
            return [np.sin(turned), np.cos(turned)]

        title = (
            f"the angle of table axis {axis + 1}, {wave} times a turn",
            f"转台第 {axis + 1} 轴转角，每转 {wave} 次",
        )
        yield follows(f"cos {wave}θ{axis + 1}", title, EVERY, 2, courses, True)


def _bumps(axis: int) -> Iterator[Term]:
    for width in (0.4,):
        for centre in np.arange(0.0, 2.0 * np.pi, np.pi / 6.0):

            def course(motion: Motion, centre: float = centre, width: float = width) -> np.ndarray:
                assert motion.axes is not None
                away = motion.axes.angles[:, axis] - centre
                return np.asarray(np.exp((np.cos(away) - 1.0) / width**2))

            degrees = np.degrees(centre)
            yield Askew(
                UNNAMED, "unnamed", "motion", f"the unit leans near θ{axis + 1} = {degrees:.0f}°",
                "empirical",
                tuple(Parameter(f"lean_{a}", "lean", "rad", 1.0, (-0.01, 0.01)) for a in "xyz"),
                title=(
                    f"a lean of the unit near {degrees:.0f}° of table axis {axis + 1}",
                    f"转台第 {axis + 1} 轴转角 {degrees:.0f}° 附近的倾斜",
                ),
                course=course,
            )  # fmt: skip


def slow_course(said: Term | None, waves: int) -> Follows:
    """Slow waves of half a period and more over the run, in every channel.

    said: the term whose name and texts it takes; without one it is `unnamed`.
    """

    def courses(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
        share = (motion.t - motion.t[0]) / (motion.t[-1] - motion.t[0])
        return [np.cos(np.pi * k * share) for k in range(1, waves + 1)]

    title = ("a slow drift that nothing recorded follows", "与任何记录量均无关的缓慢漂移")
    drift = follows("slow waves", title, EVERY, waves, courses, True)
    if said is None:
        return drift
    texts = ("name", "family", "equation", "source", "title", "confused_with", "separated_by")
    return replace(drift, **{text: getattr(said, text) for text in texts})
