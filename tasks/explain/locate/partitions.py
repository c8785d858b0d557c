"""Partitions of a run into cells: by its motion, by time and by what was recorded."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial, reduce

import numpy as np
from scipy.sparse import csr_array

from schemas.discrepancy import Dimension
from schemas.recording import ACCEL, ANGLE, AXES, GYRO, MEASURED, Recording, Segment
from tasks.motion.whole import Motion
from tasks.words import Message, Sayable, message

TILTING = np.radians(0.5)  # rad/s at which gravity's direction in the body changes
RAMPING = 0.02  # of the largest angular acceleration: less is a steady rate
MIN_RAMP = 0.1  # rad/s²: less is the encoders' noise
AFTER_MOVE = np.array([0.0, 5.0, 15.0, 30.0, 60.0, np.inf])  # s since the last move
SIGNED = tuple(sign + axis for axis in AXES for sign in "+-")
PARTS = 10  # of the range of a signal
UNITS = {"temperature": " °C", "humidity": " %", "supply_voltage": " V", "pressure": " hPa"}


@dataclass(frozen=True)
class Partition:
    """One way of partitioning the run into k cells.

    cell: (m,) the cell of each block, −1 where it is not known. ordered: cells next to each
    other belong together. variable: what the cells differ in. cells: what each is called.
    circumstance: the words for some cells, in their order. recorded: by a signal that the run
    did not command: power that happens to coincide with a part of its range means nothing, only
    what varies with it does.
    """

    dimension: Dimension
    cell: np.ndarray
    ordered: bool
    variable: Sayable
    cells: tuple[Message, ...]
    circumstance: Callable[[Sequence[int]], Sayable]
    recorded: bool = False

    @cached_property
    def indicator(self) -> csr_array:
        """(k, m) sparse: 1 where a block lies in a cell."""
        known = np.flatnonzero(self.cell >= 0)
        shape = len(self.cells), len(self.cell)
        return csr_array((np.ones(len(known)), (self.cell[known], known)), shape=shape)


def partitions_of(
    recording: Recording, motion: Motion, segments: tuple[Segment, ...], segment: np.ndarray
) -> tuple[Partition, ...]:
    """Every partition of a run into two cells or more; motion, segment (m,): of the blocks."""
    every = (
        *by_rate(motion, segments, segment), by_attitude(motion), *by_heading(motion),
        *by_moves(motion), by_ramps(motion),
        _by_value("time", motion.t, message("locate-time"), " s"),
        *by_records(recording, motion.t),
    )  # fmt: skip
    return tuple(each for each in every if len(np.unique(each.cell[each.cell >= 0])) > 1)


def by_rate(
    motion: Motion, segments: tuple[Segment, ...], segment: np.ndarray
) -> Iterator[Partition]:
    """By the size of the rate, and by the rate about each axis with its sign."""
    measured = [k for k, each in enumerate(segments) if each.kind in MEASURED]
    rates = {"": np.linalg.norm(motion.rate, axis=1)} | dict(zip(AXES, motion.rate.T, strict=True))
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
    """“at rates about x from −100 to −30 °/s”; axis: empty for the size of the rate."""
    low, high = levels[cells[0]], levels[cells[-1]]
    if low == high == 0.0 and not axis:
        return message("locate-at-rest")
    if low == high:
        which = "one"
    elif cells[-1] == len(levels) - 1:
        which = "above"
    else:
        which = "below" if cells[0] == 0 else "between"
    rates = message("locate-rates-about", axis=axis) if axis else message("locate-rates")
    return message(f"locate-rates-{which}", rates=rates, low=f"{low:g}", high=f"{high:g}")


def by_attitude(motion: Motion) -> Partition:
    """By the body axis that is nearest to up."""
    cells = tuple(message("locate-up", axis=axis) for axis in SIGNED)
    circumstance = partial(_listed, SIGNED, "locate-while-up")
    up = _nearest_axis(motion.up)
    return Partition("attitude", up, False, message("locate-attitude"), cells, circumstance)


def by_heading(motion: Motion) -> Iterator[Partition]:
    """By the upper axis together with what lies level: towards north, or along the table."""
    base = motion.axes.base if motion.axes is not None else np.full_like(motion.up, np.nan)
    up = _nearest_axis(motion.up)
    for level, name in ((motion.north, "locate-north"), (base, "locate-table-y")):
        towards = _nearest_axis(level - (level * motion.up).sum(axis=1)[:, None] * motion.up)
        cell = np.where((up >= 0) & (towards >= 0), 6 * up + towards, -1)
        cells = tuple(
            message("locate-up-and-to", up=a, level=b, towards=message(name))
            for a in SIGNED for b in SIGNED
        )  # fmt: skip
        yield _unordered("attitude", cell, f"{name}.heading", cells)


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
    yield _unordered("attitude", moving, "locate-gravity-changes", cells)
    known = motion.known & (since > 0)
    cell = np.where(known, np.searchsorted(AFTER_MOVE[1:-1], since, "right"), -1)
    after = tuple(_after_moves([k]) for k in range(len(AFTER_MOVE) - 1))
    yield Partition("after_moves", cell, True, message("locate-since-move"), after, _after_moves)


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
    return _unordered("ramps", ramp, "locate-rate-changes", cells)


def _unordered(
    dimension: Dimension, cell: np.ndarray, variable: str, cells: tuple[Message, ...]
) -> Partition:
    circumstance = partial(_listed, cells, None)
    return Partition(dimension, cell, False, message(variable), cells, circumstance)


def _listed(names: Sequence[Sayable], frame: str | None, cells: Sequence[int]) -> Sayable:
    """“+x or +y”, within the message `frame` where there is one."""
    either = reduce(lambda a, b: message("locate-or", first=a, second=b), (names[k] for k in cells))
    return message(frame, cells=either) if frame else either


def by_records(recording: Recording, t: np.ndarray) -> Iterator[Partition]:
    """By the unit's own temperature and by every other signal that was recorded."""
    for name, signal in recording.imu.columns.items():
        own = np.interp(t, recording.imu.t, signal)
        if name == "temperature":
            title = message("locate-unit-temperature")
            yield _by_value("temperature", own, title, UNITS[name], recorded=True)
        elif name not in (*GYRO, *ACCEL, *ANGLE):
            yield _by_value("recorded", own, name, "", recorded=True)
    room = recording.environment
    if room is None:
        return
    for name, signal in room.columns.items():
        known = np.isfinite(signal)
        if known.any():
            own = np.interp(t, room.t[known], signal[known])
            variable = message(f"locate-air-{name}") if name in UNITS else name
            yield _by_value("recorded", own, variable, UNITS.get(name, ""), recorded=True)


def _by_value(
    dimension: Dimension, signal: np.ndarray, variable: Sayable, unit: str, recorded: bool = False
) -> Partition:
    """By equal parts of a signal's range."""
    known = np.isfinite(signal)
    values = signal[known] if known.any() else np.zeros(1)
    edges = np.linspace(values.min(), values.max(), PARTS + 1)
    cell = np.where(known, np.searchsorted(edges[1:-1], signal), -1)
    # As many decimals as resolve hundredths of the range.
    digits = max(0, 2 - int(np.floor(np.log10(max(float(np.ptp(edges)), 1e-9)))))
    cells = tuple(
        message("locate-at-value", value=f"{middle:.{digits}f}{unit}")
        for middle in 0.5 * (edges[1:] + edges[:-1])
    )

    def circumstance(chosen: Sequence[int]) -> Message:
        low, high = (f"{edges[k]:.{digits}f}" for k in (chosen[0], chosen[-1] + 1))
        return message("locate-values-between", low=low, high=high + unit)

    return Partition(dimension, cell, True, variable, cells, circumstance, recorded)
