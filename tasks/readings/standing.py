"""Readings that stand still: channels that are held while the unit moves, and steps of an output
that are wider than its noise.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from schemas.recording import ACCEL, GYRO, TRIADS, Recording, Segment, Stream
from schemas.text import Remark
from tasks.readings.implausible import found_on_sight
from tasks.readings.robust import median
from tasks.words import message
from tasks.words.quantities import plain

CHANNELS = GYRO + ACCEL
STUCK_SECONDS = 2.0
FEWEST = 20  # rows that stand
LATER = 8  # rows: what repeats as often after so many is coarse, and not held
PARTS, PART_ROWS = 4, 1000  # parts of a segment that are looked at, and rows of each
HELD = 0.05  # of the rows of a segment, beyond what is usual in those of its kind
BEYOND = 3.0  # times what is usual there
BY_CHANCE = 6.0  # standard deviations of such a share
FEW_ROWS = 100  # of a segment: too few to tell
STEP_ROWS = 8000  # rows that a step is looked for in
FEW_ALIKE = 3  # segments of a kind that show what is usual


def longest_repeat(values: np.ndarray) -> tuple[int, int]:
    """First row and length of the longest run of one value in (n,)."""
    changes = np.flatnonzero(np.diff(values)) + 1
    edges = np.concatenate(([0], changes, [len(values)]))
    lengths = np.diff(edges)
    longest = int(lengths.argmax())
    return int(edges[longest]), int(lengths[longest])


def longest_run(flags: np.ndarray) -> int:
    """Length of the longest run of True in (n,) flags."""
    return int(np.diff(runs(flags), axis=1).max(initial=0))


def runs(flags: np.ndarray) -> np.ndarray:
    """First row of each run of True in (n,) flags, and the row after its last; (runs, 2)."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int8), [0]))))
    return edges.reshape(-1, 2)


