"""Rows of a logger that hold no readings: zero in every channel, or what no unit reads.

Three gyros at rest may read zero; with accelerometers, which feel gravity, a row of zeros is none.
A frame that was corrupted is far from the rows on either side, which know nothing of it; a knock
rings on, and a motion is told by what moved the unit.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import GYRO, Recording
from schemas.text import Seen
from tasks.motion.samples import sample_interval
from tasks.readings.codes import CHANNELS, TRIAD_COLUMNS
from tasks.readings.line import Course
from tasks.readings.plausibility import LEFT, runs, share_against, shift_of_labels
from tasks.readings.robust import TO_SIGMA, deviation
from tasks.words import Message, message

GYRO_LIMIT, ACCEL_LIMIT = 200.0, 5000.0  # rad/s, m/s²: units that read more are read so throughout
USUAL_QUANTILE, BEYOND_USUAL = 0.9, 30.0  # of a channel's readings, and times it one may be
MAX_SHARE = 0.1  # of the rows: more are no accident
AROUND = 25  # rows on either side, by which a row is judged
CLEAN = 4  # of them, next to it, that are not odd themselves: a knock rings on
LONGEST_BURST = 3  # rows of a corrupted burst; one value that is held counts as one row
HELD = 200  # rows that values are held for, at most
ODD = 30.0  # times the usual scatter: rows that are looked at
FAR_FRAME, FAR_ZEROS = 100.0, 10.0  # times the scatter beside: a corrupted frame, and one of zeros
ROUNDING_DEVIATION = 0.3  # step: standard deviation of rounding
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
    for triad in TRIAD_COLUMNS if fast else ():
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
    limits = np.maximum(limits, BEYOND_USUAL * np.quantile(known, USUAL_QUANTILE, axis=0))
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
        if stop - start <= LONGEST_BURST and held[run].sum() <= HELD:
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
        about = own[max(0, row - LONGEST_BURST) : row + LONGEST_BURST + 1]
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
    scatter = np.maximum(scatter, ROUNDING_DEVIATION * step)
    off = np.abs(own[run] - 0.5 * (left[-1] + right[0]))
    quick = np.maximum(np.abs(steps).max(axis=0), np.abs(right[0] - left[-1]))
    least = FAR_ZEROS if (own[run] == 0.0).all() else FAR_FRAME
    return np.where((off > least * scatter) & (off > QUICKER * quick), off, 0.0)


# What passed where a clock did not run on, by the labels after it.
#
# Stamps tell nothing of it: the clock was set and no row is missing, or the unit was off for a
# while. Labels that fit rows which go on at once say that the clock was set; labels that fit only
# later rows say for how long nothing was logged. Only where labels contradict a pause as it was
# stamped can it be the clock that was set.

PAUSE = (1.0, 20.0)  # s, intervals: a step of the stamps that may be one of the clock
FEWEST_STEPS = 5  # such steps
DENIED = 0.1  # of the rows after it that contradict their labels, as it was stamped


@dataclass(frozen=True)
class Break:
    """row: the first after it; line: where it stands in the file. step: s between the stamps as
    they were written. began: whether the unit began anew. ran_on: whether its rows were taken to go
    on at once; else the step is as it was stamped.
    """

    row: int
    line: int
    step: float
    began: bool
    ran_on: bool


def across_breaks(
    recording: Recording, breaks: Sequence[Break], lines: np.ndarray
) -> tuple[Recording, tuple[Seen, ...]]:
    """The recording with its rows at the times that labels tell, and what was seen.

    lines: (n,) of the file. Labels across a time when the unit was off are left out: what they hold
    is of two turn-ons.
    """
    steps = np.diff(recording.imu.t)
    long = np.flatnonzero(steps > max(PAUSE[0], PAUSE[1] * float(np.median(steps)))) + 1
    pauses = [row for row in long.tolist() if row not in {one.row for one in breaks}]
    if recording.manifest.segments and len(pauses) <= FEWEST_STEPS:
        step = dict(zip(pauses, steps[[row - 1 for row in pauses]].tolist(), strict=True))
        breaks = [*breaks, *(Break(k, int(lines[k]), step[k], False, False) for k in pauses)]
    was_set, seen = list[Break](), list[Seen]()
    for one in sorted(breaks, key=lambda each: each.row):
        passed, within = _passed(recording, one) if one.ran_on else (0.0, 0.0)
        if not one.ran_on:
            running = _moved(recording, one.row, float(np.median(steps)) - one.step)
            if not _is_denied(recording, running, one.row):
                continue
            recording = running
        recording = _moved(recording, one.row, passed)
        if not (one.began or passed):
            was_set.append(one)
            continue
        recording, names, both = _without_shared(recording, one.row)
        seen.append(Seen("restarted", message(
            "seen-restarted", line=one.line, seconds=f"{passed:.2f}", within=f"{within:.2f}",
            known="labels" if passed else "no", left=", ".join(names) or "none",
        ), names, "invalid" if both else "remarks"))  # fmt: skip
    if was_set:
        first = was_set[0]
        seen.append(Seen("clock_set", message(
            "seen-clock-set", count=len(was_set), line=first.line,
            way="ahead" if first.step > 0 else "back",
            seconds=f"{abs(first.step - float(np.median(steps))):.3f}".rstrip("0").rstrip("."),
        ), run="valid"))  # fmt: skip
    return recording, tuple(seen)


def _after(recording: Recording, row: int) -> Recording:
    """The rows from one on, with the labels that begin after the row before; without the first,
    which may have begun while no row was logged.
    """
    labels = sorted(recording.manifest.segments or (), key=lambda label: label.t_start)
    later = tuple(s for s in labels if s.t_start > recording.imu.t[row - 1])[1:]
    manifest = recording.manifest.model_copy(update={"segments": later})
    return replace(recording, manifest=manifest, imu=recording.imu.at(slice(row, None)))


def _zero(recording: Recording, row: int) -> np.ndarray | None:
    """(3,) what the gyros read in the rests before a row; None where none was labelled."""
    imu, until = recording.imu, recording.imu.t[row - 1]
    rests = [s for s in recording.manifest.segments or () if s.kind == "static"]
    places = [imu.rows(s.t_start, s.t_end) for s in rests if s.t_end <= until]
    read = [imu.channels(GYRO, rows).mean(axis=1) for rows in places if rows.stop > rows.start]
    zero = np.median(read, axis=0) if read else np.full(3, np.nan)
    return zero if np.isfinite(zero).all() else None


def _passed(recording: Recording, one: Break) -> tuple[float, float]:
    """s that passed at a break whose rows go on at once, and within how much; 0 where the labels
    after it fit, or do not tell."""
    if len(recording.imu) - one.row < 2:
        return 0.0, 0.0
    found = shift_of_labels(_after(recording, one.row), zero=_zero(recording, one.row))
    return (0.0, 0.0) if found is None or found.seconds > 0 else (-found.seconds, found.within)


def _is_denied(stamped: Recording, running: Recording, row: int) -> bool:
    """Whether labels after a pause deny it, and fit the rows that go on at once."""
    if len(stamped.imu) - row < 2:
        return False
    zero = _zero(stamped, row)
    against, left = (share_against(_after(one, row), zero) for one in (stamped, running))
    return against is not None and left is not None and against > DENIED and left < LEFT


def _moved(recording: Recording, row: int, seconds: float) -> Recording:
    if not seconds:
        return recording
    t = recording.imu.t.copy()
    t[row:] += seconds
    return replace(recording, imu=replace(recording.imu, t=np.round(t, 9)))


def _without_shared(recording: Recording, row: int) -> tuple[Recording, tuple[str, ...], bool]:
    """The recording without labels that reach over a break, their names, and whether rests lie on
    both sides of it.
    """
    before, after = recording.imu.t[row - 1], recording.imu.t[row]
    labels = recording.manifest.segments or ()
    over = tuple(s.name for s in labels if s.t_start < after and s.t_end > before)
    kept = tuple(s for s in labels if s.name not in over)
    rests = [s for s in kept if s.kind == "static"]
    both = any(s.t_end <= after for s in rests) and any(s.t_start > before for s in rests)
    manifest = recording.manifest.model_copy(update={"segments": kept or None})
    return replace(recording, manifest=manifest), over, both
