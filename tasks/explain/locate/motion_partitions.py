"""Partitions of a run by its motion: by rate, by attitude, after moves, on ramps."""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from schemas.recording import AXES, MEASURED, Segment
from tasks.explain.locate.partition import Partition, unordered
from tasks.motion.whole import Motion
from tasks.words import Message, message

TILTING = np.radians(0.5)  # rad/s at which gravity's direction in the body changes
RAMPING = 0.02  # of the largest angular acceleration: less is a steady rate
MIN_RAMP = 0.1  # rad/s²: less is the encoders' noise
AFTER_MOVE = np.array([0.0, 5.0, 15.0, 30.0, 60.0, np.inf])  # s since the last move
SIGNED = tuple(sign + axis for axis in AXES for sign in "+-")


def by_rate(
    motion: Motion, segments: tuple[Segment, ...], segment: np.ndarray
) -> Iterator[Partition]:
    """By the size of the rate, and by the rate about each axis with its sign."""
    measured = [k for k, each in enumerate(segments) if each.kind in MEASURED]
    rates = {"": np.linalg.norm(motion.rate, axis=1)}
    rates |= {axis: motion.rate[:, i] for i, axis in enumerate(AXES)}
    for axis, rate in rates.items():
        rate = np.degrees(rate)
        held = (rate[(segment == k) & np.isfinite(rate)] for k in measured)
        levels = _levels(np.array([float(np.median(values)) for values in held if len(values)]))
        edges = (levels[1:] + levels[:-1]) / 2
        cell = np.where(np.isfinite(rate), np.searchsorted(edges, rate), -1)
        variable = message("locate-rate-about", axis=axis) if axis else message("locate-rate")
        cells = tuple(message("locate-at-rate", rate=f"{level:g}") for level in levels)
        yield Partition("rate", cell, True, variable, cells, partial(_rate_range, levels, axis))


def _levels(rates: np.ndarray) -> np.ndarray:
    """Rates (deg/s) that differ: rounded to two digits, rest at zero."""
    if not len(rates):
        return np.zeros(1)
    fine = 10.0 ** (np.floor(np.log10(np.maximum(np.abs(rates), 1.0))) - 1)
    return np.unique(np.round(rates / fine) * fine + 0.0)


def _rate_range(levels: np.ndarray, axis: str, cells: Sequence[int]) -> Message:
    """«at rates about x from −100 to −30 °/s»; axis: empty for the size of the rate."""
    low, high = levels[cells[0]], levels[cells[-1]]
    if low == high == 0.0 and not axis:
        return message("locate-at-rest")
    if low == high:
        which = "locate-rates-one"
    elif cells[-1] == len(levels) - 1:
        which = "locate-rates-above"
    else:
        which = "locate-rates-below" if cells[0] == 0 else "locate-rates-between"
    rates = message("locate-rates-about", axis=axis) if axis else message("locate-rates")
    return message(which, rates=rates, low=f"{low:g}", high=f"{high:g}")


def by_attitude(motion: Motion) -> Partition:
    """By the body axis that is nearest to up."""
    cells = tuple(message("locate-up", axis=axis) for axis in SIGNED)
    up = _nearest_axis(motion.up)
    return unordered("attitude", up, message("locate-attitude"), cells, SIGNED, "locate-while-up")


def by_heading(motion: Motion) -> Iterator[Partition]:
    """By the upper axis together with what lies level: towards north, or along the table."""
    base = motion.axes.base if motion.axes is not None else np.full_like(motion.up, np.nan)
    up = _nearest_axis(motion.up)
    for level, name in ((motion.north, "locate-north"), (base, "locate-table-y")):
        towards = _nearest_axis(level - (level * motion.up).sum(axis=1)[:, None] * motion.up)
        cell = np.where((up >= 0) & (towards >= 0), 6 * up + towards, -1)
        to = message(name)
        cells = tuple(
            message("locate-up-and-to", up=a, level=b, towards=to) for a in SIGNED for b in SIGNED
        )
        yield unordered("attitude", cell, message(f"{name}.heading"), cells)


def _nearest_axis(direction: np.ndarray) -> np.ndarray:
    """(m,) 0 to 5: the body axis +x, −x, +y … nearest to a direction (m, 3); −1 unknown."""
    known = np.isfinite(direction).all(axis=1)
    filled = np.where(known[:, None], direction, 0.0)
    axis = np.abs(filled).argmax(axis=1)
    below = filled[np.arange(len(axis)), axis] < 0
    return np.where(known, 2 * axis + below, -1)


def by_moves(motion: Motion) -> Iterator[Partition]:
    """By whether gravity's direction in the body changes, and by the time since it last did."""
    since = time_since_move(motion)
    moving = np.where(motion.known, since == 0, -1)
    cells = message("locate-gravity-fixed"), message("locate-gravity-changing")
    yield unordered("attitude", moving, message("locate-gravity-changes"), cells)
    known = motion.known & (since > 0)
    cell = np.where(known, np.searchsorted(AFTER_MOVE[1:-1], since, "right"), -1)
    cells_after = tuple(_after_moves([k]) for k in range(len(AFTER_MOVE) - 1))
    variable = message("locate-since-move")
    yield Partition("after_moves", cell, True, variable, cells_after, _after_moves)


def time_since_move(motion: Motion) -> np.ndarray:
    """(m,) s since gravity's direction in the body last changed; infinite before it first did."""
    moving = np.linalg.norm(np.cross(motion.rate, motion.up), axis=1) > TILTING
    return motion.t - np.maximum.accumulate(np.where(moving, motion.t, -np.inf))


def _after_moves(cells: Sequence[int]) -> Message:
    low, high = AFTER_MOVE[cells[0]], AFTER_MOVE[cells[-1] + 1]
    which = "later" if np.isinf(high) else "within" if low == 0 else "between"
    return message(f"locate-after-moves-{which}", low=f"{low:g}", high=f"{high:g}")


def by_ramps(motion: Motion) -> Partition:
    """By whether the angular acceleration is that of a ramp."""
    size = np.linalg.norm(motion.acceleration, axis=1)
    known = np.isfinite(size)
    most = float(size[known].max(initial=0.0))
    ramp = np.where(known, size > max(RAMPING * most, MIN_RAMP), -1).astype(int)
    cells = message("locate-rate-steady"), message("locate-rate-changing")
    return unordered("ramps", ramp, message("locate-rate-changes"), cells)
