"""When samples were taken, from their stamps alone.

A logger that stamps rows as packets arrive gives the rows of a packet nearly one time, and the next
packet's a time as much later as that one has samples. The last sample of a packet was taken less
than one sampling interval before the packet was sent, however many it has, so that the ends of
packets, over the number of samples until then, show the sampling rate and what is missing; the
instants between are even. What the packets' way takes on average no stamp shows: the instants keep
the mean of the stamps, and one delay of all is left to be found.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.ndimage import median_filter

from schemas.recording import Recording, Stream
from tasks.motion.samples import NORMAL_QUANTILES, interpolated, noise_by_differences
from tasks.readings.judge import CERTAIN, log_odds
from tasks.readings.robust import TO_SIGMA, deviation, median
from tasks.words import message, remark

TOGETHER = 0.35  # of the sampling interval: rows nearer to each other came in one packet
APART = 0.65  # rows farther from each other did not; few are between
BETWEEN = 0.1  # of the rows that came together: more between, and stamps scatter
FEWEST_PACKETS = 20  # packets
GLANCE = 50_000  # rows that show whether there are any
LEAST = 0.05  # of the packets: those of more than one row
PACKETS_BESIDE = 31  # packets, at most, whose median tells a loss
LOST = 0.6  # of the sampling interval by which packets stay late where a sample is missing
CLEAR_LOSS = 6.0  # times the scatter of such medians
BLOCK = 100  # packets: over as many a clock wanders
WANDERING = 3.0  # times what the scatter of packets makes of their means
GAP_IN_PACKETS = 5.0  # times the usual time between packets: more is a gap, and no part of the rate
HELD = 4.0  # s: no logger holds samples back for longer, so that a longer step is a pause
ARRIVING = 0.5  # s that a packet takes to arrive: rows that take longer were sampled as they came
STEADY = 0.05  # of the sampling interval: standard deviation of arrivals, at least
COMPARED_ROWS = 60_000  # that are compared with their neighbours


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
    if len(last) < FEWEST_PACKETS or np.median(t[last[1:]] - t[last[:-1] + 1]) > ARRIVING:
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
    if len(steps) < 2 * FEWEST_PACKETS:
        return None
    steps = np.minimum(steps, HELD)
    interval = float(
        np.minimum(steps, GAP_IN_PACKETS * _step_of_most_time(steps[steps < HELD])).mean()
    )
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
    reach = max(1, min(4 * PACKETS_BESIDE, len(at) // 16))  # few of them hold a loss
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
    near = min(PACKETS_BESIDE, len(late) // 6 | 1)
    half = near // 2
    middle = median_filter(late, near, mode="nearest")
    before, after = np.arange(len(late) - 1) - half, np.arange(1, len(late)) + half
    rise = middle[after.clip(0, len(late) - 1)] - middle[before.clip(0, len(late) - 1)]
    limit = max(
        LOST * interval,
        CLEAR_LOSS * float(np.median(np.abs(rise - np.median(rise)))) / NORMAL_QUANTILES[0.5],
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
    rows = np.arange(1, len(imu) - 1)[:: len(imu) // COMPARED_ROWS + 1]
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


# Stamps that slip where a logger closes the gaps that lost samples leave.
#
# It numbers the rows that arrive, so that after each loss the stamps are that many samples early.
# In windows in which the motion changes, the delay of the readings beside the motion tells it: a
# staircase of whole samples.

WINDOW = 4.0  # s: in a shorter one, one oscillation passes for the next
WINDOW_ROWS = 120  # of a window that are compared
REACH = 0.35  # s that all stamps may be late or early from the beginning
MAX_LOST = 300  # samples in all
STEP = 0.1  # sample intervals between delays whose misfit is looked up
ORDER = 4  # of the differences that the readings' noise is read off
OUTLIER = 50.0  # chi-squared that one window may cost at most
MAX_U = 0.25  # of a sample interval: windows that know the delay worse are left out
MODEL_U = 0.08  # of a sample interval: what else may look like a delay in a window
MIN_WINDOWS = 6
CHANGE_POINT_COST = 40.0  # chi-squared that a further loss must gain: less than one window has
MIN_GAIN = 75.0  # chi-squared that losses must gain against a constant and a running delay
CHANGE_IN_ROWS = 300.0  # chi-squared, of rows: a small error of the model adds up over hundreds
LIKELY = 25.0  # chi-squared: what the model misses at rest makes a few
SHARP, SURE = 10, 4.0  # rows that are likely, and chi-squared: where it moves, that is enough
CLOSE = 0.2  # sample intervals: half of the windows lie nearer to the staircase
FEWEST_WINDOWS = 3  # windows: a level of fewer may be those in which samples were lost
OFF_WHOLE_INTERVAL = 0.25  # sample intervals that a step may be off a whole number


@dataclass(frozen=True)
class WindowDelays:
    """Delays of m windows in sample intervals: at (m,) s, delay, u (m,); width: of a window, s.

    table: (m, tried) chi-squared of delays from `earliest` on, in steps of STEP.
    """

    at: np.ndarray
    delay: np.ndarray
    u: np.ndarray
    width: float
    table: np.ndarray
    earliest: float

    def cost(self, delay: np.ndarray | float) -> np.ndarray:
        """Chi-squared (..., m) of supposed delays, of no window more than an outlier's."""
        place = np.round((np.asarray(delay) - self.earliest) / STEP).astype(int)
        place = np.clip(place, 0, self.table.shape[1] - 1)
        return np.asarray(np.minimum(self.table[np.arange(len(self.at)), place], OUTLIER))


