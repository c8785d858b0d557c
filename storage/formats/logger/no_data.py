"""What stands in a table that is no reading of its one unit: marks of no data, copies of a column,
rows of another sensor.

A mark is one number for each axis that stands there again and again, and is not near what stands
beside it: an end of the codes' range, exact zeros, a constant. A shock or a turn that a range cuts
off reaches the same end, but does so axis by axis, and through what lies between; a sensor that
hangs repeats the row before.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from schemas.recording import ACCEL, GYRO
from schemas.text import Message, Seen
from storage.formats.logger.columns import words_of
from storage.formats.logger.sheet import Sheet

FEWEST = 3  # rows with a mark
MOST = 0.9  # of the rows
FAR = 8.0  # times what neighbours usually differ by
USUAL = 0.8  # quantile of how far marks are off the readings beside them: of gyros few turn
SPREAD = 0.01  # of the rows: as many marks of one axis alone are no shocks, and as many rows with
# one constant are held by no sensor that hangs
BY_ONE = 0.1  # of the marks: rows in which one axis alone is there, as of a range that is too small
GAP = 0.7  # of a mark's distance from the middle within which all readings of its axis lie
SAMPLED = 20_000  # rows that constants are looked for in
VARIED = 10  # different numbers of a column that is a copy of another, and not just as still

SENSOR_WORDS = {"id", "sensor", "device", "node", "address", "imu", "source"}
MANY, LEAST = 8, 0.05  # most sensors in a file, and the smallest share of its rows that one has
HEAD_ROWS = 1000  # that show whether a column tells so few things apart
IN_TURN = 0.95  # of the rows that repeat the order of the sensors
UNLIKE = 0.3  # of how a reading usually differs from that of the same sensor before


def without_marks(raw: Mapping[str, np.ndarray]) -> tuple[dict[str, np.ndarray], list[Seen]]:
    """The channels (n,) with NaN where a triad holds marks of no data, and what was left out; the
    whole triad where two of its columns are one.
    """
    made, seen = dict(raw), list[Seen]()
    for triad in (GYRO, ACCEL):
        if not set(triad) <= set(raw):
            continue
        values, name = np.array([raw[c] for c in triad]), triad[0][:-2]
        if copied := _copies(values):
            first, *others = (triad[k] for k in copied)
            seen.append(Seen("column_copied", Message("seen-copies", (
                ("first", first), ("others", ", ".join(others)), ("rows", values.shape[1]),
                ("sensors", name),
            )), run="invalid"))  # fmt: skip
            made |= {c: np.full(values.shape[1], np.nan) for c in triad}
            continue
        for mark in _candidates(values):
            rows = _marked(values, mark)
            if rows is not None:
                seen.append(Seen("no_data", Message("seen-no-data", (
                    ("sensors", name), ("count", int(rows.sum())), ("rows", len(rows)),
                    ("mark", ", ".join(f"{one:g}" for one in mark if np.isfinite(one))),
                )), run="valid"))  # fmt: skip
                values = np.where(rows, np.nan, values)
        made |= dict(zip(triad, values, strict=True))
    return made, seen


def _copies(values: np.ndarray) -> list[int]:
    """The columns (3, n) of which one repeats another in every row."""
    for first in range(2):
        others = [k for k in range(first + 1, 3) if np.array_equal(values[k], values[first])]
        if others and len(np.unique(values[first, :SAMPLED])) > VARIED:
            return [first, *others]
    return []


def _candidates(values: np.ndarray) -> Iterator[np.ndarray]:
    """Numbers (3,) that may be marks: the ends of what is read, zeros, what stands there most; and
    of one axis alone, with NaN for the others.
    """
    if not np.isfinite(values).any():
        return
    low, high = np.nanmin(values, axis=1), np.nanmax(values, axis=1)
    yield from (low, high, np.where(-low > high, low, high), np.zeros(3))
    sample = values[:, :: values.shape[1] // SAMPLED + 1]
    often, count = np.unique(sample, axis=1, return_counts=True)
    if count.max() > SPREAD * sample.shape[1]:
        yield often[:, int(count.argmax())]
    for k in range(3):
        for end in (low[k], high[k]):
            yield np.where(np.arange(3) == k, end, np.nan)


def _marked(values: np.ndarray, mark: np.ndarray) -> np.ndarray | None:
    """Which rows (n,) bool of a triad (3, n) hold a mark; None where it is none."""
    own = np.isfinite(mark)
    rows = np.all(values[own] == mark[own, None], axis=0)
    count = int(rows.sum())
    if not FEWEST <= count <= MOST * len(rows):
        return None
    known = values[own][:, ~rows & np.isfinite(values).all(axis=0)]
    if known.shape[1] < FEWEST:
        return None
    usual = _usual_steps(known)
    before = np.cumsum(~rows & np.isfinite(values).all(axis=0))[rows] - 1
    beside = known[:, before.clip(0)]
    off = (np.abs(mark[own, None] - beside) / usual[:, None]).max(axis=0)
    if np.quantile(off, USUAL) < FAR:
        return None
    if own.sum() < len(mark):
        return rows if _alone(known[0], float(mark[own][0]), count / len(rows)) else None
    by_one = int((values == mark[:, None]).any(axis=0).sum()) - count
    return rows if by_one <= BY_ONE * count or not mark.any() else None


def _usual_steps(known: np.ndarray) -> np.ndarray:
    """(k,) by how much readings (k, n) usually differ from the one before where they differ at all;
    without end for those that never move: of them nothing is far.
    """
    step = np.abs(np.diff(known, axis=1))
    return np.array([np.median(one[one > 0.0]) if (one > 0.0).any() else np.inf for one in step])


def _alone(known: np.ndarray, mark: float, share: float) -> bool:
    """Whether an end of what one axis reads is a mark: it stands there often, and far from all."""
    middle = float(np.median(known))
    return share > SPREAD and bool(np.abs(known - middle).max() < GAP * abs(mark - middle))


def several_sensors(
    sheet: Sheet, taken: set[int], raw: Mapping[str, np.ndarray], seconds: np.ndarray
) -> list[str]:
    """A sentence where rows of several sensors stand in one table: a column that is not read tells
    them apart by its name, or takes turns with other readings each time; or rows do so that share
    a stamp.

    raw: the channels' readings. seconds: (n,) stamps as they were written.
    """
    for place, name in enumerate(sheet.names):
        if place in taken or sheet.frame.iloc[:HEAD_ROWS, place].nunique() not in range(2, MANY):
            continue
        values, number, counts = np.unique(
            sheet.text(place).to_numpy(str), return_inverse=True, return_counts=True
        )
        if not 1 < len(values) <= MANY or counts.min() <= LEAST * len(sheet.frame):
            continue
        if set(words_of(name)) & SENSOR_WORDS or _take_turns(number, len(values), raw):
            return [
                f"column {name} tells {len(values)} sensors apart ({', '.join(values)}): which of "
                "them is to be read? Give a file with the rows of one"
            ]
    together = np.append(False, np.diff(seconds) == 0.0)
    if together.mean() > LEAST:
        first = np.flatnonzero(~together)
        within = np.arange(len(seconds)) - np.repeat(first, np.diff([*first, len(seconds)]))
        count = int(within.max()) + 1
        if count <= MANY and _take_turns(within, count, raw):
            return [
                f"each stamp has {count} rows with readings of their own, as of {count} sensors in "
                "one table: which of them is to be read? Give a file with the rows of one"
            ]
    return []


def _take_turns(number: np.ndarray, count: int, raw: Mapping[str, np.ndarray]) -> bool:
    """Whether rows (n,) of so many kinds come in turn, and read by far not the same.

    Motion moves what is read from one kind to the other as it moves it back: it cancels.
    """
    if len(number) < 10 * count or np.mean(number[count:] == number[:-count]) < IN_TURN:
        return False
    for values in raw.values():
        step, again = np.diff(values), values[count:] - values[:-count]
        to, back = (step[number[1:] == k] for k in (1, 0))
        to, back = to[np.isfinite(to)], back[np.isfinite(back)]
        if min(len(to), len(back)) < 10:
            continue
        apart = 0.5 * abs(float(to.mean() - back.mean()))
        chance = 0.5 * float(np.hypot(to.std() / len(to) ** 0.5, back.std() / len(back) ** 0.5))
        if apart > max(6.0 * chance, UNLIKE * float(np.nanmedian(np.abs(again)))):
            return True
    return False
