"""Partitions of a run into cells: by its motion, by time and by what was recorded."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial, reduce
from typing import Self

import numpy as np
from scipy.sparse import csr_array

from schemas.discrepancy import Dimension
from schemas.recording import ACCEL, ANGLE, AXES, GYRO, MEASURED, Recording, Segment
from tasks.explain.inputs.prepared import shown_segments
from tasks.model.fit import inverse
from tasks.model.terms.standard import regressors
from tasks.motion.whole import Motion, whole_motion
from tasks.words import Message, Sayable, message
from tasks.words.numbers import MINUS

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


# Divides the run into short blocks, with the cell of every partition that each belongs to.

BLOCK = 0.04  # s: the finest resolution
MIN_INTERVALS = 30  # that the shortest run is taken for
ROUNDING = 1e-6  # standard deviations of the noise
MIN_VISIBLE = 1e-3  # of a cell's rows: a step of which the model leaves less cannot be seen
BINS = 256  # of a turn
MAX_HARMONIC = 40  # waves per turn
WHOLE_TURN = 0.99 * 2 * np.pi  # rad: less is no turn
SINGULAR = 1e-6


@dataclass(frozen=True)
class Moments:
    """Of an excess e over k parts of the run: number of rows, Σe and Σe², (k,) each."""

    rows: np.ndarray
    first: np.ndarray
    second: np.ndarray


@dataclass(frozen=True)
class Rotation:
    """The rows at which one axis turns a whole turn or more, in s segments.

    name: of the axis. rows: which of the n. cell: their segment and bin of the angle, as one
    number. inverse: (MAX_HARMONIC, s, 3, 3) of the normal equations of 1, cos hθ and sin hθ.
    highest: waves per turn that the fastest turn still has two rows for.
    """

    name: str
    rows: np.ndarray
    cell: np.ndarray
    inverse: np.ndarray
    highest: float

    def harmonic_power(self, values: np.ndarray) -> np.ndarray:
        """(MAX_HARMONIC,) square sum of values (n,) that each number of waves per turn absorbs."""
        sums, counts = (
            _per_segment(self.cell, self.inverse.shape[1], weights)
            for weights in (values[self.rows], None)
        )
        right = np.einsum("sb,hbi->hsi", sums, _basis())
        absorbed = np.einsum("hsi,hsij,hsj->hs", right, self.inverse, right)
        power = (absorbed - right[:, :, 0] ** 2 / counts.sum(axis=1)).sum(axis=1)
        return np.where(np.arange(1, MAX_HARMONIC + 1) <= self.highest, power, 0.0)


@dataclass(frozen=True)
class BlockedRun:
    """A recording of n rows in m blocks of 0.04 s or of one row, whichever is longer.

    motion: at the rows. starts: (m,) first row of each block. t: (m,) s, its middle. names: of the
    segments. segment: (m,) the segment of each block, −1 for none.
    """

    motion: Motion
    starts: np.ndarray
    t: np.ndarray
    names: tuple[str, ...]
    segment: np.ndarray
    partitions: tuple[Partition, ...]
    rotations: tuple[Rotation, ...]

    @classmethod
    def of(cls, recording: Recording) -> Self:
        """The run of a recording; where segments carry no labels they are found."""
        motion = whole_motion(recording)
        segments = shown_segments(recording)
        interval = motion.interval if len(motion.t) > 1 else BLOCK
        starts = np.arange(0, len(motion.t), max(1, int(BLOCK / interval + 1e-6)))
        middle = (starts + np.append(starts[1:], len(motion.t))) // 2
        t = motion.t[middle]
        segment = np.full(len(t), -1)
        for k, each in enumerate(segments):
            segment[slice(*np.searchsorted(t, (each.t_start, each.t_end)))] = k
        axes = tuple(axis.name for axis in recording.manifest.station.table_axes or ())
        rows = tuple(recording.imu.rows(each.t_start, each.t_end) for each in segments)
        return cls(
            motion, starts, t, tuple(each.name for each in segments), segment,
            partitions_of(recording, motion.taken(middle), segments, segment),
            rotations_of(motion, axes, rows),
        )  # fmt: skip

    @property
    def intervals(self) -> int:
        """How many intervals the run is made of: what a pattern rests on."""
        return max(MIN_INTERVALS, len(self.names))

    def block_sums(self, values: np.ndarray) -> np.ndarray:
        """Sums of values (n, …) over the blocks, (m, …)."""
        return np.add.reduceat(values, self.starts, axis=0)

    def moments(self, values: np.ndarray, known: np.ndarray) -> Moments:
        """The blocks' moments of values (n,) over the known rows (n,); they are zero elsewhere."""
        return Moments(*map(self.block_sums, (known.astype(float), values, values**2)))


