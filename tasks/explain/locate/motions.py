"""Ways of parting a run by its motion: by rate, by attitude, after moves, on ramps."""

from collections.abc import Callable, Iterator

import numpy as np

from schemas.recording import AXES, MEASURED, Segment
from tasks.explain.locate.regime import Regime, listed
from tasks.model.term import Text
from tasks.motion.whole import Motion

TURNS_OVER = np.radians(0.5)  # rad/s at which gravity's direction in the body changes
RAMPING = 0.02  # of the largest angular acceleration: less is a steady rate
QUIETEST = 0.1  # rad/s²: less is the encoders' noise
MOVING: tuple[Text, Text] = (
    ("while gravity's direction stays", "重力方向不变时"),
    ("while gravity's direction changes", "重力方向改变时"),
)
SINCE = np.array([0.0, 5.0, 15.0, 30.0, 60.0, np.inf])  # s since the last move
SIGNED = tuple(sign + axis for axis in AXES for sign in "+-")


def by_rate(motion: Motion, segments: tuple[Segment, ...], segment: np.ndarray) -> Iterator[Regime]:
    """By the size of the rate, and by the rate about each axis with its sign."""
    measured = [k for k, each in enumerate(segments) if each.kind in MEASURED]
    courses = {"": np.linalg.norm(motion.rate, axis=1)}
    courses |= {axis: motion.rate[:, i] for i, axis in enumerate(AXES)}
    for axis, course in courses.items():
        course = np.degrees(course)
        held = (course[(segment == k) & np.isfinite(course)] for k in measured)
        rates = [float(np.median(each)) for each in held if len(each)]
        levels = _levels(np.array(rates))
        about = (f" about {axis}", f"绕 {axis} 轴") if axis else ("", "")
        edges = (levels[1:] + levels[:-1]) / 2
        cell = np.where(np.isfinite(course), np.searchsorted(edges, course), -1)
        yield Regime(
            "rate", cell, True, (f"the rate{about[0]}", f"{about[1]}角速率"),
            tuple((f"at {x:g} °/s", f"{x:g} °/s 时") for x in levels), _at(levels, about),
        )  # fmt: skip


def _levels(rates: np.ndarray) -> np.ndarray:
    """Rates (deg/s) that differ: rounded to two digits, rest at zero."""
    if not len(rates):
        return np.zeros(1)
    fine = 10.0 ** (np.floor(np.log10(np.maximum(np.abs(rates), 1.0))) - 1)
    return np.unique(np.round(rates / fine) * fine + 0.0)


def _at(levels: np.ndarray, about: Text) -> Callable[[list[int]], Text]:
    def at(cells: list[int]) -> Text:
        low, high = levels[cells[0]], levels[cells[-1]]
        span, chinese = f"from {low:g} to {high:g} °/s", f"{low:g} 至 {high:g} °/s"
        if low == high == 0.0 and not about[0]:
            return "at rest", "静止时"
        if low == high:
            span, chinese = f"of {low:g} °/s", f"{low:g} °/s"
        elif cells[-1] == len(levels) - 1:
            span, chinese = f"of {low:g} °/s and more", f"不低于 {low:g} °/s"
        elif cells[0] == 0:
            span, chinese = f"of {high:g} °/s and less", f"不高于 {high:g} °/s"
        return f"at rates{about[0]} {span}", f"{about[1]}角速率为 {chinese} 时"

    return at


def _nearest(direction: np.ndarray) -> np.ndarray:
    """(m,) 0 to 5: the body axis +x, −x, +y … nearest to a direction (m, 3); −1 unknown."""
    known = np.isfinite(direction).all(axis=1)
    filled = np.where(known[:, None], direction, 0.0)
    axis = np.abs(filled).argmax(axis=1)
    below = filled[np.arange(len(axis)), axis] < 0
    return np.where(known, 2 * axis + below, -1)


def by_attitude(motion: Motion) -> Regime:
    """By the body axis that is nearest to up."""
    cells = tuple((f"with {axis} up", f"{axis} 朝上时") for axis in SIGNED)
    return Regime(
        "attitude", _nearest(motion.up), False, ("which axis is up", "朝上的轴"), cells,
        listed(tuple((a, a) for a in SIGNED), ("while {} is up", "{} 朝上时")),
    )  # fmt: skip


def by_heading(motion: Motion) -> Iterator[Regime]:
    """By the upper axis together with what lies level: towards north, or along the table."""
    base = motion.axes.base if motion.axes is not None else np.full_like(motion.up, np.nan)
    up = _nearest(motion.up)
    for level, name in ((motion.north, ("north", "北")), (base, ("the table's y", "转台 y"))):
        towards = _nearest(level - (level * motion.up).sum(axis=1)[:, None] * motion.up)
        both = np.where((up >= 0) & (towards >= 0), 6 * up + towards, -1)
        cells = tuple(
            (f"with {a} up and {b} to {name[0]}", f"{a} 朝上且 {b} 朝{name[1]}时")
            for a in SIGNED for b in SIGNED
        )  # fmt: skip
        yield Regime(
            "attitude", both, False, (f"which axis is up and which to {name[0]}", "姿态"), cells,
            listed(cells, ("{}", "{}")),
        )  # fmt: skip


def by_moves(motion: Motion) -> Iterator[Regime]:
    """By whether gravity's direction in the body changes, and by the time since it last did."""
    since = since_move(motion)
    known = np.isfinite(motion.up).all(axis=1) & np.isfinite(motion.rate).all(axis=1)
    moving = np.where(known, since == 0, -1)
    follows = "whether gravity's direction changes", "重力方向是否改变"
    yield Regime("attitude", moving, False, follows, MOVING, listed(MOVING, ("{}", "{}")))
    cell = np.where(known & (since > 0), np.searchsorted(SINCE[1:-1], since, "right"), -1)
    cells = tuple(_after([k]) for k in range(len(SINCE) - 1))
    title = "the time since the last move", "距上次改变姿态的时间"
    yield Regime("after_moves", cell, True, title, cells, _after)


def since_move(motion: Motion) -> np.ndarray:
    """(m,) s since gravity's direction in the body last changed; infinite before it first did."""
    moving = np.linalg.norm(np.cross(motion.rate, motion.up), axis=1) > TURNS_OVER
    last = np.where(moving, motion.t, -np.inf)
    return motion.t - np.maximum.accumulate(last)


def _after(cells: list[int]) -> Text:
    low, high = SINCE[cells[0]], SINCE[cells[-1] + 1]
    if np.isinf(high):
        return f"later than {low:g} s after moves", f"改变姿态 {low:g} s 以后"
    if low == 0:
        return f"within {high:g} s after moves", f"改变姿态后 {high:g} s 内"
    return f"{low:g} s to {high:g} s after moves", f"改变姿态后 {low:g} s 至 {high:g} s"


def by_ramps(motion: Motion) -> Regime:
    """By whether the angular acceleration is that of a ramp."""
    size = np.linalg.norm(motion.acceleration, axis=1)
    known = np.isfinite(size)
    most = float(size[known].max(initial=0.0))
    ramp = np.where(known, size > max(RAMPING * most, QUIETEST), -1).astype(int)
    cells = (("at a steady rate", "角速率恒定时"), ("while the rate changes", "角速率变化时"))
    return Regime(
        "ramps", ramp, False, ("whether the rate changes", "角速率是否变化"), cells,
        listed(cells, ("{}", "{}")),
    )  # fmt: skip
