"""Codes joined wrongly or with a bit lost: readings are off by multiples of 2ᵇ codes.

A low byte taken as signed, a sign that was not extended, a high byte read before the low one moved
on, a bit that sticks: each errs by a fixed power of two of the output's step, for some codes and
not for others. So readings jump to and fro by it while little moves, and put right they follow one
another: that is how a fault differs from a bias that jumps, which does not ask what the code is.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
from scipy.ndimage import median_filter

from schemas.discrepancy import FoundParameter
from tasks.explain.events.broken_codes import BYTE, put_back, stuck_bit, torn_codes
from tasks.explain.events.event import CHANNELS, UNITS, Event
from tasks.explain.events.quantisation import quantiser_of
from tasks.model.fit import plain_prediction
from tasks.motion.whole import Motion
from tasks.words import message

BITS = tuple(range(3, 18))  # a jump of fewer codes is noise; of more, no word of any format
CLEAR = 8.0  # times the scatter of what changes from row to row: a jump
NEAR, BETWEEN = (0.7, 1.3), (0.3, 0.7)  # of a jump: changes that are one, and that nothing makes
MAX_BETWEEN = 0.05  # of the number of jumps
MIN_JUMPS = 15  # in each direction
SLOW = 1.0  # of a jump: change of the prediction from a row to the next
ROUNDS = 4  # of a fit to what was put right
MAX_LEFT = 0.2  # of a jump: what readings put right change by from row to row
BINS = 256  # of codes, by which the fault must be decided
MAX_UNDECIDED = 0.2  # of the readings that are off: codes that err at times only
NEIGHBOURS = 9  # rows about one, most of which are right
MIN_TORN = 0.9  # of the readings that are off: with the high byte of the row before
MAX_CARRIES = 0.3  # of the rows: where more change their high byte, chance does the same
ROUNDING = 1e-6  # of a jump
P_VALUE = 1e-9  # of so many jumps to and fro with nothing between, at most


@dataclass(frozen=True)
class CodeFault(Event):
    """off: (n, 6) what the fault added to each reading."""

    off: np.ndarray

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return predicted + self.off

    def undone(self, readings: np.ndarray) -> np.ndarray:
        """Readings (n, 6) with the right codes."""
        return readings - self.off


@dataclass(frozen=True)
class FaultyChannel:
    """jump: rad/s or m/s²; codes: that it is; share: of the readings that are off."""

    channel: int
    jump: float
    codes: int
    share: float


def find_code_fault(readings: np.ndarray, motion: Motion) -> CodeFault | None:
    """Errors by whole multiples of a power of two of the step in readings (n, 6)."""
    quantisers = [quantiser_of(reading) for reading in readings.T]
    steps = {c: each.step for c, each in enumerate(quantisers) if each is not None}
    if not steps:
        return None
    stuck = {c: bit for c, step in steps.items() if (bit := stuck_bit(readings[:, c] / step))}
    off = put_back(readings, motion, {c: bit * steps[c] for c, bit in stuck.items()})
    found = {c: abs(bit) for c, bit in stuck.items()}
    right = readings - off
    predicted = plain_prediction(right, motion)
    codes = {
        c: 2**bits for c, step in steps.items()
        if c not in stuck and (bits := _jump_bits(right[:, c], predicted[:, c], step)) is not None
    }  # fmt: skip
    jumps = {c: number * steps[c] for c, number in codes.items()}
    tried = [_put_right(right, predicted, motion, jumps, way) for way in WAYS if jumps]
    for c, jump in jumps.items():
        for added, left in sorted(((off[:, c], left[c]) for off, left in tried), key=itemgetter(1)):
            if left < MAX_LEFT * jump and _of_code(right[:, c] - added, added, jump):
                off[:, c], found[c] = added, codes[c]
                break
    for c, step in steps.items():
        torn = None if c in found else torn_codes(right[:, c] / step, predicted[:, c] / step)
        if torn is not None:
            off[:, c] += torn * step
            found[c] = round(BYTE)
    faulty = [_faulty(c, number, steps[c], off) for c, number in found.items()]
    return _event(faulty, off) if faulty else None


def _faulty(channel: int, codes: int, step: float, off: np.ndarray) -> FaultyChannel:
    jump = codes * step
    share = float(np.mean(np.minimum(np.abs(off[:, channel]) / jump, 1.0)))
    return FaultyChannel(channel, jump, codes, share)


def _put_right(
    readings: np.ndarray, predicted: np.ndarray, motion: Motion, jumps: Mapping[int, float],
    way: Callable[[np.ndarray, float], np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The correction (n, 6) of the readings, and how (6,) they then change from row to row.

    jumps: by channel. predicted: (n, 6), to begin with. way: multiples of a jump in a residual.
    """
    off = np.zeros_like(readings)
    for _ in range(ROUNDS):
        for c, jump in jumps.items():
            off[:, c] = way(readings[:, c] - predicted[:, c], jump)
        predicted = plain_prediction(readings - off, motion)
    change = np.diff(readings - off - predicted, axis=0)
    return off, np.sqrt(np.nanmean(change**2, axis=0)) if jumps else np.zeros(6)