@dataclass(frozen=True)
class StandardDesign:
    """The design matrix of the standard's model in one channel, of k regressors.

    values: (n, k), zero where the motion is not known. known: (n,) bool.
    inverse: (k, k) of the normal matrix. sums: (m, k) of the values over the blocks of the run.
    """

    values: np.ndarray
    known: np.ndarray
    inverse: np.ndarray
    sums: np.ndarray

    @classmethod
    def of(cls, run: BlockedRun, channel: int) -> Self:
        """The design matrix of channel 0 to 5."""
        values = regressors(run.motion, channel)
        known = np.isfinite(values).all(axis=1)
        values[~known] = 0.0
        return cls(values, known, inverse(values.T @ values), run.block_sums(values))

    def at_known(self, run: BlockedRun, signal: np.ndarray) -> Self:
        """The same at the rows where a signal (n,) is known as well: what is absorbed elsewhere
        absorbs nothing of it.
        """
        known = self.known & np.isfinite(signal)
        if known.sum() == self.known.sum():
            return self
        values = np.where(known[:, None], self.values, 0.0)
        return replace(
            self, values=values, known=known, inverse=inverse(values.T @ values),
            sums=run.block_sums(values),
        )  # fmt: skip

    def residual(self, signal: np.ndarray) -> np.ndarray:
        """(n,) of a signal (n,) what is not absorbed; zero where the design is not known."""
        filled = np.where(self.known, signal, 0.0)
        absorbed = self.values @ (self.inverse @ (self.values.T @ filled))
        return np.where(self.known, filled - absorbed, 0.0)

    def fit_steps(
        self, rows: np.ndarray, sums: np.ndarray, excess: np.ndarray
    ) -> tuple[np.ndarray, float]:
        """A step for each cell (c,), fitted to an excess together with the regressors.

        rows: (c,) in each cell. sums: (c, k) of the regressors over it. excess: (c,) its sum.
        Returns the steps and the square sum that they absorb.
        """
        size = np.sqrt(np.maximum(rows, 1.0))
        normal = np.diag(rows) - sums @ self.inverse @ sums.T
        scaled = np.linalg.pinv(normal / np.outer(size, size), rcond=MIN_VISIBLE, hermitian=True)
        steps = scaled @ (excess / size) / size
        return steps, float(steps @ excess)


@dataclass(frozen=True)
class ChannelExcess:
    """One channel's excess, and the standard's model beside it.

    values: (n,) in standard deviations of the noise. moments: of the m blocks. factor, unit: to
    print a value.
    """

    values: np.ndarray
    moments: Moments
    design: StandardDesign
    factor: float
    unit: str

    @classmethod
    def of(
        cls, run: BlockedRun, values: np.ndarray, design: StandardDesign, channel: int, noise: float
    ) -> Self:
        """noise: one standard deviation, rad/s or m/s²."""
        factor, unit = (float(np.degrees(noise)), "°/s") if channel < 3 else (noise, "m/s²")
        return cls(values, run.moments(values, design.known), design, factor, unit)

    @property
    def power(self) -> float:
        """The square sum."""
        return float(self.moments.second.sum())

    def formatted(self, value: float) -> str:
        """A value with its sign and unit; arithmetic that is no value is zero."""
        value = 0.0 if abs(value) < ROUNDING else value
        return f"{value * self.factor:+.2g} {self.unit}".replace("-", MINUS)


def noise_scales(noise: np.ndarray) -> np.ndarray:
    """The noise (6,); for a constant reading, which has none, that of its triad."""
    usable = np.isfinite(noise) & (noise > 0)
    filled = np.where(usable, noise, 1.0)
    for triad in (slice(0, 3), slice(3, 6)):
        if usable[triad].any():
            filled[triad][~usable[triad]] = np.median(noise[triad][usable[triad]])
    return filled


def rotations_of(
    motion: Motion, names: tuple[str, ...], segments: tuple[slice, ...]
) -> tuple[Rotation, ...]:
    """The table axes that turn; segments: rows of each."""
    if motion.axes is None:
        return ()
    turning = (
        (name, angle, [rows for rows in segments if _turns_whole(angle[rows])])
        for name, angle in zip(names, motion.axes.angles.T, strict=True)
    )
    return tuple(_rotation(*each) for each in turning if each[2])


def _turns_whole(angle: np.ndarray) -> bool:
    known = angle[np.isfinite(angle)]
    return bool(len(known) and np.ptp(known) >= WHOLE_TURN)


def _rotation(name: str, angle: np.ndarray, segments: list[slice]) -> Rotation:
    rows = np.concatenate([np.arange(each.start, each.stop) for each in segments])
    which = np.repeat(np.arange(len(segments)), [each.stop - each.start for each in segments])
    known = np.isfinite(angle[rows])
    rows, which = rows[known], which[known]
    cell = which * BINS + (angle[rows] / (2 * np.pi) % 1.0 * BINS).astype(int) % BINS
    counts = _per_segment(cell, len(segments), None).astype(float)
    basis = _basis()
    normal = np.einsum("sb,hbi,hbj->hsij", counts, basis, basis, optimize=True)
    inverse = np.linalg.pinv(normal, rcond=SINGULAR, hermitian=True)
    step = max(float(np.nanmedian(np.abs(np.diff(angle[each])))) for each in segments)
    return Rotation(name, rows, cell, inverse, np.pi / max(step, SINGULAR))


def _per_segment(cell: np.ndarray, segments: int, weights: np.ndarray | None) -> np.ndarray:
    """(segments, BINS) sums of weights, or counts, over the cells."""
    return np.bincount(cell, weights, segments * BINS).reshape(segments, BINS)


def _basis() -> np.ndarray:
    """(MAX_HARMONIC, BINS, 3): 1, cos hθ, sin hθ at the middles of the bins."""
    theta = 2 * np.pi * (np.arange(BINS) + 0.5) / BINS * np.arange(1, MAX_HARMONIC + 1)[:, None]
    return np.stack([np.ones_like(theta), np.cos(theta), np.sin(theta)], axis=-1)
