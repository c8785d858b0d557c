"""Times as loggers and people write them, as seconds."""

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from storage.formats.logger.units import TIME, plain

if TYPE_CHECKING:
    import pandas as pd

OF_DAY = re.compile(r"(?:(\d{1,2}):)?(\d{1,2}):(\d{1,2}(?:[.,]\d+)?)")
DAY_S = 86400.0
EPOCHS = ((1e17, 1e-9, "ns"), (1e14, 1e-6, "us"), (1e11, 1e-3, "ms"), (1e8, 1.0, "s"))
LATEST = 4e9  # s since 1970, in 2096
RATES = (4.0, 2e4)  # Hz: how often inertial units are read
COUNTERS = (2.0**16, 2.0**24, 2.0**32)
# share of the rows after which a clock may be set; above it, rows are out of order
SET_BACK = 1e-3
BEGUN = 10.0  # s: a clock that shows less after a break has begun anew
FASTEST = 1e6  # Hz: rows that come faster are no samples of an inertial unit
UNITS = (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9))


@dataclass(frozen=True)
class ClockBreak:
    """row: the first one after it, taken to come one interval later, for stamps do not tell what
    passed. step: s from the stamp before to that one as they were written. began: whether the unit
    or its logger began anew there.
    """

    row: int
    step: float
    began: bool


@dataclass(frozen=True)
class Times:
    """seconds: (n,) of a clock; kind: how it counts (number, of day, epoch); unit: as written, or
    found; NaN where a value is no time. breaks: where the clock did not run on.
    """

    seconds: np.ndarray
    kind: str
    unit: str = "s"
    breaks: tuple[ClockBreak, ...] = ()


def of_text(text: "pd.Series") -> Times:
    """Times of day (hh:mm:ss.fff, mm:ss.fff) or date-times; NaN for what is neither."""
    import pandas as pd

    if text[text != ""].str.fullmatch(OF_DAY.pattern).all():
        parts = text.str.extract(OF_DAY).fillna("0")
        parts[2] = parts[2].str.replace(",", ".", regex=False)
        hours, minutes, seconds = (parts[k].astype(float).to_numpy() for k in range(3))
        day = 3600.0 * hours + 60.0 * minutes + seconds
        day = np.where((text == "").to_numpy(), np.nan, day)
        past = np.concatenate([[0.0], np.cumsum(np.diff(day) < -0.5 * DAY_S)])
        return Times(day + DAY_S * past, "of day", "hh:mm:ss")
    dotted = text.str.replace(r"(\d),(\d)", r"\1.\2", regex=True)
    european = bool(dotted.str.match(r"\d{1,2}\.\d{1,2}\.\d{4}").any())
    moments = pd.to_datetime(dotted, errors="coerce", utc=True, format="mixed", dayfirst=european)
    nanoseconds = moments.astype("datetime64[ns, UTC]").astype("int64").to_numpy()
    seconds = np.where(moments.isna().to_numpy(), np.nan, nanoseconds / 1e9)
    return Times(seconds, "epoch", "date and time")


def of_numbers(values: np.ndarray, unit: str, name: str = "") -> Times | None:
    """Numbers as seconds, by their unit, by being moments since 1970, or by the only unit in which
    rows come as often as inertial units are read; None where that does not tell.
    """
    steps = np.diff(values[np.isfinite(values)])
    steps = steps[steps > 0]
    if not len(steps):
        return Times(values * TIME.get(plain(unit), 1.0), "number", unit or "s")
    kind = "number"
    size = float(np.nanmedian(np.abs(values)))
    epochs = [(f, u) for low, f, u in EPOCHS if size > low and size * f < LATEST]
    if plain(unit) in TIME:
        factor, found = TIME[plain(unit)], plain(unit)
        kind = "epoch" if size * factor > EPOCHS[-1][0] else kind
    elif epochs and RATES[0] < 1.0 / (np.median(steps) * epochs[0][0]) < RATES[1]:
        (factor, found), kind = epochs[0], "epoch"
    else:
        named = [u for u in ("millis", "micros", "nanos") if u in name.lower()]
        usual = float(np.median(steps))
        fits = [(u, f) for u, f in UNITS if RATES[0] <= 1.0 / (usual * f) <= RATES[1]]
        if named:
            factor, found = TIME[named[0]], named[0]
        elif len(fits) == 1:
            found, factor = fits[0]
        else:
            return None
    return Times(unwrapped(values) * factor, kind, found)


def unwrapped(values: np.ndarray) -> np.ndarray:
    """A counter of 16, 24 or 32 bits that began anew goes on."""
    falls = np.diff(values)
    for top in COUNTERS:
        if values.max() < top and (falls < -0.9 * top).any():
            return values + top * np.concatenate([[0.0], np.cumsum(falls < -0.9 * top)])
    return values


def apart(seconds: np.ndarray) -> tuple[np.ndarray, int]:
    """Stamps that rise, of rows that share one, spread evenly until the next; and how many did."""
    first = np.flatnonzero(np.concatenate([[True], np.diff(seconds) != 0.0]))
    sizes = np.diff(np.append(first, len(seconds)))
    shared = int(sizes[sizes > 1].sum())
    if not shared or len(first) < 2:
        return seconds, shared
    stamps = seconds[first]
    steps = np.append(np.diff(stamps), np.median(np.diff(stamps)) * sizes[-1] / np.median(sizes))
    within = np.arange(len(seconds)) - np.repeat(first, sizes)
    return np.repeat(stamps, sizes) + within * np.repeat(steps / sizes, sizes), shared


def breaks_of(times: Times, moved_at: np.ndarray, begun_at: np.ndarray) -> tuple[ClockBreak, ...]:
    """The breaks of stamps as they were written, by the rows from which on the clock was set, and
    those before which the header stands again.
    """
    steps = np.diff(times.seconds)
    anew = times.kind == "number" and times.seconds[0] >= 0.0
    return tuple(
        ClockBreak(
            row, float(steps[row - 1]),
            row in begun_at or (anew and 0.0 <= times.seconds[row] < BEGUN),
        )
        for row in moved_at.tolist()
    )  # fmt: skip


def running_on(seconds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Stamps (n,) s of a clock that runs on where it was set, and the rows (k,) from which on it
    was: the first of them came one interval after the row before, as far as can be known.

    It was set where it falls, and where it leaps by more than a day. Stamps stay as they are, and
    no row is named, where the next row is back in its place, or where so many are: then rows are
    not in their order.
    """
    steps = np.diff(seconds)
    back, ahead = steps < 0.0, steps > DAY_S
    moved_at = np.flatnonzero(back | ahead) + 1
    falls = np.flatnonzero(back) + 1
    stays = seconds[np.minimum(falls + 1, len(seconds) - 1)] < seconds[falls - 1]
    usual = np.median(steps[~ahead & (steps > 0.0)]) if (~ahead & (steps > 0.0)).any() else 0.0
    few = len(moved_at) <= max(1.0, SET_BACK * len(seconds))
    if not len(moved_at) or not stays.all() or not few or not usual > 0.0:
        return seconds, moved_at[:0]
    moved = np.zeros(len(seconds))
    moved[moved_at] = usual - steps[moved_at - 1]
    return seconds + np.cumsum(moved), moved_at
