"""The run in short blocks: what each belongs to, once for all findings."""

from dataclasses import dataclass

import numpy as np

from schemas.recording import Recording, Segment
from tasks.explain.locate.motions import by_attitude, by_heading, by_moves, by_ramps, by_rate
from tasks.explain.locate.records import by_records, by_time
from tasks.explain.locate.regime import Regime
from tasks.explain.locate.turns import Turns, turns_of
from tasks.motion.whole import Motion, whole_motion
from tasks.segments.find import find_segments

FINEST = 0.04  # s: shorter is not told apart
FEWEST = 30  # stretches that the shortest run is taken for


@dataclass(frozen=True)
class Sums:
    """Of the excess e over parts of the run: rows, Σe and Σe², (k,) each."""

    rows: np.ndarray
    first: np.ndarray
    second: np.ndarray


@dataclass(frozen=True)
class Run:
    """A recording of n rows in m blocks of 0.04 s or of one row, whichever is longer.

    motion: at the rows. starts: (m,) first row of each block. t: (m,) s, its middle.
    names: of the segments. segment: (m,) which one a block lies in, −1 for none.
    """

    motion: Motion
    starts: np.ndarray
    t: np.ndarray
    names: tuple[str, ...]
    segment: np.ndarray
    regimes: tuple[Regime, ...]
    turns: tuple[Turns, ...]

    @classmethod
    def of(cls, recording: Recording) -> "Run":
        """The run of a recording; where segments carry no labels they are found."""
        motion = whole_motion(recording)
        segments = segments_of(recording)
        starts = _block_starts(motion.t)
        middle = (starts + np.append(starts[1:], len(motion.t))) // 2
        t = motion.t[middle]
        segment = np.full(len(t), -1)
        for k, each in enumerate(segments):
            segment[slice(*np.searchsorted(t, (each.t_start, each.t_end)))] = k
        axes = tuple(axis.name for axis in recording.manifest.station.table_axes or ())
        rows = tuple(recording.imu.rows(each.t_start, each.t_end) for each in segments)
        return cls(
            motion, starts, t, tuple(each.name for each in segments), segment,
            _regimes(recording, motion.taken(middle), segments, segment),
            turns_of(motion, axes, rows),
        )  # fmt: skip

    @property
    def pieces(self) -> int:
        """How many stretches the run is made of: what a pattern rests on."""
        return max(FEWEST, len(self.names))

    def summed(self, values: np.ndarray) -> np.ndarray:
        """Sums of values (n, …) over the blocks, (m, …)."""
        return np.add.reduceat(values, self.starts, axis=0)

    def sums(self, course: np.ndarray, known: np.ndarray) -> Sums:
        """The blocks' sums of a course (n,) over its known rows (n,); it is zero elsewhere."""
        return Sums(self.summed(known.astype(float)), self.summed(course), self.summed(course**2))


def segments_of(recording: Recording) -> tuple[Segment, ...]:
    """The labelled segments in the order of time, or those found where there are no labels."""
    labelled = recording.manifest.segments or find_segments(recording)
    return tuple(sorted(labelled, key=lambda each: each.t_start))


def _block_starts(t: np.ndarray) -> np.ndarray:
    """(m,) first row of each block."""
    interval = float(np.median(np.diff(t))) if len(t) > 1 else FINEST
    return np.arange(0, len(t), max(1, int(FINEST / interval + 1e-6)))


def _regimes(
    recording: Recording, motion: Motion, segments: tuple[Segment, ...], segment: np.ndarray
) -> tuple[Regime, ...]:
    """Every way that parts this run into two cells or more; motion: at the blocks' middles."""
    every = (
        *by_rate(motion, segments, segment), by_attitude(motion), *by_heading(motion),
        *by_moves(motion), by_ramps(motion), by_time(motion.t),
        *by_records(recording, motion.t),
    )  # fmt: skip
    return tuple(each for each in every if len(np.unique(each.cell[each.cell >= 0])) > 1)
