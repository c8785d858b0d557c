"""Divides the run into short blocks, with the cell of every partition that each belongs to."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from schemas.recording import Recording
from tasks.explain.locate.partitions import Partition, partitions_of
from tasks.explain.locate.rotation import Rotation, rotations_of
from tasks.motion.whole import Motion, whole_motion
from tasks.segments.find import segments_of

BLOCK = 0.04  # s: the finest resolution
MIN_INTERVALS = 30  # that the shortest run is taken for


@dataclass(frozen=True)
class Moments:
    """Of an excess e over k parts of the run: number of rows, Σe and Σe², (k,) each."""

    rows: np.ndarray
    first: np.ndarray
    second: np.ndarray


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
        segments = segments_of(recording)
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
