"""Segment means that transmission errors do not affect, with the components of their noise."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Literal

import numpy as np

from schemas.recording import ACCEL, GYRO, MEASURED, TRIADS, Recording, Segment, Stream
from tasks.readings.plausibility import longest_run, steps
from tasks.readings.robust import TO_SIGMA, median

# Reads a segment's channels from memory once: extremes, block means, once-per-turn part.
#
# A segment of two million rows is larger than a processor's cache; each further question would
# read it again.

ROWS = 1 << 14  # of a piece: those of six channels stay in a processor's cache
BLOCKS = 32  # finest blocks of the Allan variances


@dataclass(frozen=True)
class Pass:
    """What one reading of c channels (n,) gives.

    low, high: (c,) extremes, NaN for a channel with NaN. mean: (c,). blocks: (c, blocks) means
    over BLOCKS blocks, fewer where there are fewer rows. periodic: (c, blocks) the part of them
    that comes back once a turn; zeros (c, 1) where no turn was asked for.
    """

    low: np.ndarray
    high: np.ndarray
    mean: np.ndarray
    blocks: np.ndarray
    periodic: np.ndarray


def one_pass(
    values: Sequence[np.ndarray], angle: Callable[[slice], np.ndarray] | None = None
) -> Pass:
    """Extremes and means of c channels (n ≥ 1,).

    angle: rad at some rows of a turn whose periodic part is wanted, by least squares of a
    constant, a cosine and a sine; the constant is left in.
    """
    count, channels = len(values[0]), len(values)
    blocks = min(BLOCKS, 1 << (count.bit_length() - 1))
    size = count // blocks
    low, high = np.full(channels, np.inf), np.full(channels, -np.inf)
    turning = 0 if angle is None else 2  # columns beside the channels: cosine and sine
    sums = np.zeros((channels + turning, blocks))
    products = np.zeros((channels + turning, 2))  # with cosine and sine
    for rows, within in _whole_blocks(count, blocks):
        parts = [channel[rows] for channel in values]
        low = np.minimum(low, [part.min() for part in parts])
        high = np.maximum(high, [part.max() for part in parts])
        if angle is not None:
            shapes = cosine_and_sine(angle(rows))
            parts += list(shapes)
            products += [shapes @ part for part in parts]
        whole = min(rows.stop, blocks * size) - rows.start
        sums[:, within] += _sums([part[:whole] for part in parts], within)
    total = sums.sum(axis=1) + [part[whole:].sum() for part in parts]
    periodic = np.zeros((channels, 1))
    if angle is not None:
        products -= np.outer(total, total[channels:]) / count  # without the constant
        turns = np.linalg.solve(products[channels:], products[:channels].T).T
        periodic = turns @ sums[channels:] / size
    return Pass(low, high, total[:channels] / count, sums[:channels] / size, periodic)


def _whole_blocks(rows: int, blocks: int) -> Iterator[tuple[slice, slice]]:
    """Pieces of so many rows that stay in the cache, and which blocks each lies in.

    A piece is some whole blocks or, where these are long, a part of one; to the last belong the
    few rows after the last block, which are in none.
    """
    size = rows // blocks
    at_once = max(1, ROWS // size)
    for first in range(0, blocks, at_once):
        within = slice(first, min(first + at_once, blocks))
        start = first * size
        for piece in pieces((within.stop - first) * size):
            stop = start + piece.stop
            yield slice(start + piece.start, stop if stop < blocks * size else rows), within


def _sums(parts: Iterable[np.ndarray], within: slice) -> np.ndarray:
    """(c, blocks) sums of c channels (n,) over the blocks that they are, or a part of one."""
    blocks = within.stop - within.start
    return np.array([part.reshape(blocks, -1).sum(axis=1) for part in parts])


def cosine_and_sine(angle: np.ndarray) -> np.ndarray:
    """Both (2, …) of an angle (…), rad.

    By the tangent of half the angle, which numpy has nine times as fast as cosine and sine.
    """
    half, both = np.tan(0.5 * angle), np.empty((2, *angle.shape))
    np.multiply(half, half, out=both[0])
    both[0] += 1.0
    np.divide(2.0, both[0], out=both[0])  # 1 + cosine
    np.multiply(half, both[0], out=both[1])
    both[0] -= 1.0
    return both


# Processes long columns piece by piece, so that each piece is read from memory once.
#
# A column of a hundred million rows is otherwise read again for every question, and its differences
# are as long as itself.


def pieces(count: int) -> Iterator[slice]:
    """The pieces of `count` rows, one after the other."""
    return (slice(start, min(start + ROWS, count)) for start in range(0, count, ROWS))


def extreme_steps(t: np.ndarray) -> tuple[float, float]:
    """Smallest and largest difference of neighbours among (n,) values; both NaN if one is, or if
    there are none.
    """
    extremes = []
    for piece in pieces(len(t) - 1):
        steps = t[piece.start + 1 : piece.stop + 1] - t[piece]
        extremes.append((steps.min(), steps.max()))
    low, high = np.array(extremes or [(np.nan, np.nan)]).T
    return float(low.min()), float(high.max())


# Allan variances of the block means of a segment.


def allan_variances(means: np.ndarray, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Allan variances of block means (c, blocks) at block lengths seconds/32, /16, /8, /4, /2.

    blocks: a power of two. Returns variances (levels, c) and block lengths (levels,) s.
    """
    apart, first = _neighbours_apart(means.shape[1])
    squares = (apart @ (means - means[:, :1]).T) ** 2
    compared = np.diff(first)
    sums = np.add.reduceat(squares, first[:-1]) if len(compared) else np.zeros((0, len(means)))
    return 0.5 * sums / compared[:, None], seconds / (compared + 1)


