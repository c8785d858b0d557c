"""Codes that firmware joined wrongly, put right before any model."""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import takewhile

import numpy as np

from schemas.recording import ACCEL, GYRO, TRIADS, Recording, WrongCodes
from schemas.text import Remark
from tasks.motion.whole import gravity_of
from tasks.readings.judge import (
    BEND_ROUNDING,
    CERTAIN,
    bend,
    in_blocks,
    in_course,
    in_motion,
    spread,
)
from tasks.readings.lattice import code_lattices, quantiser_of
from tasks.readings.line import Course, Line
from tasks.readings.robust import deviation, median
from tasks.words import Message, message, remark

# Bits that stick: every other block of 2ᵇ numbers never occurs.
#
# The readings reach up to both ends of the stretches that are read, and none lies beyond: noise
# that is wider than a code would have carried some there.

BITS = tuple(range(2, 15))
MIN_PERIODS = 3  # of 2ᵇ⁺¹ codes, with readings
CLEAR_ODDS = 7.0  # log odds: of one in a thousand
MIXTURE_ROUNDS = 8  # of expectation and maximisation
MEDIAN_CHI2 = 0.4549  # of one degree of freedom


def stuck_bit(numbers: np.ndarray) -> tuple[int, float] | None:
    """What a stuck bit adds to a number, by whole numbers (n,): ±2ᵇ, and its log odds against
    chance; None where none may be stuck.
    """
    number = numbers[np.isfinite(numbers)].astype(np.int64)
    if len(number) < 2:
        return None
    change = np.abs(np.diff(number))
    near = max(1, round(0.5 * float(np.median(change)) / 0.954))  # 0.6745·√2 of the noise
    for bit in BITS:
        level = number >> bit & 1
        if level.min() != level.max() or len(np.unique(number >> bit + 1)) < MIN_PERIODS:
            continue
        place = number & (1 << bit) - 1
        width = min(near, 1 << bit - 2)
        ends = (place < width).sum(), (place >= (1 << bit) - width).sum()
        if min(ends):  # of those at an end, chance puts half of them beyond
            odds = 2.0 * float(np.log(2.0)) * min(ends)
            return (1 << bit if level[0] else -(1 << bit)), odds
    return None


def put_back(numbers: np.ndarray, weight: float, line: Line) -> tuple[np.ndarray, np.ndarray]:
    """The right numbers (n,), and which of them are not decided.

    weight: that the bit adds to some of them. line: that the right numbers follow. Where noise is
    as wide as the bit, the expectation of the two. Where the rows beside speak against the line,
    nothing is decided.
    """
    felt = line.known & np.isfinite(numbers)
    added, odds = np.zeros(len(numbers)), np.zeros(len(numbers))
    for _ in range(MIXTURE_ROUNDS if felt.any() else 0):
        predicted, _ = line.through(numbers - added, felt, abs(weight))
        off = numbers - predicted
        variance = max(float(np.median((off - added)[felt] ** 2)) / MEDIAN_CHI2, 1e-12)
        odds = (off**2 - (off - weight) ** 2) / (2.0 * variance)
        added = np.where(felt, weight / (1.0 + np.exp(-np.clip(odds, -50.0, 50.0))), 0.0)
    clear = felt & (np.abs(odds) > CLEAR_ODDS)
    right = numbers - np.where(clear, weight * (odds > 0.0), added)
    beside = right.copy()
    beside[1:-1] -= 0.5 * (right[:-2] + right[2:])
    denied = clear & (np.abs(beside) > 0.5 * abs(weight))
    return right, np.isfinite(numbers) & (~felt | denied)


# Codes that firmware joined wrongly: what the numbers themselves make likely.
#
# Readings on a lattice through zero are the whole numbers that the unit sent. Each usual mistake
# makes neighbouring numbers jump by powers of two wherever the right ones pass an edge, and what
# puts it right makes them follow one another; of right numbers it makes jumps. Three kinds:
#
# - a map of the number that can be turned round: a low part joined as a signed number, bytes in
#   another order, two's complement read as unsigned;
# - the number but for whole multiples of a size: the low part joined by OR,
#   which wipes out all above it, and a number that wraps where it is full: the multiple follows
#   from the rows beside or the motion;
# - a bit that sticks: every other block of 2ᵇ numbers never occurs (`tasks.readings.codes`).