@dataclass(frozen=True)
class Staircase:
    """Whole samples lost (m,) before each window of the delays, from 0 up."""

    delays: WindowDelays
    lost: np.ndarray

    @cached_property
    def first(self) -> float:
        """The delay before the first loss, in sample intervals."""
        return float(np.median(self.delays.delay - self.lost))

    @property
    def gain(self) -> float:
        """Chi-squared against a constant delay."""
        constant = self.delays.cost(float(np.median(self.delays.delay))).sum()
        return float(constant - self.delays.cost(self.first + self.lost).sum())

    @property
    def u(self) -> float:
        """Standard uncertainty of the number of samples that a step is high."""
        levels = (self.delays.u[self.lost == level] for level in np.unique(self.lost))
        return max(float(np.median(level)) / len(level) ** 0.5 for level in levels)

    def delay(self, t: np.ndarray) -> np.ndarray:
        """The delay (n,) at times t (n,) s, in sample intervals."""
        window = np.clip(np.searchsorted(self.delays.at, t), 0, len(self.lost) - 1)
        return np.asarray(self.first + self.lost[window])


def window_delays(
    t: np.ndarray, interval: float, readings: np.ndarray, signal: np.ndarray
) -> WindowDelays | None:
    """The delay of readings (n, k) beside a signal (n, k), both at t (n,) s, window by window.

    Beside the delay, each channel of a window has a bias and a scale factor of its own, not below
    zero: those of the whole run are not known before the losses are. NaN where either is not known.
    None where no window tells a delay.
    """
    lags = np.arange(-np.ceil(REACH / interval), np.ceil(REACH / interval) + MAX_LOST + 1.0)
    noise = np.array([noise_by_differences(c[np.isfinite(c)], ORDER, 0.5) for c in readings.T])
    if not (noise > 0.0).any():
        return None
    own = noise > 0.0
    white, signal = readings[:, own] / noise[own], signal[:, own] / noise[own]
    known = np.isfinite(white).all(axis=1)
    unknown = np.concatenate([[0], np.cumsum(~np.isfinite(signal).all(axis=1))])
    window = ((t - t[0]) / WINDOW).astype(int)
    at, tables, rows = [], [], []
    for number in range(int(window[-1]) + 1):
        first, last = np.searchsorted(window, (number, number + 1))
        here = first + np.flatnonzero(known[first:last])
        if len(here) < 0.5 * WINDOW / interval:
            continue
        here = here[:: 1 + len(here) // WINDOW_ROWS]
        read = white[here] - white[here].mean(axis=0)
        if (read**2).mean() < 2.0:  # nothing but noise
            continue
        reach = np.searchsorted(t, t[here[[0, -1]]] + lags[[0, -1]] * interval) + np.array([-1, 1])
        if np.ptp(unknown[np.clip(reach, 0, len(t))]):
            continue
        moved = (t[here] + lags[:, None] * interval).ravel()
        tables.append(
            _misfits(read, interpolated(moved, t, signal).reshape(len(lags), *read.shape))
        )
        at.append(0.5 * (t[here[0]] + t[here[-1]]))
        rows.append(read.size)
    if not at:
        return None
    misfit, size = np.array(tables), np.array(rows, float)
    level = max(1.0, float(np.median(misfit.min(axis=1) / size)))
    chi2 = (misfit - misfit.min(axis=1, keepdims=True)) / level
    return _sharp(np.array(at), lags, chi2)


def _misfits(read: np.ndarray, signal: np.ndarray) -> np.ndarray:
    """Sums of squares (lags,) that a scale factor and a bias for each channel leave of readings
    (n, k) without their mean, given signals (lags, n, k).
    """
    about = signal - signal.mean(axis=1, keepdims=True)
    both, power = (about * read).sum(axis=1), (about**2).sum(axis=1)
    explained = np.maximum(both, 0.0) ** 2 / np.maximum(power, 1e-12)
    return np.asarray((read**2).sum() - explained.sum(axis=1))


def _sharp(at: np.ndarray, lags: np.ndarray, chi2: np.ndarray) -> WindowDelays | None:
    """The delays of windows at (m,) s that tell one, by the chi-squared (m, lags)."""
    from scipy.interpolate import CubicSpline  # late: few recordings need it, and all wait for it

    best = chi2.argmin(axis=1)
    inside = (best > 0) & (best < len(lags) - 1)
    at, chi2, best = at[inside], chi2[inside], best[inside]
    own = np.arange(len(at))
    beside = np.minimum(chi2[own, best - 1], chi2[own, best + 1])
    beside_of_both = 0.5 * (chi2[own, best - 1] + chi2[own, best + 1])
    u = 1.0 / np.sqrt(np.maximum(beside_of_both, 1e-12))
    sharp = (u < MAX_U) & (beside > 0.0)
    if not sharp.any():
        return None
    chi2, u, at = chi2[sharp], u[sharp], at[sharp]
    fine = np.arange(lags[0], lags[-1] + STEP / 2, STEP)
    table = CubicSpline(lags, chi2, axis=1)(fine)
    table -= table.min(axis=1, keepdims=True)
    table *= (u**2 / (u**2 + MODEL_U**2))[:, None]
    delay = fine[table.argmin(axis=1)]
    return WindowDelays(at, delay, np.hypot(u, MODEL_U), WINDOW, table, float(lags[0]))


def fit_staircase(delays: WindowDelays) -> Staircase | None:
    """The staircase of the delays; None if they do not form one."""
    if len(delays.at) < MIN_WINDOWS:
        return None
    path, start = _best_path(delays)
    if path[0] != 0 or path[-1] == 0 or path[-1] >= MAX_LOST:
        return None
    constant = delays.cost(float(np.median(delays.delay))).sum()
    if min(constant, _drift_cost(delays)) - _cost(delays, path, start) < MIN_GAIN:
        return None
    close = float(np.median(np.abs(delays.delay - start - path))) < CLOSE
    if not close and 2 * delays.cost(start + path).sum() > constant:
        return None
    steps, held = np.unique(path, return_counts=True)
    levels = [
        np.median(delays.delay[path == step]) - step for step in steps[held >= FEWEST_WINDOWS]
    ]
    return Staircase(delays, path) if not levels or np.ptp(levels) < OFF_WHOLE_INTERVAL else None


def _cost(delays: WindowDelays, path: np.ndarray, start: float) -> float:
    """Chi-squared of a staircase, its change points included."""
    steps = CHANGE_POINT_COST * np.count_nonzero(np.diff(path))
    return float(delays.cost(start + path).sum() + steps)


def _best_path(delays: WindowDelays) -> tuple[np.ndarray, float]:
    """The cheapest staircase (m,) and its first delay, from several first delays to begin with."""
    candidates = []
    for first in np.unique(np.round(delays.delay[: max(3, len(delays.at) // 4)], 1)):
        start, states = float(first), np.arange(MAX_LOST + 1)[:, None]
        path = cheapest_path(delays.cost(start + states))
        for _ in range(3):
            start = float(np.median(delays.delay - path))
            path = cheapest_path(delays.cost(start + states))
        candidates.append((path, start))
    return min(candidates, key=lambda candidate: _cost(delays, *candidate))


def cheapest_path(cost: np.ndarray, change: float = CHANGE_POINT_COST) -> np.ndarray:
    """The rising staircase (n,) from 0 up of least cost (states, n), each of its change points
    included, by dynamic programming over the samples lost.
    """
    states = np.arange(len(cost))
    total = np.where(states == 0, cost[:, 0], np.inf)
    came_from = np.zeros(cost.shape, int)
    for k in range(1, cost.shape[1]):
        best = np.minimum.accumulate(total)
        first = np.maximum.accumulate(np.where(total == best, states, 0))
        jump = np.concatenate([[np.inf], best[:-1]]) + change
        stay = total <= jump
        came_from[:, k] = np.where(stay, states, np.concatenate([[0], first[:-1]]))
        total = np.where(stay, total, jump) + cost[:, k]
    path = [int(total.argmin())]
    for k in range(cost.shape[1] - 1, 0, -1):
        path.append(int(came_from[path[-1], k]))
    return np.array(path[::-1], float)


def placed(cost: np.ndarray) -> Iterator[tuple[int, int, int]]:
    """The jumps of the cheapest staircase of a cost (states, n): the first and the last place that
    each may have, up to a chi-squared of LIKELY, and how high it is.
    """
    path = cheapest_path(cost, CHANGE_IN_ROWS).astype(int)
    after = np.flatnonzero(np.diff(path)) + 1
    for before, place, behind in zip(
        [0, *after[:-1].tolist()], after.tolist(), [*after[1:].tolist(), len(path) - 1], strict=True
    ):
        here = slice(before, behind)
        # What it costs that the jump comes later: what is before it, and after it.
        beside = cost[path[place - 1], here] - cost[path[place], here]
        course = np.concatenate([[0.0], np.cumsum(beside)])
        likely = before + np.flatnonzero(course <= course.min() + LIKELY)
        if len(likely) <= SHARP:
            likely = before + np.flatnonzero(course <= course.min() + SURE)
        yield int(likely[0]), int(likely[-1]), int(path[place] - path[place - 1])


def _drift_cost(delays: WindowDelays) -> float:
    """Chi-squared of a delay that grows evenly, as of a clock that runs fast (robust line fit)."""
    weight = 1 / delays.u
    line = np.polyfit(delays.at, delays.delay, 1, w=weight)
    for _ in range(5):
        off = np.abs(delays.delay - np.polyval(line, delays.at)) * weight
        line = np.polyfit(delays.at, delays.delay, 1, w=weight / np.sqrt(np.maximum(off / 2, 1)))
    return float(delays.cost(np.polyval(line, delays.at)).sum())
