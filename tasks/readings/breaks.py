"""What passed where a clock did not run on, by the labels after it.

Stamps tell nothing of it: the clock was set and no row is missing, or the unit was off for a while.
Labels that fit rows which go on at once say that the clock was set; labels that fit only later rows
say for how long nothing was logged. Only where labels contradict a pause as it was stamped can it
be the clock that was set.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import GYRO, Recording
from schemas.text import Seen
from tasks.readings.label_shift import LEFT, share_against, shift_of_labels
from tasks.words import message

PAUSE = (1.0, 20.0)  # s, intervals: a step of the stamps that may be one of the clock
FEW = 5  # such steps
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
    if recording.manifest.segments and len(pauses) <= FEW:
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
