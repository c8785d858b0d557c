"""Codes that firmware joined wrongly, put right before any model."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import takewhile

import numpy as np

from schemas.recording import ACCEL, GYRO, Recording, WrongCodes
from schemas.text import Remark
from tasks.readings.code_faults import PERIODS, TRIADS, Fault, faults_of, jumps, period_of, wrap
from tasks.readings.judge import CERTAIN, ROUNDING, in_course, in_motion
from tasks.readings.lattice import code_lattices
from tasks.readings.line import Course, Line
from tasks.readings.offset_binary import offset_taken_off
from tasks.readings.resolved import resolved
from tasks.readings.stuck_bits import put_back
from tasks.words import Message, message, remark

CHANNELS: tuple[str, ...] = GYRO + ACCEL
SAMPLE_ROWS = 20_000  # that a lattice is looked for in
ANY_PERIOD = 10.0  # log odds that a period costs which is found by the jumps themselves
SUSPECTED = "codes_suspected"


@dataclass(frozen=True)
class Repair:
    """What a fault that is undone makes of a channel's numbers, and how likely that is.

    right: (n,) numbers. undecided: (n,) bool. odds: log odds of the fault against a real event.
    kind: that channels may have in common, and its log odds before anything is looked at.
    """

    fault: Fault
    right: np.ndarray
    undecided: np.ndarray
    odds: float
    kind: str
    before: float


def codes_put_right(recording: Recording) -> Recording:
    """The recording with offset binary and wrong codes put right, and which these were
    (`Recording.wrong_codes`).

    What one channel's numbers and its motion make likely counts for the others, too: one loop of
    the firmware joins them all. A fault that is not certain is said in a remark, and nothing is
    changed. The same recording where none is wrong, and where they were put right before.
    """
    recording = offset_taken_off(recording)
    if recording.wrong_codes or any(one.code == SUSPECTED for one in recording.put_right):
        return recording
    imu = recording.imu  # by columns: all side by side are a copy of the recording
    lattices = code_lattices(imu.at(slice(0, None, len(imu) // SAMPLE_ROWS + 1)).stack(CHANNELS))
    numbers = {c: np.rint(imu.columns[CHANNELS[c]] / q.step) for c, q in lattices.items()}
    steps = {c: q.step for c, q in lattices.items()}
    faults = faults_of(numbers)
    recorded = {c for c, name in enumerate(CHANNELS) if name in imu.columns}
    for triad in TRIADS:  # what is no whole number may wrap, too
        stepless = recorded.intersection(triad) - lattices.keys()
        sizes = {c: jumps(imu.columns[CHANNELS[c]]) for c in sorted(stepless)}
        period = period_of(list(sizes.values()))
        if period is not None:
            for c in (c for c, sized in sizes.items() if len(sized)):
                numbers[c], steps[c], faults[c] = imu.columns[CHANNELS[c]], 1.0, [wrap(period)]
    if not faults:
        return recording
    course = Course(recording)
    repairs = {
        c: list(_repairs(numbers[c], found, steps[c], partial(course.line, c, steps[c])))
        for c, found in faults.items()
    }
    odds = dict[str, float]()
    for each in (repair for own in repairs.values() for repair in own):
        odds[each.kind] = odds.get(each.kind, each.before) + max(each.odds, 0.0)
    columns, wrong, suspected = dict(imu.columns), list[WrongCodes](), list[Remark]()
    for c, own in sorted(repairs.items()):
        sure = list(takewhile(lambda one: one.odds >= 0.0 and odds[one.kind] > CERTAIN, own))
        suspected += [
            _suspected(_wrong(c, one.fault, steps[c], c in lattices))
            for one in own[len(sure) :][:1]
            if one.odds > 0.0
        ]
        if not sure:
            continue
        off = np.nan_to_num(sure[-1].right - numbers[c])
        undecided = np.any([one.undecided for one in sure], axis=0)
        if off.any() or undecided.any():
            columns[CHANNELS[c]] = columns[CHANNELS[c]] + off * steps[c]
            share = float(np.mean(off != 0.0))
            wrong += [
                replace(
                    _wrong(c, one.fault, steps[c], c in lattices), share=share, undecided=undecided
                )
                for one in sure
            ]
    if not (wrong or suspected):
        return recording
    return replace(
        recording,
        imu=replace(imu, columns=columns) if wrong else imu,
        wrong_codes=tuple(wrong),
        put_right=(*recording.put_right, *suspected),
    )


def _repairs(
    numbers: np.ndarray, faults: Sequence[Fault], step: float, line: Callable[[], Line]
) -> Iterator[Repair]:
    """The faults of a channel undone one after the other; step: rad/s or m/s² of its numbers."""
    for fault in faults:
        right, undecided = _put_right(numbers, fault, line)
        odds = fault.odds
        if fault.right is not None:
            odds += in_course(numbers, right)
        if fault.free is not None:
            # Where a unit saturates it jumps from end to end, too.
            ends = np.fmin.reduce(numbers), np.fmax.reduce(numbers)
            decided = np.where(undecided | np.isin(numbers, ends), np.nan, right)
            odds += in_course(numbers, decided, ROUNDING if step != 1.0 else 0.0, fault.size)
            odds += in_motion(numbers, decided, line(), fault.size)
        usual = fault.bug != "wrap" or fault.size in PERIODS
        kind = f"{fault.bug} {fault.size if usual else fault.size * step:.2g}"
        yield Repair(fault, right, undecided, odds, kind, 0.0 if usual else -ANY_PERIOD)
        numbers = right


def _suspected(wrong: WrongCodes) -> Remark:
    return remark(
        SUSPECTED,
        message(
            "codes-suspected", channel=message(f"channel-{wrong.channel}"),
            bug=bug_in_words(wrong), size=size_in_words(wrong),
        ),
    )  # fmt: skip


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


def _wrong(channel: int, fault: Fault, step: float, whole: bool) -> WrongCodes:
    """A fault of which nothing is put right yet; whole: of whole numbers."""
    codes = fault.size if whole else 0.0
    nothing = np.zeros(0, bool)
    return WrongCodes(CHANNELS[channel], fault.bug, codes, fault.size * step, 0.0, nothing)


def bug_in_words(wrong: WrongCodes) -> Message:
    """What the firmware does to a channel's codes."""
    return message(f"codes-{wrong.bug}", size=size_in_words(wrong))


def size_in_words(wrong: WrongCodes) -> Message:
    """What readings are off by whole multiples of: codes, where they are known."""
    unit = "rad/s" if wrong.channel in GYRO else "m/s²"
    if wrong.codes:
        return message("codes-size", codes=f"{wrong.codes:.0f}")
    return message("codes-jump", jump=f"{wrong.jump:.4g} {unit}")
