"""Codes that firmware joined wrongly: what the numbers themselves make likely.

Readings on a lattice through zero are the whole numbers that the unit sent. Each usual mistake
makes neighbouring numbers jump by powers of two wherever the right ones pass an edge, and what puts
it right makes them follow one another; of right numbers it makes jumps. Three kinds:

- a map of the number that can be turned round: a low part joined as a signed number, bytes in
  another order, two's complement read as unsigned;
- the number but for whole multiples of a size: the low part joined by OR,
  which wipes out all above it, and a number that wraps where it is full: the multiple follows
  from the rows beside or the motion;
- a bit that sticks: every other block of 2ᵇ numbers never occurs (`tasks.readings.stuck_bits`).
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tasks.readings.judge import CERTAIN, bend, in_blocks, spread
from tasks.readings.stuck_bits import stuck_bit

TRIADS = ((0, 1, 2), (3, 4, 5))
GLANCE, LOOK = 50, 1200  # blocks of rows by which most faults are ruled out, and the others judged
FEWEST = 6  # rows that bend by the fault
CLEARLY, ALIKE = 5.0, 0.02  # log odds, of them: of two that do as well the first, of usual sign
LOW_BITS = range(3, 21)
BYTE = 256.0
BYTE_ORDERS = ((1, 0), (2, 1, 0), (1, 0, 3, 2), (2, 3, 0, 1), (3, 2, 1, 0))  # lowest byte first
PERIODS = tuple(2.0**bits for bits in range(8, 33))
NEAR, SAME = 5e-3, 0.02  # of a period: off a power of two, and jumps of one period apart
ACCIDENT = 1e-3  # of the rows: they may hold anything
MIN_PAGES = 3  # of 2ᵐ numbers each, that are read beside them
ROUNDS = 3  # of faults of one channel
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
    for triad in TRIADS:
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
    for _ in range(ROUNDS):
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
        if fault.size in tried or len(bent) - np.searchsorted(bent, edge) < FEWEST:
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
    return wrap(usual if abs(usual - found) <= NEAR * usual else float(np.rint(found)))


def wrap(period: float) -> Fault:
    """That a number begins again after a period."""
    return Fault("wrap", period, free=np.isfinite)


def jumps(numbers: np.ndarray) -> np.ndarray:
    """By how much (k,) numbers (n,) jump from row to row, beside the change in the rows about:
    where by all that is ever read, for what wraps reads no more than that.
    """
    least = float(np.fmin.reduce(numbers, initial=np.inf))
    most = float(np.fmax.reduce(numbers, initial=-np.inf))
    above = numbers > 0.5 * (least + most)  # what jumps by more than half passes the middle
    rows = np.flatnonzero(above[1:-2] != above[2:-1]) + 1
    change = [numbers[rows + k + 1] - numbers[rows + k] for k in (-1, 0, 1)]
    size = np.abs(change[1] - 0.5 * (change[0] + change[2]))
    return size[size >= (1.0 - SAME) * (most - least)] if most > least else size[:0]


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
