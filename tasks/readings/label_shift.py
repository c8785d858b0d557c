"""By how much all labels of a recording are late or early.

The rows themselves say which of them a label could mean: at rest with its axis up, or turning at
its rate. Where a good part of the rows contradicts the labels as they stand, and next to none
contradicts them once they are all moved by the same time, that time is what they are shifted by.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from schemas.recording import ACCEL, AXES, GYRO, Recording, Segment
from tasks.motion.samples import in_blocks
from tasks.motion.whole import unit_vector

BLOCK = 0.05  # s of a mean
EDGE = 0.25  # s, or a tenth of a label: what is looked at first
MOVING = np.radians(2.0)  # rad/s from rest, by which noise of a block and drift are no motion
UPRIGHT = 0.8  # cosine between what is read at rest and the axis up
NEARLY = 0.2  # of a rate, by which a gyro may read another
REACH = 120.0  # s
STEP = 0.05  # s
LEAST_COST, LEFT = 0.004, 0.02  # share of rows against the labels: as they stand, and moved
NOTHING = 0.001  # share of rows by which costs are alike
BETTER = 0.15  # of the rows against them that a shift may leave
SMALLEST = 0.35  # s: streams may be offset from each other by a little
ROWS = 2.0  # intervals of the unit's rows that a shift is at least
FEWEST = 3  # labels


@dataclass(frozen=True)
class LabelShift:
    """seconds: to be added to all label times; within: half of the span that fits as well, s."""

    seconds: float
    within: float


def shift_of_labels(
    recording: Recording, gain: float = 1.0, zero: np.ndarray | None = None
) -> LabelShift | None:
    """The shift of all labels, or None where none is clear.

    gain: what the gyros read of a rate, where that is known to be no scale factor. zero: (3,) what
    they read at rest, where other labels than these tell it.
    """
    labels = _telling(recording)
    if len(labels) < FEWEST or _fit_at_both_ends(recording, labels, gain):
        return None
    cost = _cost(recording, labels, gain, zero)
    if cost is None:
        return None
    as_stated = float(cost(np.zeros(1))[0])
    if as_stated < LEAST_COST:
        return None
    t = recording.imu.t
    reach = min(REACH, 0.5 * float(t[-1] - t[0]))
    least = max(SMALLEST, ROWS * float(np.median(np.diff(t))))
    return _best(np.arange(-reach, reach + STEP, STEP), cost, as_stated, least)


def share_against(recording: Recording, zero: np.ndarray | None) -> float | None:
    """Which share of the rows contradicts the labels as they stand; None where few can tell."""
    labels = _telling(recording)
    cost = _cost(recording, labels, 1.0, zero) if len(labels) >= FEWEST else None
    return None if cost is None else float(cost(np.zeros(1))[0])


def _telling(recording: Recording) -> list[Segment]:
    labels = [s for s in recording.manifest.segments or () if s.kind in ("static", "rate")]
    return [s for s in labels if s.kind == "static" or (s.axis and s.rate_deg_s)]


def _cost(
    recording: Recording, labels: list[Segment], gain: float, zero: np.ndarray | None
) -> Callable[[np.ndarray], np.ndarray] | None:
    """The share of rows against the labels, by shifts (k,) s of all of them."""
    t, gyro, accel = _blocks(recording, zero)
    if len(t) < 2 or not np.isfinite(gyro).all(axis=1).mean() > 0.5:
        return None
    gyro = gyro / gain
    fits = [_fits(label, gyro, accel) for label in labels]
    span = np.array([(s.t_start, s.t_end) for s in labels])
    weight = np.diff(span, axis=1)[:, 0]
    counts = [np.concatenate([[0], np.cumsum(~one)]) for one in fits]
    interval = max(float(np.median(np.diff(t))), 1e-9)

    def cost(shift: np.ndarray) -> np.ndarray:
        against = np.zeros(len(shift))
        for (start, end), wrong, w in zip(span, counts, weight, strict=True):
            first = np.searchsorted(t, start + shift)
            last = np.maximum(np.searchsorted(t, end + shift), first)
            rows = last - first
            expected = w / interval
            missing = np.maximum(expected - rows - 1.0, 0.0)  # beyond the recording: against it
            against += w * (wrong[last] - wrong[first] + missing) / np.maximum(expected, 1.0)
        return np.asarray(against / weight.sum())

    return cost


def _best(
    shifts: np.ndarray,
    cost: Callable[[np.ndarray], np.ndarray],
    as_stated: float,
    least: float,
) -> LabelShift | None:
    """The shift of at least `least` s that leaves next to nothing against the labels, where it
    stands alone.
    """
    costs = cost(shifts)
    best = int(costs.argmin())
    good = costs <= costs[best] + NOTHING
    low, high = best, best
    while low > 0 and good[low - 1]:
        low -= 1
    while high + 1 < len(good) and good[high + 1]:
        high += 1
    seconds, within = 0.5 * (shifts[low] + shifts[high]), 0.5 * (shifts[high] - shifts[low])
    elsewhere = np.concatenate([costs[: max(low - 20, 0)], costs[high + 20 :]])
    is_clear = (
        costs[best] <= min(LEFT, BETTER * as_stated)
        and abs(seconds) >= max(least, within)
        and elsewhere.min(initial=1.0) >= 2.0 * costs[best] + 0.01
    )
    return LabelShift(float(seconds), float(within)) if is_clear else None


def _fit_at_both_ends(recording: Recording, labels: list[Segment], gain: float) -> bool:
    """Whether what is read as every label begins and ends is what it says: then none is shifted."""
    ends, own = list[slice](), list[Segment]()
    for label in labels:
        edge = min(EDGE, 0.1 * (label.t_end - label.t_start))
        ends += [recording.imu.rows(label.t_start, label.t_start + edge),
                 recording.imu.rows(label.t_end - edge, label.t_end)]  # fmt: skip
        own += [label, label]
    read = (recording.imu.channels(GYRO + ACCEL, rows) for rows in ends)
    means = np.array([one.mean(axis=1) if one.size else np.full(6, np.nan) for one in read])
    at_rest = np.array([label.kind == "static" for label in own])
    gyro = _from_rest(means[:, :3], at_rest) / gain
    direction = _directed(means[:, 3:])
    fits = [_fits(label, gyro[k, None], direction[k, None])[0] for k, label in enumerate(own)]
    return all(fits)


def _from_rest(gyro: np.ndarray, at_rest: np.ndarray) -> np.ndarray:
    """Rates (m, 3) from what is usual at rest; of a triad that was not recorded NaN."""
    usual = gyro[at_rest & np.isfinite(gyro).all(axis=1)]
    return gyro - np.median(usual, axis=0) if len(usual) else gyro


def _directed(accel: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(accel, axis=1)[:, None]
    return np.where(size > 0, accel / np.where(size > 0, size, 1.0), np.nan)


def _blocks(
    recording: Recording, zero: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, rates from rest and directions of force (m, 3), as means over BLOCK."""
    imu = recording.imu
    interval = float(np.median(np.diff(imu.t)))
    rows = max(1, round(BLOCK / max(interval, 1e-9)))
    means = in_blocks(np.column_stack([imu.t, imu.stack(GYRO), imu.stack(ACCEL)]), rows).mean(
        axis=1
    )
    t, gyro, accel = means[:, 0], means[:, 1:4], means[:, 4:]
    at_rest = np.zeros(len(t), bool)
    for label in recording.manifest.segments or ():
        if label.kind == "static":
            at_rest |= (t >= label.t_start) & (t < label.t_end)
    rate = _from_rest(gyro, at_rest) if zero is None else gyro - zero
    return t, rate, _directed(accel)


def _fits(label: Segment, gyro: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """(m,) bool: which rows a label could mean."""
    if label.kind == "static":
        fits = np.linalg.norm(gyro, axis=1) < MOVING
        up = unit_vector(label.up)
        if np.isfinite(up).all() and np.isfinite(direction).all(axis=1).mean() > 0.5:
            fits &= direction @ up > UPRIGHT
        return np.asarray(fits)
    assert label.axis is not None
    rate = np.radians(label.rate_deg_s or 0.0)
    read = gyro[:, AXES.index(label.axis)]
    return np.asarray(np.abs(read - rate) < NEARLY * abs(rate) + MOVING)