TRIAD_COLUMNS = ((0, 1, 2), (3, 4, 5))
JUMP_ROWS = 1 << 14  # that are compared at once: little memory, and most have no large change
GLANCE, LOOK = 50, 1200  # blocks of rows by which most faults are ruled out, and the others judged
FEWEST_BENDS = 6  # rows that bend by the fault
CLEARLY, ALIKE = 5.0, 0.02  # log odds, of them: of two that do as well the first, of usual sign
LOW_BITS = range(3, 21)
BYTE = 256.0
BYTE_ORDERS = ((1, 0), (2, 1, 0), (1, 0, 3, 2), (2, 3, 0, 1), (3, 2, 1, 0))  # lowest byte first
PERIODS = tuple(2.0**bits for bits in range(8, 33))
NEAR_PERIOD, SAME = 5e-3, 0.02  # of a period: off a power of two, and jumps of one period apart
ACCIDENT = 1e-3  # of the rows: they may hold anything
MIN_PAGES = 3  # of 2ᵐ numbers each, that are read beside them
FAULT_ROUNDS = 3  # of faults of one channel
OF_ALL = ("signed-low", "unsigned")  # of which a channel need not show anything
Right = Callable[[np.ndarray], np.ndarray]  # of numbers


@dataclass(frozen=True)
class Fault:
    """How a channel's numbers are wrong. bug: of WrongCodes. size: numbers, a power of two.

    sign: −1.0 where the file has the numbers inverted. right: turns the map round. free: tells the
    rows whose number is known but for multiples of `size`; of the others it is right. odds: log
    odds by numbers that never occur, against chance.
    """

    bug: str
    size: float
    sign: float = 1.0
    right: Right | None = None
    free: Callable[[np.ndarray], np.ndarray] | None = None
    odds: float = 0.0


def faults_of(numbers: dict[int, np.ndarray]) -> dict[int, list[Fault]]:
    """The faults that each channel may have, in the order in which they are undone.

    One loop of the firmware joins the bytes of all channels: what one has, others may have, too.
    """
    found: dict[int, list[Fault]] = {}
    for triad in TRIAD_COLUMNS:
        own = [c for c in triad if c in numbers]
        wiped = next((f for c in own if (f := _wiped(numbers[c]))), None)
        for c in own:
            bit = None if wiped else stuck_bit(numbers[c])
            found[c] = [wiped] if wiped else [_stuck(*bit)] if bit else _turned(numbers[c])
    maps = [fault for faults in found.values() for fault in faults[:1] if fault.bug in OF_ALL]
    for c, read in numbers.items():
        if not found[c]:
            found[c] = [
                fault for fault in maps[:1] if fault.bug != "unsigned" or _above_half(read, fault)
            ]
    return {c: faults for c, faults in found.items() if faults}


def _stuck(weight: int, odds: float) -> Fault:
    return Fault("stuck-high" if weight > 0 else "stuck-low", float(abs(weight)), odds=odds)


def _turned(numbers: np.ndarray) -> list[Fault]:
    """Faults whose map can be turned round, and numbers that wrap, one after the other."""
    found: list[Fault] = []
    for _ in range(FAULT_ROUNDS):
        fault = (
            _likeliest(numbers, {one.size for one in found})
            or _unsigned(numbers)
            or _wrapped(numbers)
        )
        if fault is None:
            break
        found.append(fault)
        if fault.right is None:
            break
        numbers = fault.right(numbers)
    return found


def _maps() -> Iterator[Fault]:
    for sign in (1.0, -1.0):
        for bits in LOW_BITS:
            size = 2.0**bits
            yield Fault("signed-low", size, sign, _both(sign, _joined(size)))
        for order in BYTE_ORDERS:
            yield Fault("bytes", BYTE ** len(order), sign, _both(sign, _ordered(order)))


def _likeliest(numbers: np.ndarray, tried: Collection[float]) -> Fault | None:
    """The map whose inverse is likelier than any other, and than the numbers as they are.

    tried: sizes that were put right.
    """
    if not np.isfinite(numbers).any():
        return None
    rows, some = spread(numbers, LOOK), spread(numbers, GLANCE)
    bent = np.abs(bend(rows))
    bent = np.sort(bent[np.isfinite(bent)])
    largest, best, most = np.nanmax(np.abs(rows)), None, CERTAIN
    for fault in MAPS:
        edge = 0.5 * (fault.size if fault.bug == "signed-low" else BYTE)
        if fault.size in tried or len(bent) - np.searchsorted(bent, edge) < FEWEST_BENDS:
            continue
        if fault.bug == "bytes" and not fault.size / (2.0 * BYTE) <= largest < fault.size:
            continue  # another word
        assert fault.right is not None
        if in_blocks(some, fault.right(some)).sum() < -CLEARLY:
            continue
        odds = float(in_blocks(rows, fault.right(rows)).sum())
        if odds > most:
            best, most = fault, odds + max(CLEARLY, ALIKE * odds)
    return best


