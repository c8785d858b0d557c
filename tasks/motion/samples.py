"""Sampled signals: interpolation, block means, and the noise of both."""

from functools import lru_cache
from math import comb

import numpy as np

from schemas.recording import Stream

FARTHEST, INTERVALS = 0.1, 4.0  # s, and intervals: with no sample that near nothing is known
LOST = 2.5  # intervals: a longer step is a gap, a shorter one may be stamps that scatter
NORMAL_QUANTILES = {
    0.1: 0.1257,
    0.5: 0.6745,
    0.9: 1.645,
}  # of the absolute value of a standard normal variable
SAMPLE = 20_000  # differences that a quantile is taken of
SLOW = 0.15  # s between samples: corners of a ramp are no longer a small part of the motion
TURN = 2.0 * np.pi + 0.1  # rad: encoders that start anew each turn stay within, but for noise
SPAN = 60  # rows: whole batches of most sizes in which stamps are written
GAP_SHARE = 0.25  # of the usual time of so many rows: more is a gap


def sample_interval(t: np.ndarray) -> float:
    """Seconds between rows stamped t (n,) s, whether or not stamps come in batches; gaps apart."""
    rows = max(1, min(SPAN, len(t) // 4))
    spans = t[rows:] - t[:-rows]
    usual, next_to = float(np.median(spans)), float(np.median(np.diff(t)))
    if abs(rows * next_to - usual) <= GAP_SHARE * usual:
        return next_to
    return float(spans[np.abs(spans - usual) <= GAP_SHARE * usual].mean()) / rows


def longest_step(t: np.ndarray) -> float:
    """Longest step (s) that rows stamped t (n,) s take again and again: that between batches."""
    steps = np.diff(t)
    return float(np.median(in_blocks(steps, max(1, min(SPAN, len(steps)))).max(axis=1)))


def gaps(t: np.ndarray, interval: float, wide: float) -> np.ndarray:
    """(k,) rows after which others are missing: stamps t (n,) s are late by `wide` intervals from
    there on. The first row of a batch only is late.
    """
    course = t - interval * np.arange(len(t))
    after = np.flatnonzero(np.diff(t) > (wide + 1.0) * interval)
    ends = after + 1
    late = [
        float(course[end : end + SPAN].mean() - course[max(0, end - SPAN) : end].mean())
        for end in ends
    ]
    return after[np.array(late) > wide * interval]


def interpolated(at: np.ndarray, t: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (n, k) at times t (n,) s, linearly interpolated at the times `at` (m,): (m, k)."""
    return np.column_stack([np.interp(at, t, column) for column in values.T])


def continuous(table: Stream, names: tuple[str, ...], rows: slice | None = None) -> np.ndarray:
    """The named angles (n, k) rad over some rows, without the jumps of an encoder that starts anew
    each turn.

    One that was read past a turn does not: there a long step is a gap, or a slow sampling.
    """
    angles = table.stack(names, rows)
    jumps = (np.abs(np.diff(angles, axis=0)) > np.pi).any(axis=0)
    for k in np.flatnonzero(jumps).tolist():
        if not _passes_turns(table, names[k]):
            angles[:, k] = np.unwrap(angles[:, k])
    return angles


@lru_cache(maxsize=16)  # asked for again in each segment
def _passes_turns(table: Stream, name: str) -> bool:
    return float(np.ptp(table.columns[name])) > TURN


def covered(
    t: np.ndarray, at: np.ndarray, reach: float = 0.0, farthest: float = FARTHEST
) -> np.ndarray:
    """Whether samples at t (n,) s lie near the times asked: (m,) bool.

    Before and behind a time there is one within `farthest` (s) or, where it samples more slowly,
    within INTERVALS of its usual interval; at either end of the samples, one on the other side
    will do.
    reach: s, of what is made of the samples around a time: none of them in a row may be LOST.
    """
    if len(t) < 2:
        return np.zeros(len(at), bool)
    steps = np.diff(t)
    interval = float(np.median(steps))
    before = np.maximum(np.searchsorted(t, at, "right") - 1, 0)
    after = np.minimum(np.searchsorted(t, at, "left"), len(t) - 1)
    away = np.maximum(np.abs(at - t[before]), np.abs(t[after] - at))
    gaps = np.flatnonzero(steps > LOST * interval) if reach else np.empty(0, int)
    begun, ended = np.searchsorted(t[gaps], at + reach), np.searchsorted(t[gaps + 1], at - reach)
    return np.asarray((away <= max(farthest, INTERVALS * interval)) & (begun == ended))


def bridged(values: np.ndarray) -> np.ndarray:
    """Values (n, k) that go straight on from row to row where they are NaN; 0 where all are."""
    known = np.isfinite(values)
    if known.all():
        return values
    filled = np.where(known, values, 0.0)
    for k, there in enumerate(known.T):
        if there.any():
            missing = np.flatnonzero(~there)
            filled[missing, k] = np.interp(missing, np.flatnonzero(there), values[there, k])
    return filled


def in_blocks(values: np.ndarray, rows: int) -> np.ndarray:
    """Values (n, …) as whole blocks (n // rows, rows, …); the rest at the end is left out."""
    count = len(values) // rows
    return values[: count * rows].reshape(count, rows, *values.shape[1:])


def noise_by_differences(values: np.ndarray, order: int, share: float) -> float:
    """Standard deviation of the white noise of values (n,) or (n, k), where anything moves at all.

    A motion leaves next to nothing in differences of a high order but what oscillates faster than
    a quarter of the sampling rate. share: the quantile of their size that is compared with that of
    normal noise; what disturbs fewer of them does not count.
    """
    rough = np.abs(np.diff(values, order, axis=0)).ravel()
    rough = rough[rough > 0.0]
    rough = rough[:: 1 + len(rough) // SAMPLE]
    if not len(rough):
        return 0.0
    size = float(np.quantile(rough, share)) / NORMAL_QUANTILES[share]
    return size / float(np.sqrt(comb(2 * order, order)))


# A first-order lag of a signal.


def first_order_lag(
    signal: np.ndarray, step: float, seconds: float, start: float = 0.0
) -> np.ndarray:
    """A signal (n,) of rows `step` s apart through a lag of first order.

    seconds: its time constant. start: the value it was in balance with before the first row.
    """
    from scipy.signal import lfilter  # late: loading it takes longer than most calibrations

    stays = np.exp(-step / seconds)
    return np.asarray(lfilter([1.0 - stays], [1.0, -stays], signal, zi=[stays * start])[0])
