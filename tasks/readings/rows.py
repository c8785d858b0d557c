"""Rows of a logger that hold no readings: zero in every channel, or what no unit reads.

Three gyros at rest may read zero; with accelerometers, which feel gravity, a row of zeros is none.
A frame that was corrupted is far from the rows on either side, which know nothing of it; a knock
rings on, and a motion is told by what moved the unit.
"""

from dataclasses import replace

import numpy as np

from schemas.recording import Recording
from tasks.motion.samples import sample_interval
from tasks.readings.code_faults import TRIADS
from tasks.readings.codes import CHANNELS
from tasks.readings.line import Course
from tasks.readings.robust import TO_SIGMA, deviation
from tasks.readings.standing import runs
from tasks.words import Message, message

GYRO_LIMIT, ACCEL_LIMIT = 200.0, 5000.0  # rad/s, m/s²: units that read more are read so throughout
USUAL, BEYOND = 0.9, 30.0  # quantile of a channel's readings, and times it that one may be
MAX_SHARE = 0.1  # of the rows: more are no accident
AROUND = 25  # rows on either side, by which a row is judged
CLEAN = 4  # of them, next to it, that are not odd themselves: a knock rings on
LONGEST = 3  # rows of a corrupted burst; one value that is held counts as one row
HELD = 200  # rows that values are held for, at most
ODD = 30.0  # times the usual scatter: rows that are looked at
FAR, ZERO_FAR = 100.0, 10.0  # times the scatter beside: a corrupted frame, and one of zeros
ROUNDING = 0.3  # step: standard deviation of rounding
QUICKER = 10.0  # times any change from row to row beside
SLOWEST = 0.15  # s from row to row: of slower loggers a whole move is a row
NOT_FELT = 0.7  # of a jump: what the motion must leave unexplained of it
MAX_TIMES = 20  # that are listed


def rows_without_readings(recording: Recording) -> np.ndarray:
    """Which rows (n,) bool of a recording hold no readings."""
    readings = recording.imu.stack(CHANNELS)
    empty = empty_rows(readings)
    far = np.zeros(readings.shape)
    fast = len(recording.imu) > 1 and sample_interval(recording.imu.t) < SLOWEST
    for triad in TRIADS if fast else ():
        own = list(triad)
        if np.isfinite(readings[:, own]).any():
            far[:, own] = corrupted(np.where(empty[:, None], np.nan, readings)[:, own])
    if far.any():
        course = Course(recording)
        for c in np.flatnonzero(far.any(axis=0)).tolist():
            line = course.line(c, 1.0)
            off = np.abs(readings[:, c] - line.columns @ line.ideal)
            far[:, c] *= ~(line.known & (off < NOT_FELT * far[:, c]))
    return np.asarray(empty | far.any(axis=1))


def without_readings_removed(recording: Recording, empty: np.ndarray) -> Recording:
    """The recording with NaN in some rows (n,) bool of the six channels."""
    own = {name: recording.imu.columns[name] for name in CHANNELS if name in recording.imu.columns}
    torn = {name: np.where(empty, np.nan, signal) for name, signal in own.items()}
    imu = replace(recording.imu, columns={**recording.imu.columns, **torn})
    return replace(recording, imu=imu)


def empty_remarks(t: np.ndarray, empty: np.ndarray) -> tuple[Message, ...]:
    """A remark on the rows (n,) bool without readings, with their times of t (n,) s."""
    count = int(empty.sum())
    if not count:
        return ()
    times = ", ".join(f"{at:.2f}" for at in t[empty][:MAX_TIMES])
    times += ", …" if count > MAX_TIMES else ""
    return (message("events-empty-rows", count=count, times=times),)


def empty_rows(readings: np.ndarray) -> np.ndarray:
    """Which rows (n,) bool of readings (n, 6), rad/s and m/s², are zero or beyond any unit."""
    size = np.abs(readings)
    recorded = np.isfinite(size).any(axis=0)
    if not recorded.any():
        return np.zeros(len(size), bool)
    known = np.where(np.isfinite(size), size, 0.0)
    limits = np.repeat([GYRO_LIMIT, ACCEL_LIMIT], 3)
    limits = np.maximum(limits, BEYOND * np.quantile(known, USUAL, axis=0))
    empty = (known > limits).any(axis=1)
    if recorded[3:].any():
        empty |= (size[:, recorded] == 0.0).all(axis=1)
    return empty if empty.mean() <= MAX_SHARE else np.zeros(len(size), bool)


def corrupted(readings: np.ndarray) -> np.ndarray:
    """By how much (n, k) the channels of a triad (n, k) are off the rows beside, in rows that were
    corrupted; 0 elsewhere.
    """
    size = np.zeros(readings.shape)
    rows = np.flatnonzero(np.isfinite(readings).all(axis=1))
    if len(rows) < AROUND:
        return size
    new = np.append(True, (np.diff(readings[rows], axis=0) != 0.0).any(axis=1))
    own, number = readings[rows][new], np.cumsum(new) - 1  # each value that is held once
    held = np.bincount(number)
    apart = np.abs(np.diff(own, axis=0))
    step = np.where(apart > 0.0, apart, np.inf).min(axis=0)
    step = np.where(np.isfinite(step), step, 0.0)
    odd = _odd(own, step)
    found = np.zeros(own.shape)
    for start, stop in runs(odd).tolist():
        run = slice(start, stop)
        if stop - start <= LONGEST and held[run].sum() <= HELD:
            found[run] = _off(own, odd, run, step)
    if np.mean(np.any(found[number], axis=1)) <= MAX_SHARE:
        size[rows] = found[number]
    return size


def _odd(own: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Which rows (m,) bool of a triad (m, k) may be corrupted: far from the middle of those beside,
    and farther than these are for it. step: (k,) of the output.
    """
    bend = np.zeros(own.shape)
    bend[1:-1] = np.abs(own[1:-1] - 0.5 * (own[2:] + own[:-2]))
    usual = np.maximum([deviation(column) for column in bend.T], step)
    odd = np.asarray((bend > ODD * usual).any(axis=1))
    if not odd.any():
        return odd
    for row in np.flatnonzero(odd).tolist():
        about = own[max(0, row - LONGEST) : row + LONGEST + 1]
        off = np.abs(own[row] - np.median(about, axis=0))
        odd[row] = bool(((off > 0.5 * bend[row]) & (bend[row] > ODD * usual)).any())
    return odd


def _off(own: np.ndarray, odd: np.ndarray, run: slice, step: np.ndarray) -> np.ndarray:
    """By how much (r, k) some rows of a triad are off, 0 where rows beside move as they do."""
    nothing = np.zeros((run.stop - run.start, own.shape[1]))
    before, after = slice(max(0, run.start - AROUND), run.start), slice(run.stop, run.stop + AROUND)
    if odd[before][-CLEAN:].any() or odd[after][:CLEAN].any():
        return nothing
    left, right = own[before][~odd[before]], own[after][~odd[after]]
    if min(len(left), len(right)) < CLEAN:
        return nothing
    steps = np.vstack([np.diff(left, axis=0), np.diff(right, axis=0)])
    scatter = TO_SIGMA * np.median(np.abs(steps), axis=0) / np.sqrt(2.0)
    scatter = np.maximum(scatter, ROUNDING * step)
    off = np.abs(own[run] - 0.5 * (left[-1] + right[0]))
    quick = np.maximum(np.abs(steps).max(axis=0), np.abs(right[0] - left[-1]))
    least = ZERO_FAR if (own[run] == 0.0).all() else FAR
    return np.where((off > least * scatter) & (off > QUICKER * quick), off, 0.0)