def _both(sign: float, right: Right) -> Right:
    return right if sign > 0 else lambda numbers: -right(-numbers)


def _joined(size: float) -> Right:
    """Of high·size + low, where a low of half the size and more was taken as negative."""
    return lambda numbers: numbers + size * (np.mod(numbers, size) >= 0.5 * size)


def _ordered(order: Sequence[int]) -> Right:
    """Of bytes put in another order; order: the place that each byte, lowest first, is read from.

    Each of these orders is its own inverse.
    """
    whole = BYTE ** len(order)

    def right(numbers: np.ndarray) -> np.ndarray:
        unsigned = np.mod(np.where(np.isfinite(numbers), numbers, 0.0), whole).astype(np.int64)
        bytes_ = [unsigned >> 8 * place & 0xFF for place in order]
        joined = sum(byte << 8 * place for place, byte in enumerate(bytes_))
        signed = np.where(joined >= whole / 2, joined - whole, joined)
        return np.where(np.isfinite(numbers), signed, np.nan)

    return right


def _signed(period: float) -> Right:
    return lambda numbers: numbers - period * (numbers >= 0.5 * period)


MAPS = tuple(_maps())


def _wiped(numbers: np.ndarray) -> Fault | None:
    """A signed low part joined by OR: its sign wipes out the high part.

    Such numbers all read −size/2 to −1, and no other number has such a low part.
    """
    known = numbers[np.isfinite(numbers)]
    glance, largest = known[:: len(known) // GLANCE + 1], np.abs(known).max(initial=0.0)
    for sign in (1.0, -1.0):
        for bits in LOW_BITS:
            size = 2.0**bits
            if size > largest or _above(sign * glance, size, 0.5)[1].mean() > 10.0 * ACCIDENT:
                continue
            pile, outside = _above(sign * known, size, 0.5)
            far = ~pile & (np.abs(known) >= size)
            pages = np.unique(np.floor(sign * known[far] / size))
            crossings = pile[1:] & far[:-1]
            edge = crossings & _above(sign * known, size, 0.375)[1][:-1]
            if outside.sum() <= ACCIDENT * pile.sum() and len(pages) >= MIN_PAGES and \
                    edge.sum() >= MIN_PAGES:  # fmt: skip
                # By a real event a number may come to lie on any page.
                odds = float(crossings.sum() * np.log(2.0 * len(pages)))
                return Fault("signed-low-or", size, sign, free=_negative_low(sign, size), odds=odds)
    return None


def _above(numbers: np.ndarray, size: float, share: float) -> tuple[np.ndarray, np.ndarray]:
    """Which numbers read −size/2 to −1, and which others have a low part above a share of it."""
    pile = (numbers < 0.0) & (numbers >= -0.5 * size)
    return pile, ~pile & (np.mod(numbers, size) >= share * size)


def _negative_low(sign: float, size: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda numbers: _above(sign * numbers, size, 0.5)[0]


def _unsigned(numbers: np.ndarray) -> Fault | None:
    """Two's complement whose negative half is read above the other."""
    known = numbers[np.isfinite(numbers)]
    if len(known) < 2:
        return None
    change = float(np.abs(np.diff(known)).max())
    for sign in (1.0, -1.0):
        least, most = float((sign * known).min()), float((sign * known).max())
        period = next((p for p in PERIODS if most < p), np.inf)
        if least >= 0.0 and change > 0.5 * period:
            return Fault("unsigned", period, sign, _both(sign, _signed(period)))
    return None


def _wrapped(numbers: np.ndarray) -> Fault | None:
    """A number that begins again where it is full."""
    found = period_of([jumps(numbers)])
    if found is None:
        return None
    usual = min(PERIODS, key=lambda one: abs(one - found))
    return wrap(usual if abs(usual - found) <= NEAR_PERIOD * usual else float(np.rint(found)))


def wrap(period: float) -> Fault:
    """That a number begins again after a period."""
    return Fault("wrap", period, free=np.isfinite)


def jumps(numbers: np.ndarray) -> np.ndarray:
    """By how much (k,) numbers (n,) jump from row to row, beside the change in the rows about:
    where by all that is ever read, for what wraps reads no more than that.
    """
    blocks = [numbers[i : i + JUMP_ROWS + 3] for i in range(0, len(numbers), JUMP_ROWS)]
    least = np.array([np.fmin.reduce(block, initial=np.inf) for block in blocks])
    most = np.array([np.fmax.reduce(block, initial=-np.inf) for block in blocks])
    lowest, highest = least.min(initial=np.inf), most.max(initial=-np.inf)
    if not highest > lowest:
        return np.empty(0)
    smallest, middle = (1.0 - SAME) * (highest - lowest), 0.5 * (lowest + highest)
    passing = (least <= middle) & (most > middle)  # as what jumps by more than half does
    found = []
    for i in np.flatnonzero(passing & (2.0 * (most - least) >= smallest)).tolist():
        block = blocks[i]
        above = block > middle
        rows = np.flatnonzero(above[1:-2] != above[2:-1]) + 1
        change = [block[rows + k + 1] - block[rows + k] for k in (-1, 0, 1)]
        size = np.abs(change[1] - 0.5 * (change[0] + change[2]))
        found.append(size[size >= smallest])
    return np.concatenate(found) if found else np.empty(0)


def period_of(of_channels: Sequence[np.ndarray]) -> float | None:
    """What numbers begin again after, by the jumps (k,) of each channel; None where no two are
    alike, or where no channel comes back as what wraps does.
    """
    if max(map(len, of_channels), default=0) < 2:
        return None
    sizes = np.concatenate(of_channels)
    alike = sizes[np.abs(sizes - np.median(sizes)) <= SAME * np.median(sizes)]
    return float(alike.mean()) if len(alike) > 1 else None


def _above_half(numbers: np.ndarray, fault: Fault) -> bool:
    """Whether all numbers (n,) are as those that are read as unsigned."""
    own = fault.sign * numbers[np.isfinite(numbers)]
    return bool(len(own) and own.min() >= 0.0 and 0.5 * fault.size <= own.max() < fault.size)


# Numbers that are known but for whole multiples of a size: which multiple, by rows beside them
# and by what the unit felt.

LATTICE_ROUNDS = 4
SCATTER = 0.5  # of the size: of a number about the line, for rows beside it err alike
SURE_LINE = 0.125  # of the size: uncertainty of the line, beyond which it decides nothing
NEAR_LATTICE = 0.4  # of the size: by which numbers may be off the line
MOST_NOISE = 0.12  # of the size: standard deviation beyond which no single number is decided
MEMORY = 0.5  # of the change from row to row


def resolved(
    numbers: np.ndarray, free: np.ndarray, size: float, line: Line
) -> tuple[np.ndarray, np.ndarray]:
    """The numbers (n,), and which of them are not decided.

    free: (n,) bool, numbers that whole multiples of the size are missing from. line: that the
    numbers follow. By the line where it is known and sure; elsewhere as the rows before and after
    go on, where both say the same.
    """
    known = np.isfinite(numbers)
    free = free & known
    every = bool(free[known].all())
    if every:
        onwards = _unwrapped(numbers, size)
        if (felt := known & line.known).any():
            off = np.median((line.columns[felt] @ line.ideal) - onwards[felt])
            onwards = onwards + size * np.round(off / size)
        backwards = onwards
    else:
        onwards = _followed(numbers, free, size)
        backwards = _followed(numbers[::-1], free[::-1], size)[::-1]
    agreed = known & (~free | (onwards == backwards))
    felt, by_line = known & line.known, np.zeros(len(numbers), bool)
    values, used = np.where(agreed, onwards, numbers), felt & (agreed if every else ~free)
    for _ in range(LATTICE_ROUNDS if felt.any() else 0):
        predicted, u = line.through(values, used, SCATTER * size)
        nearest = np.where(free, numbers + size * np.round((predicted - numbers) / size), numbers)
        used = felt & (u < SURE_LINE * size) & (np.abs(nearest - predicted) < NEAR_LATTICE * size)
        by_line = free & used
        values = np.where(by_line, nearest, np.where(agreed, onwards, numbers))
    undecided = known & free & ~by_line & ~agreed
    noise = deviation(np.diff(values[used])) / np.sqrt(2.0) if used.any() else 0.0
    return values, free if noise > MOST_NOISE * size else undecided


def _unwrapped(numbers: np.ndarray, size: float) -> np.ndarray:
    """All numbers as each is nearest to the one before, the usual one as near zero as can be."""
    known = np.isfinite(numbers)
    values = np.full(len(numbers), np.nan)
    followed = np.unwrap(numbers[known], period=size)
    values[known] = followed - size * np.round(np.median(followed) / size)
    return values


def _followed(numbers: np.ndarray, free: np.ndarray, size: float) -> np.ndarray:
    """Each free number (n,) as near as can be to where those before it go; NaN before the first."""
    values = np.where(free, np.nan, numbers)
    last, slope = np.nan, 0.0
    for row, (number, open_) in enumerate(zip(numbers.tolist(), free.tolist(), strict=True)):
        if number != number:
            continue
        if open_:
            if last != last:
                continue
            number += size * round((last + slope - number) / size)
            values[row] = number
        if last == last:
            slope += MEMORY * (number - last - slope)
        last = number
    return values


# Numbers in offset binary: half of the codes' range was never taken off them.
#
# No sensor reads half of its range at rest; what is read beside that is right, and the half is a
# power of two of codes. Gravity, of which the repair knows nothing, shows that of accelerometers.

SAMPLE = 20_000  # rows that are looked at
OFFSET_BITS = range(8, 24)
NEAR_HALF = 0.05  # of the half, by which a gyro's usual reading may be off it
LIKE_GRAVITY = 0.15  # of gravity, by which accelerometers may read it wrongly
CODE = "offset_binary"


def offset_taken_off(recording: Recording) -> Recording:
    """The recording with half of the range taken off triads that are in offset binary, which it
    says; itself where none is."""
    imu, put_right = recording.imu, recording.put_right
    if any(one.code == CODE for one in put_right) or not len(imu):
        return recording
    columns = dict(imu.columns)
    for triad in TRIADS:
        if not set(triad) <= set(columns):
            continue
        every = len(imu) // SAMPLE + 1
        sample = np.array([each[::every] for each in imu.views(triad, slice(0, len(imu)))])
        sample = sample[:, np.isfinite(sample).all(axis=0)]
        if not sample.shape[1] or sample.min() <= 0.0:
            continue
        found = _half(sample, gravity_of(recording) if triad[0].startswith("accel") else None)
        if found is None:
            continue
        bits, half = found
        columns |= {c: columns[c] - one for c, one in zip(triad, half, strict=True)}
        sentence = message("plausibility-offset-binary", sensors=triad[0][:-2], codes=1 << bits,
                           read=f"{float(half.mean()):.6g}")  # fmt: skip
        put_right = (*put_right, remark(CODE, sentence, blocks_pass=True, run="remarks"))
    if put_right is recording.put_right:
        return recording
    return replace(recording, imu=replace(imu, columns=columns), put_right=put_right)


def _half(sample: np.ndarray, gravity: float | None) -> tuple[int, np.ndarray] | None:
    """The bit that is half of the range of a triad (3, n) whose readings are all above zero, and
    that half (3,) in its unit; None where none is.
    """
    lattices = [quantiser_of(channel) for channel in sample]
    steps = np.array([lattice.step for lattice in lattices if lattice is not None])
    if not len(steps):
        return None
    step, usual = np.full(3, steps.min()), median(sample)
    for bit in OFFSET_BITS:
        half = step * (1 << bit)
        if (sample > 2.0 * half[:, None]).any():
            continue
        if gravity is None:
            is_half = bool((np.abs(usual / half - 1.0) < NEAR_HALF).all())
        else:
            sizes = [np.median(np.linalg.norm(each, axis=0)) for each in
                     (sample, sample - half[:, None])]  # fmt: skip
            off = np.abs(np.array(sizes) / gravity - 1.0)
            is_half = bool(off[0] > LIKE_GRAVITY > off[1])
        if is_half:
            return bit, half
    return None


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
    for triad in TRIAD_COLUMNS:  # what is no whole number may wrap, too
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
            odds += in_course(numbers, decided, BEND_ROUNDING if step != 1.0 else 0.0, fault.size)
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
