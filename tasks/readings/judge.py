"""Whether readings that were put right fit themselves better than they did as they were.

One ratio of likelihoods for all that is put right on sight. By a fault, what was put right goes on
as the readings beside it that nothing touched. By a real event (a tap, a shock, a stop) it goes on
as it was, and an event is of any size: its logarithm is spread evenly. So a repair that leaves as
large a jump as it takes away, or one among readings that jump as far by themselves, gains nothing;
only one after which jumps of many times the usual change are gone, each to within that change.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from tasks.readings.line import Line
from tasks.readings.robust import TO_SIGMA, deviation

CERTAIN = 20.0  # log odds from which on something is put right: one in 5e8 against it
BLOCK = 32  # rows whose scatter is taken as that of each of them
ACCIDENT = 1e-3  # of what was put right: it may hold anything
AT_MOST = (
    8.0  # log odds of a block either way: all of it may be one event, or a beat of one oscillation
)
SPEAKS = 1.0  # log odds from which on a block speaks for a fault or against it
# Share of those that may speak against it by an event of their own, and what each of more counts.
SPARED, DENIED = 0.2, 24.0
EVENTS = (ACCIDENT, 0.03, 0.1, 0.3, 1.0)  # shares of what was not, that events may have made
CORE = 3.0  # standard deviations within which all is as usual, whatever the form of the noise
SIZES = 11.0  # natural logarithm of the range of an event's size: five powers of ten
BEND_ROUNDING = 0.7  # numbers: standard deviation of a bend of whole ones
SOME = 1500  # blocks, or stretches, that are looked at, of more


def log_odds(
    off: np.ndarray, was: np.ndarray, usual: np.ndarray, chosen: float = np.inf
) -> np.ndarray:
    """Log odds (…) that things are off by less now that they were put right, against real events.

    off, was: (…, k) by how much each is off what is expected, put right and before; NaN of those
    that were not touched. usual: (…, k) standard deviation of what nothing happens to. chosen: a
    size, multiples of which were chosen for the least off: by chance that lies anywhere within it.
    """
    anything = 0.5 / SIZES / np.maximum(np.maximum(np.abs(off), np.abs(was)), usual)
    anything = np.maximum(anything, 0.5 / np.maximum(chosen, 4.0 * usual))
    fault = (1.0 - ACCIDENT) * _density(off, usual) + ACCIDENT * anything
    calm = np.where(np.isfinite(off), _density(was, usual), np.nan)
    event = [np.nansum(np.log((1.0 - q) * calm + q * anything), axis=-1) for q in EVENTS]
    return np.asarray(np.nansum(np.log(fault), axis=-1) - np.max(event, axis=0))


def _density(off: np.ndarray, usual: np.ndarray) -> np.ndarray:
    """Even in the core, and beyond falling as Student's of three degrees of freedom does."""
    return np.asarray(0.375 / CORE / usual / np.maximum(1.0, np.abs(off) / (CORE * usual)) ** 4)


def in_course(
    numbers: np.ndarray, right: np.ndarray, rounding: float = BEND_ROUNDING, chosen: float = np.inf
) -> float:
    """Log odds of a repair, by how numbers (n,) and those put right bend from row to row.

    rounding: standard deviation of a bend, at least; that of whole numbers.
    """
    blocks = _blocks(numbers), _blocks(right)
    touched = np.flatnonzero((np.diff(blocks[1] - blocks[0], axis=1) != 0.0).any(axis=1))
    touched = touched[:: len(touched) // SOME + 1]
    odds = in_blocks(blocks[0][touched], blocks[1][touched], rounding, chosen)
    better, worse = (odds > SPEAKS).sum(), (odds < -SPEAKS).sum()
    denied = DENIED * max(0.0, worse - SPARED * better)
    return float(np.clip(odds, -AT_MOST, AT_MOST).sum() - denied)


def in_blocks(
    numbers: np.ndarray, right: np.ndarray, rounding: float = BEND_ROUNDING, chosen: float = np.inf
) -> np.ndarray:
    """The same (blocks,) of numbers in blocks of successive rows, (blocks, rows)."""
    was, off = bend(numbers), bend(right)
    known = np.isfinite(was) & np.isfinite(off)
    touched = known & (np.abs(was - off) > 1e-9 * np.abs(was))
    # Each jump bends two rows.
    usual = np.minimum(*(_usual(each, known, rounding) for each in (off, was)))
    return 0.5 * log_odds(np.where(touched, off, np.nan), was, usual, chosen)


def _usual(bends: np.ndarray, known: np.ndarray, rounding: float) -> np.ndarray:
    """Standard deviation of most bends of a block, at each of them (blocks, rows)."""
    size = np.sort(np.where(known, np.abs(bends), np.inf), axis=1)
    middle = np.take_along_axis(size, known.sum(axis=1, keepdims=True) // 2, axis=1)
    return np.asarray(
        np.broadcast_to(np.maximum(TO_SIGMA * middle, max(rounding, 1e-12)), bends.shape)
    )


def in_motion(numbers: np.ndarray, right: np.ndarray, line: Line, chosen: float) -> float:
    """Log odds of a repair, by the motion: one for each stretch of rows that was moved as a whole.

    Numbers (n,) that were not moved tell the line that all follow. Where no motion is known, a unit
    turns and moves within about the range that it reads.
    """
    off = np.where(np.isfinite(right), right - numbers, 0.0)
    edges = np.flatnonzero(np.diff(off, prepend=0.0, append=0.0))
    middle = (edges[:-1] + edges[1:]) // 2
    middle = middle[off[middle] != 0.0]
    middle = middle[:: len(middle) // SOME + 1]
    if not len(middle):
        return 0.0
    predicted = np.zeros(len(middle))
    usual = np.full(len(middle), 0.5 * float(np.fmax.reduce(numbers) - np.fmin.reduce(numbers)))
    calm = line.known & np.isfinite(numbers) & (right == numbers)
    if calm.any():
        scatter = deviation((numbers - line.columns @ line.ideal)[calm])
        least = 1e-4 * float(np.abs(numbers[calm]).max()) + 1e-12
        through, u = line.through(numbers, calm, max(scatter, least))
        felt = line.known[middle]
        predicted[felt] = through[middle][felt]
        usual[felt] = np.hypot(u[middle], deviation((numbers - through)[calm]))[felt]
    off, was = ((each[middle] - predicted) for each in (right, numbers))
    return float(log_odds(off, was, usual, chosen))


def spread(numbers: np.ndarray, count: int) -> np.ndarray:
    """(blocks, rows) of numbers (n,), about `count` blocks from all over."""
    blocks = _blocks(numbers)
    return np.asarray(blocks[:: len(blocks) // count + 1])


def bend(numbers: np.ndarray) -> np.ndarray:
    """By how much the middle one of three numbers (…, n) is off the middle of the others, twice."""
    return np.asarray(np.diff(numbers, 2, axis=-1))


def _blocks(numbers: np.ndarray) -> np.ndarray:
    """Numbers (n,) in blocks in which each bend stands once, (blocks, BLOCK + 2)."""
    width = min(BLOCK + 2, len(numbers))
    return sliding_window_view(numbers, width)[::BLOCK]
