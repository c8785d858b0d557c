"""Divides the run into short blocks, with the cell of every partition that each belongs to."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from schemas.recording import Recording
from tasks.explain.inputs.shown_segments import shown_segments
from tasks.explain.locate.partitions import Partition, partitions_of
from tasks.model.regression import inverse
from tasks.model.terms.standard import regressors
from tasks.motion.whole import Motion, whole_motion
from tasks.words.rounding import MINUS

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