@cache
def _neighbours_apart(blocks: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows (…, blocks) that give by what neighbouring blocks, pairs of blocks, … differ, and the
    first row (levels + 1,) of each level and the row after the last.
    """
    rows, first, averages = np.zeros((0, blocks)), [0], np.eye(blocks)
    while len(averages) >= 2:
        rows = np.concatenate([rows, averages[1:] - averages[:-1]])
        first.append(len(rows))
        averages = 0.5 * (averages[::2] + averages[1::2])
    return rows, np.array(first)


Origin = Literal["label", "found"]
CHANNELS: tuple[str, ...] = GYRO + ACCEL
GYRO_COLUMNS = slice(0, 3)
ACCEL_COLUMNS = slice(3, 6)
SAMPLE_ROWS = 2000  # rows that centre and scale are taken from; enough for a median
PLACES = np.arange(SAMPLE_ROWS) * (np.sqrt(5.0) - 1.0) / 2.0 % 1.0  # of the rows, by golden section
GLANCE_ROWS = 200  # rows that already show that every row of a segment is near
GLANCE = 0.7  # of the reach that they give: it is known within a fifth
REACH = 10.0  # robust standard deviations beyond which a row is not this segment's signal
# Shares of a sample between which its bulk lies in any case: where a correction was taken off
# coarse readings their steps are not known, and rows of a neighbouring code are not corrupted.
CENTRAL = (0.02, 0.98)
CENTRAL_SIGMAS = 4.1  # of a normal distribution between them
MOST_WIDENED = 0.5  # of the rows: more beside bursts are not left out for their sake
NEAR_STEPS = 4.5  # steps of a coarse channel that its noise can reach
MIN_ROWS = 4  # a segment with fewer has no mean to speak of
FEW_LOST = 0.1  # of a segment in one stretch without a triad: else its mean is of another time
LONGEST_BURST = 3  # rows: a corrupted frame or two; anything longer moved


@dataclass(frozen=True)
class SegmentMean:
    """One segment, summarised.

    mean: (6,) gyro rad/s then accelerometer m/s², NaN where a triad was not recorded.
    blocks: (6, blocks) means over 32 equal parts, fewer where there are fewer rows.
    allan: (levels, 6) Allan variances of the block means, finest blocks first.
    tau: (levels,) s, the blocks' lengths.
    left_out: rows that a channel shows to be corrupted; they are in no mean.
    far_rows: (6,) how many of them each channel showed.
    longest_burst: the longest run of them.
    step: (6,) smallest difference between two readings of the channel in the whole recording.
    deviation: (6,) standard deviation of the rows.
    intervals: shortest and longest time from one row to the next, s; NaN for a single row.
    place: its rows in the stream.
    """

    segment: Segment
    origin: Origin
    rows: int
    t_start: float
    t_end: float
    mean: np.ndarray
    blocks: np.ndarray
    allan: np.ndarray
    tau: np.ndarray
    left_out: int
    far_rows: np.ndarray
    longest_burst: int
    step: np.ndarray
    deviation: np.ndarray
    intervals: tuple[float, float]
    place: slice

    @property
    def seconds(self) -> float:
        return self.t_end - self.t_start

    @cached_property
    def has_gyro(self) -> bool:
        return bool(np.isfinite(self.mean[GYRO_COLUMNS]).all())

    @cached_property
    def has_accel(self) -> bool:
        return bool(np.isfinite(self.mean[ACCEL_COLUMNS]).all())


def rows_of(recording: Recording, segment: Segment) -> int:
    """How many rows of the unit's stream a segment has."""
    rows = recording.imu.rows(segment.t_start, segment.t_end)
    return rows.stop - rows.start


def coarsely_quantised(segment: SegmentMean) -> np.ndarray:
    """Which channels (6,) have a step of more than two standard deviations of their noise.

    Their means can be wrong by up to half a step, however many rows there are. Noise of half a
    step and rounding together make a third of a squared step (Sheppard's correction).
    """
    return segment.deviation < segment.step / np.sqrt(3.0)


def far_rows(channel: np.ndarray, step: float = 0.0) -> np.ndarray | None:
    """Which entries of a channel (n,) lie far from its bulk, (n,) bool; None where none does.

    Rows a few steps of the channel away are near. A channel that was not recorded (NaN) has none.
    """
    samples = _samples([channel])
    return _far_by_channel([channel], one_pass([channel]), samples, np.array([step])).get(0)


def _centre_and_spread(samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Median (c,) of each channel's sample (c, m), and its median absolute deviation as 1 sigma."""
    centre = median(samples)
    return centre, TO_SIGMA * median(np.abs(samples - centre[:, None]))


def _reach(centre: np.ndarray, spread: np.ndarray, step: np.ndarray) -> np.ndarray:
    """How far (c,) from its centre a channel's bulk reaches at the least.

    One code, and what a float resolves, is no spread.
    """
    resolution = 8 * np.finfo(float).eps * np.abs(centre)
    return REACH * np.maximum(spread, np.maximum(resolution, NEAR_STEPS * step / REACH))


def _bulk(samples: np.ndarray, step: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centre (c,) of each channel's sample (c, m), and how far (c,) its bulk reaches from there.

    From the median, its absolute deviation and the CENTRAL range, so that a spike, or a fiftieth
    of the rows, cannot hide itself. NaN for a sample with NaN in it.
    """
    centre, spread = _centre_and_spread(samples)
    places = [int(share * (samples.shape[1] - 1)) for share in CENTRAL]
    low, high = np.partition(samples, places)[:, places].T
    return centre, _reach(centre, np.maximum(spread, (high - low) / CENTRAL_SIGMAS), step)


def _evenly_placed(rows: int, wanted: int) -> np.ndarray:
    """So many of a number of rows, spread evenly and with no period that spikes could share."""
    return (PLACES[:wanted] * rows).astype(int)


def _samples(values: Sequence[np.ndarray]) -> np.ndarray:
    """The sample (c, m) of each of c channels (n,): all rows, or SAMPLE_ROWS of them."""
    if len(values[0]) <= SAMPLE_ROWS:
        return np.array(values)
    rows = _evenly_placed(len(values[0]), SAMPLE_ROWS)
    return np.array([channel[rows] for channel in values])


def widened(corrupt: np.ndarray) -> np.ndarray:
    """A burst of far rows with its own length added on both sides, where it came and went; the far
    rows alone where that would take in half the segment.
    """
    burst = longest_run(corrupt)
    if burst <= LONGEST_BURST:
        return corrupt
    count = np.concatenate(([0], np.cumsum(corrupt)))
    row = np.arange(len(corrupt))
    near = count[np.minimum(row + burst + 1, len(corrupt))] > count[np.maximum(row - burst, 0)]
    return corrupt if near.mean() > MOST_WIDENED else near


def summarise(
    imu: Stream,
    segment: Segment,
    origin: Origin,
    step: np.ndarray | None = None,
) -> SegmentMean | None:
    """The summary of one segment, or None where the recording has no row of it.

    step: (6,) of the channels, looked for in the stream where it is not given.
    """
    rows = imu.rows(segment.t_start, segment.t_end)
    if rows.stop <= rows.start:
        return None
    step = steps(imu) if step is None else step
    whole, own = _summary(imu, rows, segment, origin, step), imu.at(rows)
    for triad in TRIADS:
        if not np.isnan(whole.mean[CHANNELS.index(triad[0])]):
            continue
        read = np.isfinite(own.channels(triad, slice(0, len(own)))).all(axis=0)
        if longest_run(~read) < FEW_LOST * len(read) and read.sum() >= MIN_ROWS:
            found = _summary(own.at(read), slice(0, int(read.sum())), segment, origin, step)
            whole = _with_triad(whole, found, [CHANNELS.index(c) for c in triad])
    return whole


def _with_triad(whole: SegmentMean, part: SegmentMean, own: list[int]) -> SegmentMean:
    """A summary with the channels of a triad that was read in a part of the rows; as it is where
    these are too few for the same blocks.
    """
    if part.blocks.shape != whole.blocks.shape or part.allan.shape != whole.allan.shape:
        return whole
    mine = np.isin(np.arange(len(CHANNELS)), own)
    names = ("mean", "allan", "deviation", "far_rows")
    merged = {name: np.where(mine, getattr(part, name), getattr(whole, name)) for name in names}
    return replace(
        whole, **merged, blocks=np.where(mine[:, None], part.blocks, whole.blocks),
        left_out=max(whole.left_out, part.left_out),
        longest_burst=max(whole.longest_burst, part.longest_burst),
    )  # fmt: skip


def _summary(
    imu: Stream, rows: slice, segment: Segment, origin: Origin, step: np.ndarray
) -> SegmentMean:
    t = imu.t[rows]
    values = imu.views(CHANNELS, rows)
    seconds = float(t[-1] - t[0]) * len(t) / max(1, len(t) - 1)
    left_out, longest_burst = 0, 0
    read = one_pass(values, _angle(t, segment))
    samples = _samples(values)  # after the pass, which left the rows in the processor's cache
    far = {} if segment.kind == "rotation" else _far_by_channel(values, read, samples, step)
    if far:
        corrupt = widened(np.any(list(far.values()), axis=0))
        kept = [channel[~corrupt] for channel in values]
        samples = _samples(kept)
        read = one_pass(kept, _angle(t[~corrupt], segment))
        left_out, longest_burst = int(corrupt.sum()), longest_run(corrupt)
    allan, tau = allan_variances(read.blocks - read.periodic, seconds)
    return SegmentMean(
        segment=segment,
        origin=origin,
        rows=len(t),
        t_start=float(t[0]),
        t_end=float(t[0]) + seconds,
        mean=read.mean,
        blocks=read.blocks,
        allan=allan,
        tau=tau,
        left_out=left_out,
        far_rows=np.array([far[c].sum() if c in far else 0 for c in range(len(CHANNELS))]),
        longest_burst=longest_burst,
        step=step,
        deviation=samples.std(axis=1),
        intervals=extreme_steps(t),
        place=rows,
    )


def _angle(t: np.ndarray, segment: Segment) -> Callable[[slice], np.ndarray] | None:
    """The angle (rad) turned at a held rate by some of the rows at t (n,) s.

    What comes back once a turn is no noise: the ripple of the table, the level parts of Earth's
    rotation and of gravity average out over whole turns. Where less than one was made, nothing is
    known of them: None.
    """
    rate = np.radians(segment.rate_deg_s or 0.0)
    if segment.kind != "rate" or abs(rate) * (t[-1] - t[0]) < 2.0 * np.pi:
        return None
    return lambda rows: rate * (t[rows] - t[0])


def _far_by_channel(
    values: Sequence[np.ndarray], read: Pass, samples: np.ndarray, step: np.ndarray
) -> dict[int, np.ndarray]:
    """The far rows of each channel that has any."""
    few = samples[:, _evenly_placed(samples.shape[1], GLANCE_ROWS)]
    # The deviation alone: of few rows a single burst can fill the range.
    centre, spread = _centre_and_spread(few)
    reach = _reach(centre, spread, step)
    beyond = (read.high > centre + GLANCE * reach) | (read.low < centre - GLANCE * reach)
    if not beyond.any():
        return {}
    centre, reach = _bulk(samples, step)
    # A comparison with NaN, of a channel that was not recorded, is false.
    with_far = np.flatnonzero((read.high > centre + reach) | (read.low < centre - reach)).tolist()
    return {c: np.abs(values[c] - centre[c]) > reach[c] for c in with_far}


def summarise_all(
    recording: Recording, segments: tuple[Segment, ...], origin: Origin
) -> tuple[SegmentMean, ...]:
    """Summaries of every static, rate and rotation segment that the recording has rows of."""
    measured = (s for s in segments if s.kind in MEASURED)
    step = steps(recording.imu)
    summaries = (summarise(recording.imu, segment, origin, step) for segment in measured)
    return tuple(summary for summary in summaries if summary is not None)