def _jump_bits(reading: np.ndarray, predicted: np.ndarray, step: float) -> int | None:
    """The power of two of codes by which one reading (n,) and the next differ to and fro."""
    expected = np.diff(predicted) / step
    change = np.diff(reading) / step - np.nan_to_num(expected)
    for bits in reversed(BITS):
        codes = 2.0**bits
        slow = change[np.isfinite(change) & ~(np.abs(expected) > SLOW * codes)]
        size = np.abs(slow)
        jumps = (size > NEAR[0] * codes) & (size < NEAR[1] * codes)
        up, down = int((jumps & (slow > 0)).sum()), int((jumps & (slow < 0)).sum())
        if min(up, down) < MIN_JUMPS:
            continue
        between = ((size > BETWEEN[0] * codes) & (size < BETWEEN[1] * codes)).sum()
        scatter = float(np.sqrt(np.mean(slow[size < BETWEEN[0] * codes] ** 2)))
        # A code that has just passed the edge of a byte jumps by what it moved more, or less.
        off = abs(float(np.mean(size[jumps])) - codes)
        few = between <= MAX_BETWEEN * (up + down)
        if few and codes > CLEAR * scatter and off < 2.0 * scatter + 1.0:
            return bits
    return None


def _by_prediction(residual: np.ndarray, jump: float) -> np.ndarray:
    """(n,) the whole multiples of a jump in a residual by where most of it lies."""
    turns = 2.0 * np.pi * residual / jump
    phase = float(np.angle(np.nanmean(np.exp(1j * turns)))) / (2.0 * np.pi)
    return _about_usual(np.round(residual / jump - phase)) * jump


def _by_continuity(residual: np.ndarray, jump: float) -> np.ndarray:
    """The same where a prediction is off by as much: each row as near the one before as can be."""
    known = np.isfinite(residual)
    number = np.full(len(residual), np.nan)
    followed = np.unwrap(residual[known], period=jump)
    number[known] = np.round((residual[known] - followed) / jump)
    return _about_usual(number) * jump


def _by_neighbours(residual: np.ndarray, jump: float) -> np.ndarray:
    """The same where single rows are off and most of those about them are right."""
    usual = median_filter(np.nan_to_num(residual), NEIGHBOURS, mode="nearest")
    return np.nan_to_num(np.round((residual - usual) / jump)) * jump


WAYS = (_by_prediction, _by_continuity, _by_neighbours)


def _about_usual(number: np.ndarray) -> np.ndarray:
    """Whole numbers (n,) counted from the most frequent one; 0 where they are not known."""
    values, counts = np.unique(number[np.isfinite(number)], return_counts=True)
    return np.nan_to_num(number - values[counts.argmax()])


def _of_code(right: np.ndarray, added: np.ndarray, jump: float) -> bool:
    """Whether the error (n,) of a reading (n,) is determined by its code."""
    return _decided_by_code(right, added != 0.0, jump) or _torn(right, added, jump)


def _torn(right: np.ndarray, added: np.ndarray, jump: float) -> bool:
    """Whether the readings that are off have the high byte of the row before."""
    high = np.floor(right / jump + ROUNDING)
    carry = np.diff(high)
    off = added[1:] != 0.0
    before = np.round(added[1:] / jump) == -carry
    return bool(
        off.sum() >= MIN_JUMPS
        and before[off].mean() > MIN_TORN
        and np.mean(carry[np.isfinite(carry)] != 0.0) < MAX_CARRIES
    )


def _decided_by_code(right: np.ndarray, off: np.ndarray, jump: float) -> bool:
    """Whether the right reading (n,) decides which readings are off (n,) bool.

    By its place within a jump, or as a whole: what every other row says of each code must hold for
    the rows between.
    """
    known = np.isfinite(right)
    right, off = right[known], off[known]
    within = np.floor((right / jump) % 1.0 * BINS).astype(int).clip(0, BINS - 1)
    span = max(float(np.ptp(right)), jump)
    whole = np.floor((right - right.min()) / span * (BINS - 1)).astype(int)
    few = min(off.sum(), (~off).sum())
    return any(_undecided(place, off) <= MAX_UNDECIDED * few for place in (within, whole)) and bool(
        few >= MIN_JUMPS
    )


def _undecided(place: np.ndarray, off: np.ndarray) -> float:
    """Readings that are not what the rows between them say of their place (n,)."""
    learnt, tested = slice(0, None, 2), slice(1, None, 2)
    all_there = np.bincount(place[learnt], minlength=BINS)
    off_there = np.bincount(place[learnt], off[learnt], BINS)
    says_off = off_there > 0.5 * all_there
    return 2.0 * float((says_off[place[tested]] != off[tested]).sum())


def _event(found: Sequence[FaultyChannel], off: np.ndarray) -> CodeFault:
    parameters, texts = [], []
    for one in found:
        name, unit = CHANNELS[one.channel], UNITS[one.channel // 3]
        parameters.append(
            FoundParameter(name=f"jump_{name}", value=one.jump, unit=unit, u=1e-6 * one.jump)
        )
        texts.append(
            message(
                "events-code-fault-at", channel=message(f"channel-{name}"), codes=one.codes,
                jump=f"{one.jump:.4g} {unit}", share=f"{100.0 * one.share:.2g}",
            )
        )  # fmt: skip
    return CodeFault(
        "code_fault", tuple(one.channel for one in found), tuple(parameters), P_VALUE,
        message("events-code-fault", channels=tuple(texts)), off,
    )  # fmt: skip
