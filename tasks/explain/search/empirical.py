"""What a mismatch may follow when no catalogued physics fits: an empirical basis.

Each is a term named `unnamed` whose title says what it follows: relaxations after moves, lags,
harmonics of the table's angle, products and powers, slow waves, and everything recorded.
"""

from collections.abc import Callable, Iterator

import numpy as np

from tasks.explain.channels import ACCELS, EVERY, GYROS
from tasks.explain.search.empirical_terms import UNNAMED, Askew, Courses, follows, wave
from tasks.explain.search.motion_signals import (
    lagged,
    repositioned,
    since_last,
    turned_over,
    turning,
)
from tasks.model.term import Inputs, Parameter, Term, Text
from tasks.motion.whole import Motion

TURNED = 2.0 * np.pi  # rad: an axis that turned further has harmonics
RELAXATIONS = (1.5, 4.0, 8.0, 16.0, 40.0)  # s
LAGS = (3.0, 7.0, 18.0, 45.0, 120.0)  # s
WAVES_TRIED = 2  # periods for each set of channels
RECORDED: dict[str, Text] = {
    "humidity": ("the humidity", "湿度"),
    "pressure": ("the air pressure", "气压"),
    "air_temperature": ("the air temperature", "环境温度"),
}

Driver = Callable[[Motion, Inputs, int], np.ndarray]


def empirical(motion: Motion) -> tuple[Term, ...]:
    """Every empirical term that a recording could need."""
    return (
        *_after_moves(), *_lags(), *_products(), *_recorded(motion), *_waves(),
        *_of_table(motion),
    )  # fmt: skip


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
    for order in range(1, 7):

        def courses(
            motion: Motion, inputs: Inputs, channel: int, order: int = order
        ) -> list[np.ndarray]:
            assert motion.axes is not None
            turned = order * motion.axes.angles[:, axis]
            return [np.sin(turned), np.cos(turned)]

        title = (
            f"the angle of table axis {axis + 1}, {order} times a turn",
            f"转台第 {axis + 1} 轴转角，每转 {order} 次",
        )
        yield follows(f"cos {order}θ{axis + 1}", title, EVERY, 2, courses, True)


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
