"""Codes that firmware joined wrongly, put right by what the numbers themselves show.

Readings on a lattice through zero are the whole numbers that the unit sent. Each usual mistake
makes neighbouring numbers jump by powers of two wherever the right ones pass an edge, and what puts
it right makes them follow one another; of right numbers it makes jumps. So each is a test of signs
over rows and those beside them, whatever moved the unit. Three kinds:

- a map of the number that can be turned round: a low part joined as a signed number, bytes in
  another order, two's complement read as unsigned;
- the number but for whole multiples of 2ᵐ: the low part joined by OR, which wipes out all above it,
  and a number that wraps where it is full: the multiple follows from the rows beside or the motion;
- a bit that sticks: every other block of 2ᵇ numbers never occurs (`tasks.readings.stuck_bits`).
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tasks.readings.stuck_bits import stuck_bit

TRIADS = ((0, 1, 2), (3, 4, 5))
TRIPLES = 40_000  # rows, each between two others, that are compared
GLANCE = 1_500  # of them by which most faults are ruled out
MUCH = 3.0  # times smoother, or rougher: numbers of several clusters become a little so by chance
MOST_ROUGHER = 0.4  # of the rows that become smoother: fast motion makes some
CLEARLY = 0.05  # of a mean logarithm: of two that do nearly as well the first, of usual sign
QUIET = 0.25  # of a size: a fourth of the rows bend by less, or the fault is below the noise
AS_USUAL, ROUNDING = 6.0, 3.0  # times what rows bend by, and numbers beside
Z = 6.0  # by which pairs that come nearer outnumber those that part: p = 1e-9
LOW_BITS = range(3, 21)
BYTE = 256.0
BYTE_ORDERS = ((1, 0), (2, 1, 0), (1, 0, 3, 2), (2, 3, 0, 1), (3, 2, 1, 0))  # lowest byte first
PERIODS = tuple(2.0**bits for bits in range(8, 33))
ACCIDENT = 1e-3  # of the rows: they may hold anything
MIN_CROSSINGS = 15  # into the rows whose high part is gone
MIN_PAGES = 3  # of 2ᵐ numbers each, that are read beside them
MIN_JUMPS = 2  # by a whole period
QUICK = 1.0 / 16.0  # of a period: 99 of 100 rows move by less
ALIKE = 0.9  # of the jumps by a period that are as small as changes beside them
BESIDE = 3  # rows
OF_ALL = ("signed-low", "unsigned")  # of which a channel need not show anything
ROUNDS = 3  # of faults of one channel
Right = Callable[[np.ndarray], np.ndarray]  # of numbers


@dataclass(frozen=True)
class Fault:
    """How a channel's numbers are wrong. bug: of WrongCodes. size: numbers, a power of two.

    sign: −1.0 where the file has the numbers inverted. right: turns the map round. free: tells the
    rows whose number is known but for multiples of `size`; of the others it is right.
    """

    bug: str
    size: float
    sign: float = 1.0
    right: Right | None = None
    free: Callable[[np.ndarray], np.ndarray] | None = None


def faults_of(numbers: dict[int, np.ndarray]) -> dict[int, list[Fault]]:
    """The faults of each channel that has any, in the order in which they are undone.

    One loop of the firmware joins the bytes of all channels: what is sure of one is held for the
    others, too, unless they speak against it.
    """
    found: dict[int, list[Fault]] = {}
    for triad in TRIADS:
        own = [c for c in triad if c in numbers]
        wiped = next((f for c in own if (f := _wiped(numbers[c]))), None)
        for c in own:
            bit = None if wiped else stuck_bit(numbers[c])
            found[c] = [wiped] if wiped else [_stuck(bit)] if bit else _turned(numbers[c])
    sure = [
        fault for c in found for fault in found[c][:1] if fault.bug in ("signed-low", "unsigned")
    ]
    for c, read in numbers.items():
        if not found[c]:
            found[c] = [fault for fault in sure[:1] if _does_no_harm(read, fault)]
    return {c: faults for c, faults in found.items() if faults}


def _stuck(weight: int) -> Fault:
    return Fault("stuck-high" if weight > 0 else "stuck-low", float(abs(weight)))


def _turned(numbers: np.ndarray) -> list[Fault]:
    """Faults whose map can be turned round, and numbers that wrap, one after the other."""
    found: list[Fault] = []
    for _ in range(ROUNDS):
        fault = _likeliest(numbers, {one.size for one in found}) or _wrapped(numbers)
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
    """The map whose inverse makes the numbers smoother than any other, if clearly smoother.

    tried: sizes that were put right. Noise as wide as the fault hides it: then nothing is said.
    """
    rows = _in_a_row(numbers)
    if not rows.size:
        return None
    before, best, least = _bend(rows), None, float(np.inf)
    some = rows[:, :: rows.shape[1] // GLANCE + 1]
    largest, far = np.abs(rows).max(), np.sort(before)
    for fault in MAPS:
        edge = 0.5 * (fault.size if fault.bug == "signed-low" else BYTE)
        if fault.size in tried or len(far) - np.searchsorted(far, edge) < Z**2:
            continue
        if fault.bug == "bytes" and not fault.size / (2.0 * BYTE) <= largest < fault.size:
            continue  # another word
        better, worse, _ = _smoother(some, fault)
        if worse - better > np.sqrt(better + worse):
            continue
        better, worse, after = _smoother(rows, fault)
        clear = better - worse > Z * np.sqrt(better + worse) and worse < MOST_ROUGHER * better
        if not clear or (fault.bug == "signed-low" and not _as_usual(before, after, edge)):
            continue
        rough = float(np.log1p(after).mean())
        if rough < least - CLEARLY:
            best, least = fault, rough
    return best if least < float(np.log1p(before).mean()) else None


def _as_usual(before: np.ndarray, after: np.ndarray, edge: float) -> bool:
    """Whether rows that jumped bend (m,) as all others do when they are put right, and less than
    the fault: another fault would leave a part of each jump. edge: half of the fault's size.
    """
    jumped = (before > edge) & (MUCH * after < before)
    usual = float(np.median(after[~jumped])) if not jumped.all() else float(np.median(after))
    quiet = np.quantile(after, 0.25) <= 2.0 * QUIET * edge
    return bool(quiet and np.median(after[jumped]) <= AS_USUAL * usual + ROUNDING)


def _smoother(rows: np.ndarray, fault: Fault) -> tuple[int, int, np.ndarray]:
    """How many of the numbers (3, m) bend much less by what puts a fault right, how many much more,
    and by how much (m,) they then bend.
    """
    assert fault.right is not None
    before, after = _bend(rows), _bend(fault.right(rows))
    return int((MUCH * after < before).sum()), int((after > MUCH * before).sum()), after


def _bend(rows: np.ndarray) -> np.ndarray:
    """By how much (m,) the second of three numbers (3, m) is off a straight line."""
    return np.asarray(np.abs(rows[0] - 2.0 * rows[1] + rows[2]))


def _in_a_row(numbers: np.ndarray) -> np.ndarray:
    """Numbers of three rows one after the other, (3, m), all known."""
    known = np.isfinite(numbers)
    rows = np.flatnonzero(known[2:] & known[1:-1] & known[:-2])
    rows = rows[:: len(rows) // TRIPLES + 1]
    return np.array([numbers[rows], numbers[rows + 1], numbers[rows + 2]])


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
                    crossings.sum() >= MIN_CROSSINGS and edge.sum() >= MIN_PAGES:  # fmt: skip
                return Fault("signed-low-or", size, sign, free=_negative_low(sign, size))
    return None


def _above(numbers: np.ndarray, size: float, share: float) -> tuple[np.ndarray, np.ndarray]:
    """Which numbers read −size/2 to −1, and which others have a low part above a share of it."""
    pile = (numbers < 0.0) & (numbers >= -0.5 * size)
    return pile, ~pile & (np.mod(numbers, size) >= share * size)


def _negative_low(sign: float, size: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda numbers: _above(sign * numbers, size, 0.5)[0]


def _wrapped(numbers: np.ndarray) -> Fault | None:
    """A number that begins again where it is full, or whose negative half is read above it."""
    known = numbers[np.isfinite(numbers)]
    if len(known) < 2:
        return None
    for sign in (1.0, -1.0):
        least, most = float((sign * known).min()), float((sign * known).max())
        unsigned = least >= 0.0
        full = most + 1.0 if unsigned else 2.0 * max(most + 1.0, -least)
        period = next((p for p in PERIODS if full <= p), np.inf)
        if np.isfinite(period) and _jumps(known, period):
            if unsigned:
                return Fault("unsigned", period, sign, _both(sign, _signed(period)))
            return Fault("wrap", period, free=np.isfinite)
    return None


def _jumps(known: np.ndarray, period: float) -> bool:
    """Whether numbers jump by a whole period where they would else move as they do beside."""
    change = np.diff(known)
    within = change - period * np.round(change / period)
    jump = np.abs(change) > 0.5 * period
    if jump.sum() < MIN_JUMPS or np.quantile(np.abs(within), 0.99) > QUICK * period:
        return False
    rows = np.flatnonzero(jump)
    calm = np.where(jump, 0.0, np.abs(within))
    beside = [k for k in range(-BESIDE, BESIDE + 1) if k]
    places = np.clip(rows[:, None] + beside, 0, len(within) - 1)
    usual = calm[places].max(axis=1)
    return bool((np.abs(within[rows]) <= 4.0 * usual + 4.0).mean() >= ALIKE)


def _does_no_harm(numbers: np.ndarray, fault: Fault) -> bool:
    """Whether a channel's numbers (n,) may have a fault that is sure of another channel."""
    if fault.bug == "unsigned":
        own = fault.sign * numbers[np.isfinite(numbers)]
        return bool(len(own) and own.min() >= 0.0 and 0.5 * fault.size <= own.max() < fault.size)
    better, worse, _ = _smoother(_in_a_row(numbers), fault)
    return worse <= better