def standing(recording: Recording, segment: Segment) -> Iterator[tuple[int, int, int]]:
    """The channels that stand at one value for long in a segment, with the first row of the
    recording and the number of rows."""
    place = recording.imu.rows(segment.t_start, segment.t_end)
    rows = place.stop - place.start
    if segment.kind == "rotation" or rows < 2:
        return
    t = recording.imu.t[place]
    interval = float(t[-1] - t[0]) / (rows - 1)
    shortest = min(max(FEWEST, round(STUCK_SECONDS / interval)), rows)
    views = recording.imu.views(CHANNELS, place)
    # A run of `shortest` rows holds two neighbours of a sample that takes every half of it.
    sample = np.array([values[:: max(1, shortest // 2)] for values in views])
    repeats = (sample[:, 1:] == sample[:, :-1]).any(axis=1) | (sample.shape[1] == 1)
    for channel in np.flatnonzero(repeats).tolist():
        start, length = longest_repeat(views[channel])
        if length >= shortest:
            yield channel, place.start + start, length


def coarse_where_it_moves(recording: Recording, segments: Sequence[Segment]) -> np.ndarray:
    """Channels (6,) whose step is wider than their noise in most segments in which they move; of
    one that moves in none, whether it stands at different values.
    """
    imu = recording.imu
    places = [imu.rows(s.t_start, s.t_end) for s in segments if s.kind != "rotation"]
    parts = [
        imu.channels(CHANNELS, slice(place.start, min(place.stop, place.start + PART_ROWS)))
        for place in places
        if place.stop - place.start > 1
    ]
    if not parts:
        return np.zeros(len(CHANNELS), bool)
    step = steps(imu)
    deviation = np.array([part.std(axis=1) for part in parts])
    moves = deviation > 1e-6 * step
    hidden = (deviation < step / np.sqrt(3.0)) & moves  # Sheppard: noise of less than half a step
    stands = [len(set(one)) > 1 for one in np.array([part[:, 0] for part in parts]).T.tolist()]
    most = hidden.sum(axis=0) > 0.5 * moves.sum(axis=0)
    return np.asarray(np.where(moves.any(axis=0), most, stands))


def coarse_remarks(recording: Recording, segments: Sequence[Segment]) -> Iterator[Remark]:
    """One remark for a triad whose channels stand at one code, for they are logged coarsely."""
    stood = {s.name: {c for c, _, _ in standing(recording, s)} for s in segments}
    if not any(stood.values()):
        return
    coarse = coarse_where_it_moves(recording, segments)
    step = steps(recording.imu)
    for k, triad in enumerate(TRIADS):
        own = {c for c in range(3 * k, 3 * k + 3) if coarse[c]}
        names = tuple(name for name, channels in stood.items() if channels & own)
        if names:
            count = sum(len(channels & own) for channels in stood.values())
            yield found_on_sight(
                "coarse_log",
                message("plausibility-coarse-log", sensors=triad[0][:-2], count=count,
                        segments=len(names), of=len(segments), step=plain(max(step[list(own)]), 3)),
                names, run="remarks",
            )  # fmt: skip


def held_remarks(recording: Recording, segments: Sequence[Segment]) -> Iterator[Remark]:
    """Segments in which rows repeat the row before far more often than in others of their kind.

    What is logged faster than it is read repeats rows in all of them; what is coarse repeats them
    as often a few rows later.
    """
    for still in (True, False):
        own, of_own = list[Segment](), list[tuple[int, np.ndarray, np.ndarray]]()
        for segment in (s for s in segments if (s.kind == "static") == still):
            part = _parts(recording, segment)
            if part.shape[1] >= FEW_ROWS:
                own.append(segment)
                of_own.append((part.shape[1], _again(part, 1), _again(part, LATER)))
        if len(own) <= FEW_ALIKE:
            continue
        rows, shares, later = map(np.array, zip(*of_own, strict=True))
        beyond = shares - later
        usual = np.maximum(median(np.abs(beyond).T), 0.0)
        chance = BY_CHANCE * np.sqrt(2.0 * shares * (1.0 - shares) / rows[:, None])
        held = beyond > np.maximum(HELD, chance) + BEYOND * usual
        for k, triad in enumerate(TRIADS):
            mine = held[:, 3 * k : 3 * k + 3]
            names = tuple(own[i].name for i in np.flatnonzero(mine.any(axis=1)))
            if names and len(names) < 0.5 * len(own):
                worst = float(shares[:, 3 * k : 3 * k + 3][mine].max())
                yield found_on_sight(
                    "held_rows",
                    message("plausibility-held-rows", sensors=triad[0][:-2], count=len(names),
                            listed=", ".join(names), share=plain(100.0 * worst, 2),
                            usual=plain(100.0 * float(np.median(shares[:, 3 * k : 3 * k + 3])), 2)),
                    names, run="remarks",
                )  # fmt: skip


def _parts(recording: Recording, segment: Segment) -> np.ndarray:
    """(6, n) of a segment's readings: all, or some stretches of it."""
    place = recording.imu.rows(segment.t_start, segment.t_end)
    rows = place.stop - place.start
    if rows <= PARTS * PART_ROWS:
        return recording.imu.channels(CHANNELS, place)
    starts = place.start + np.linspace(0, rows - PART_ROWS, PARTS).astype(int)
    taken = [recording.imu.channels(CHANNELS, slice(a, a + PART_ROWS)) for a in starts.tolist()]
    return np.hstack(taken)


def _again(values: np.ndarray, later: int) -> np.ndarray:
    """(c,) share of the readings of channels (c, n) that are those of so many rows before."""
    return np.asarray((values[:, later:] == values[:, :-later]).mean(axis=1))


def steps(imu: Stream) -> np.ndarray:
    """(6,) the smallest difference between two readings of each channel, 0 where all are one."""
    every = max(1, len(imu.t) // STEP_ROWS)
    smallest = np.zeros(len(CHANNELS))
    for channel, name in enumerate(CHANNELS):
        if name in imu.columns:
            sample = imu.columns[name][::every]
            sample = np.sort(sample[np.isfinite(sample)])  # rows without the triad say nothing
            apart = np.diff(sample)
            resolution = 8 * np.finfo(float).eps * np.abs(sample).max(initial=0.0)
            smallest[channel] = apart[apart > resolution].min(initial=np.inf)
    return np.where(np.isfinite(smallest), smallest, 0.0)
