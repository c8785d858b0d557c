"""When samples were taken, from their stamps alone.

A logger that stamps rows as packets arrive gives the rows of a packet nearly one time, and the next
packet's a time as much later as that one has samples. The last sample of a packet was taken less
than one sampling interval before the packet was sent, however many it has, so that the ends of
packets, over the number of samples until then, show the sampling rate and what is missing; the
instants between are even. What the packets' way takes on average no stamp shows: the instants keep
the mean of the stamps, and one delay of all is left to be found.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import median_filter

from schemas.recording import Recording, Stream
from tasks.motion.samples import NORMAL_QUANTILES
from tasks.readings.judge import CERTAIN, log_odds
from tasks.readings.robust import TO_SIGMA, deviation, median
from tasks.words import message, remark

TOGETHER = 0.35  # of the sampling interval: rows nearer to each other came in one packet
APART = 0.65  # rows farther from each other did not; few are between
BETWEEN = 0.1  # of the rows that came together: more between, and stamps scatter
FEWEST = 20  # packets
GLANCE = 50_000  # rows that show whether there are any
LEAST = 0.05  # of the packets: those of more than one row
NEAR = 31  # packets, at most, whose median tells a loss
LOST = 0.6  # of the sampling interval by which packets stay late where a sample is missing
CLEAR = 6.0  # times the scatter of such medians
BLOCK = 100  # packets: over as many a clock wanders
WANDERING = 3.0  # times what the scatter of packets makes of their means
FAR = 5.0  # times the usual time between packets: more is a gap, and no part of the rate
HELD = 4.0  # s: no logger holds samples back for longer, so that a longer step is a pause
ARRIVING = 0.5  # s that a packet takes to arrive: rows that take longer were sampled as they came
STEADY = 0.05  # of the sampling interval: standard deviation of arrivals, at least
ROWS = 60_000  # that are compared with their neighbours


@dataclass(frozen=True)
class Packets:
    """The instants of rows that were stamped as packets arrived.

    t: (n,) s, even but where samples are missing, with the mean of the stamps. interval: s. u: s,
    standard uncertainty of an instant beside one delay of all. count: of packets. missing: (k, 2)
    the row after which samples are missing, and how many. odds: log odds, by the time between
    packets, that these follow the number of their rows, against pauses.
    """

    t: np.ndarray
    interval: float
    u: float
    count: int
    missing: np.ndarray
    odds: float

    @property
    def size(self) -> float:
        """Samples in a packet, on average."""
        return len(self.t) / self.count


def with_instants(recording: Recording) -> Recording:
    """The recording with the unit's stamps put right where they came in packets, which it says;
    itself where they did not."""
    imu = recording.imu
    packets = in_packets(imu.t)
    if packets is None or packets.odds + _in_line(imu, packets.t) < CERTAIN:
        return recording
    late, every = imu.t - packets.t, packets.size * packets.interval
    sentence = message(
        "stamps-packets", size=f"{packets.size:.3g}", every=f"{1e3 * every:.3g}",
        rate=f"{1.0 / packets.interval:.4g}", most=f"{1e3 * float(np.ptp(late)):.2g}",
        u=f"{1e3 * packets.u:.1g}", missing=int(packets.missing[:, 1].sum()),
    )  # fmt: skip
    right = replace(imu, t=packets.t)
    return replace(
        recording,
        imu=right,
        put_right=(*recording.put_right, remark("stamps_in_packets", sentence)),
    )


def in_packets(t: np.ndarray) -> Packets | None:
    """The instants of rows stamped t (n,) s, not falling; None where none came in packets."""
    if (
        _came_together(np.diff(t[:GLANCE])) is None
        or (together := _came_together(np.diff(t))) is None
    ):
        return None
    last = np.append(np.flatnonzero(~together), len(t) - 1)  # rows: of each packet
    if len(last) < FEWEST or np.median(t[last[1:]] - t[last[:-1] + 1]) > ARRIVING:
        return None
    interval, breaks = _rate_and_breaks(t[last], last)
    instants, u = _even(t, last, interval, breaks)
    rows = last[breaks]
    missing = np.round((instants[rows + 1] - instants[rows]) / interval - 1).astype(int)
    lost = missing > 0
    instants = np.round(instants, 9)  # as stamps are kept
    step, size = np.diff(t[last]), np.diff(last)
    off = step - interval * size
    usual = np.full(len(off), max(deviation(off), STEADY * interval))
    odds = float(log_odds(off, step - interval, usual))
    return Packets(instants, interval, u, len(last), np.column_stack([rows, missing])[lost], odds)


def _came_together(steps: np.ndarray) -> np.ndarray | None:
    """Which rows (n - 1,) bool came with the one before, by the steps (n - 1,) s between stamps;
    None where stamps are even or merely scatter.
    """
    if len(steps) < 2 * FEWEST:
        return None
    steps = np.minimum(steps, HELD)
    interval = float(np.minimum(steps, FAR * _step_of_most_time(steps[steps < HELD])).mean())
    together = steps < TOGETHER * interval
    between = np.count_nonzero((steps < APART * interval) & ~together)
    edges = np.flatnonzero(np.diff(together, prepend=False, append=False))
    sizes = edges[1::2] - edges[::2]
    # One that is far larger than all others is a backlog.
    usual = int(sizes.sum() - sizes.max(initial=0))
    few = len(sizes) < LEAST * np.count_nonzero(~together) or between > BETWEEN * usual
    return None if few else together


def _step_of_most_time(steps: np.ndarray) -> float:
    """The step (s) that a moment of the recording usually lies in: from packet to packet."""
    ordered = np.sort(steps)
    passed = np.cumsum(ordered)
    return float(ordered[np.searchsorted(passed, 0.5 * passed[-1])]) if len(steps) else HELD


def _rate_and_breaks(at: np.ndarray, last: np.ndarray) -> tuple[float, np.ndarray]:
    """The sampling interval (s) by packets that end at (k,) s with the rows `last` (k,), and after
    which of them samples are missing.
    """
    breaks = np.empty(0, int)
    reach = max(1, min(4 * NEAR, len(at) // 16))  # few of them hold a loss
    interval = float(np.median((at[reach:] - at[:-reach]) / (last[reach:] - last[:-reach])))
    for _ in range(3):
        late = at - interval * last
        found = _late_from(late, interval)
        stretch = np.searchsorted(found, np.arange(len(at)), side="left")
        count = np.bincount(stretch)
        x = last - (np.bincount(stretch, last) / count)[stretch]
        y = late - (np.bincount(stretch, late) / count)[stretch]
        interval += float(x @ y / max(float(x @ x), 1.0))
        if np.array_equal(found, breaks):
            break
        breaks = found
    return interval, breaks


def _late_from(late: np.ndarray, interval: float) -> np.ndarray:
    """(k,) packets after which the course of how late they are (n,) s stays higher by a sample or
    more. What is missing beside the first or last packets no course tells.
    """
    near = min(NEAR, len(late) // 6 | 1)
    half = near // 2
    middle = median_filter(late, near, mode="nearest")
    before, after = np.arange(len(late) - 1) - half, np.arange(1, len(late)) + half
    rise = middle[after.clip(0, len(late) - 1)] - middle[before.clip(0, len(late) - 1)]
    limit = max(
        LOST * interval,
        CLEAR * float(np.median(np.abs(rise - np.median(rise)))) / NORMAL_QUANTILES[0.5],
    )
    step = np.diff(late)
    high = np.flatnonzero(rise > limit)
    found: list[int] = []
    for near_by in np.split(high, np.flatnonzero(np.diff(high) > half) + 1) if len(high) else ():
        place = int(near_by[(rise + step)[near_by].argmax()])
        if half <= place < len(step) - half:
            found.append(place)
    return np.array(found, int)


def _even(
    t: np.ndarray, last: np.ndarray, interval: float, breaks: np.ndarray
) -> tuple[np.ndarray, float]:
    """(n,) s even instants between the breaks, and their standard uncertainty."""
    late, u = t[last] - interval * last, 0.0
    course = np.empty(len(last))
    for start, stop in pairwise([0, *(breaks + 1).tolist(), len(last)]):
        part = slice(start, stop)
        course[part] = _wander(late[part])
        together = BLOCK if np.ptp(course[part]) else stop - start
        u = max(u, float(np.std(late[part] - course[part])) / np.sqrt(together))
    # Beyond the last packet before a break there is none to be drawn to.
    packet = np.searchsorted(last, np.arange(len(t)))
    even = interval * np.arange(len(t)) + course[packet]
    even += float((t - even).mean())
    return even, u


def _wander(late: np.ndarray) -> np.ndarray:
    """How late packets (n,) s are on the whole: one number, or the course of a clock that wanders
    against the other by more than their scatter makes of it.
    """
    blocks = len(late) // BLOCK
    mean = np.full(len(late), float(late.mean()))
    if blocks < 3:
        return mean
    whole = late[: blocks * BLOCK].reshape(blocks, BLOCK)
    means = whole.mean(axis=1)
    by_chance = float(np.sqrt((whole.var(axis=1) / BLOCK).mean()))
    if np.std(means) < WANDERING * by_chance:
        return mean
    middles = (np.arange(blocks) + 0.5) * BLOCK - 0.5
    return np.interp(np.arange(len(late)), middles, means)


def _in_line(imu: Stream, even: np.ndarray) -> float:
    """Log odds that readings were taken at even times (n,) s, and not in bursts when they were
    stamped, by how far they lie off the lines between their neighbours.
    """
    rows = np.arange(1, len(imu) - 1)[:: len(imu) // ROWS + 1]
    readings = np.array(list(imu.columns.values()))
    off, was = (_off_line(at, readings, rows) for at in (even, imu.t))
    known = np.isfinite(off)
    usual = TO_SIGMA * np.minimum(*(_middle(each) for each in (off, was)))
    known &= usual > 0.0
    usual = np.broadcast_to(usual, off.shape)
    return float(log_odds(off[known], was[known], usual[known]))


def _middle(off: np.ndarray) -> np.ndarray:
    """(c, 1) medians of the sizes of (c, n) that are known; NaN of none."""
    return np.array(
        [
            [float(median(np.abs(c[np.isfinite(c)])))] if np.isfinite(c).any() else [np.nan]
            for c in off
        ]
    )


def _off_line(at: np.ndarray, readings: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """(c, k) by how far readings (c, n) at times (n,) s lie off the lines between their neighbours
    in some rows (k,), over what white noise makes of that.
    """
    share = (at[rows] - at[rows - 1]) / np.maximum(at[rows + 1] - at[rows - 1], 1e-12)
    before, here, after = (readings[:, rows + k] for k in (-1, 0, 1))
    off = here - before - share * (after - before)
    return np.asarray(off / np.sqrt(1.0 + share**2 + (1.0 - share) ** 2))
