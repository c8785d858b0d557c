"""Codes that firmware joined wrongly, put right before any model."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from schemas.recording import ACCEL, GYRO, Recording, WrongCodes
from tasks.readings.code_faults import Fault, faults_of
from tasks.readings.lattice import code_lattices
from tasks.readings.line import Course, Line
from tasks.readings.resolved import resolved
from tasks.readings.stuck_bits import put_back
from tasks.words import Message, message

CHANNELS: tuple[str, ...] = GYRO + ACCEL
SAMPLE_ROWS = 20_000  # that a lattice is looked for in


def codes_put_right(recording: Recording) -> Recording:
    """The recording with wrong codes put right, and which they were (`Recording.wrong_codes`).

    The same recording where none is wrong, and where they were put right before.
    """
    if recording.wrong_codes:
        return recording
    imu = recording.imu  # by columns: all side by side are a copy of the recording
    lattices = code_lattices(imu.at(slice(0, None, len(imu) // SAMPLE_ROWS + 1)).stack(CHANNELS))
    if not lattices:
        return recording
    numbers = {c: np.rint(imu.columns[CHANNELS[c]] / q.step) for c, q in lattices.items()}
    course = Course(recording)
    columns, wrong = dict(imu.columns), list[WrongCodes]()
    for c, found in faults_of(numbers).items():
        read, undecided = numbers[c], np.zeros(len(imu), bool)
        right = read
        for fault in found:
            right, left = _put_right(right, fault, partial(course.line, c, lattices[c].step))
            undecided |= left
        off = np.nan_to_num(right - read)
        if off.any() or undecided.any():
            step = lattices[c].step
            columns[CHANNELS[c]] = columns[CHANNELS[c]] + off * step
            wrong += _described(CHANNELS[c], found, off, undecided, step)
    if not wrong:
        return recording
    return replace(recording, imu=replace(imu, columns=columns), wrong_codes=tuple(wrong))


def _put_right(
    numbers: np.ndarray, fault: Fault, line: Callable[[], Line]
) -> tuple[np.ndarray, np.ndarray]:
    """The right numbers (n,), and which of them could not be decided."""
    if fault.right is not None:
        return fault.right(numbers), np.zeros(len(numbers), bool)
    if fault.free is not None:
        return resolved(numbers, fault.free(numbers), fault.size, line())
    weight = fault.size if fault.bug == "stuck-high" else -fault.size
    return put_back(numbers, weight, line())


def _described(
    channel: str, faults: Sequence[Fault], off: np.ndarray, undecided: np.ndarray, step: float
) -> Iterator[WrongCodes]:
    share = float(np.mean(np.abs(off) > 0.5))
    for fault in faults:
        yield WrongCodes(channel, fault.bug, fault.size, fault.size * step, share, undecided)


def bug_in_words(wrong: WrongCodes) -> Message:
    """What the firmware does to a channel's codes."""
    return message(f"codes-{wrong.bug}", codes=f"{wrong.codes:.0f}")
