"""Units as people and loggers write them, and what a value of theirs is in SI."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING
from unicodedata import normalize

import numpy as np

if TYPE_CHECKING:
    import pandas as pd


DEG = math.pi / 180.0
RATE: Mapping[str, float] = {
    "rad/s": 1.0, "rads": 1.0, "radps": 1.0, "mrad/s": 1e-3, "deg/s": DEG, "degs": DEG,
    "degps": DEG, "dps": DEG, "d/s": DEG, "mdps": 1e-3 * DEG, "mdeg/s": 1e-3 * DEG,
    "deg/h": DEG / 3600.0, "deg/hr": DEG / 3600.0, "dph": DEG / 3600.0, "rpm": 6.0 * DEG,
}  # fmt: skip
FORCE: Mapping[str, float] = {
    "m/s2": 1.0, "mps2": 1.0, "ms2": 1.0, "ms-2": 1.0, "m/ss": 1.0, "mm/s2": 1e-3, "cm/s2": 1e-2,
    "gal": 1e-2, "ft/s2": 0.3048,
}  # fmt: skip
GRAVITIES: Mapping[str, float] = {
    "g": 1.0, "gn": 1.0, "g0": 1.0, "gee": 1.0, "gs": 1.0, "mg": 1e-3, "millig": 1e-3, "ug": 1e-6,
}  # fmt: skip
TIME: Mapping[str, float] = {
    "s": 1.0, "ms": 1e-3, "msec": 1e-3, "millis": 1e-3, "milliseconds": 1e-3, "millisecond": 1e-3,
    "us": 1e-6, "usec": 1e-6, "micros": 1e-6, "microseconds": 1e-6, "microsecond": 1e-6,
    "ns": 1e-9, "nsec": 1e-9, "nanos": 1e-9, "nanoseconds": 1e-9, "nanosecond": 1e-9,
    "min": 60.0, "minutes": 60.0, "h": 3600.0, "hours": 3600.0,
}  # fmt: skip
WARMTH: Mapping[str, tuple[float, float]] = {
    "degc": (1.0, 0.0), "c": (1.0, 0.0), "celsius": (1.0, 0.0), "degcelsius": (1.0, 0.0),
    "k": (1.0, -273.15), "kelvin": (1.0, -273.15),
    "degf": (5.0 / 9.0, -160.0 / 9.0), "f": (5.0 / 9.0, -160.0 / 9.0),
}  # fmt: skip
ANGLE: Mapping[str, float] = {"rad": 1.0, "deg": DEG, "mrad": 1e-3, "mdeg": 1e-3 * DEG}
WORDS = (
    ("degrees", "deg"), ("degree", "deg"), ("radians", "rad"), ("radian", "rad"),
    ("persecond", "/s"), ("per", "/"), ("/seconds", "/s"), ("/second", "/s"), ("/sec", "/s"),
    ("/s/s", "/s2"), ("s-1", "/s"), ("seconds", "s"), ("second", "s"), ("secs", "s"),
    ("meters", "m"), ("meter", "m"), ("metres", "m"), ("hour", "h"),
)  # fmt: skip
NUMBER = r"([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)"
COUNTS = re.compile(rf"{NUMBER}(?:lsb|counts?|digits?)?/\(?([^()]+)\)?$")
SCALED = re.compile(rf"{NUMBER}\*?([a-z(][^()]*\)?)(?:/(?:lsb|count|digit))?$")
QUANTITIES = {"gyro": "rate", "accel": "force", "t": "time", "temperature": "warmth",
              "angle": "angle"}  # fmt: skip
EXAMPLES = {
    "rate": "rad/s, deg/s, mdps, deg/h, rpm, or counts as 131/dps",
    "force": "m/s2, g, mg, ft/s2, or counts as 16384/g",
    "time": "s, ms, us, ns, or a rate of rows as 100Hz",
    "warmth": "degC, K, degF",
    "angle": "rad, deg",
}


@dataclass(frozen=True)
class Scale:
    """SI value = factor · value + offset; text: the unit as it was written."""

    text: str
    factor: float
    offset: float = 0.0


def plain(text: str) -> str:
    """A unit without differences in notation: case, spaces, powers, signs."""
    text = normalize("NFKC", text).replace("μ", "u").replace("°", "deg").strip()
    text = text.replace("**", "").replace("^", "").replace(" ", "").replace("·", "")
    text = text.lower().replace("_", "/").replace("mps2", "m/s2").replace("mpss", "m/s2")
    for word, unit in WORDS:
        if text not in TIME:
            text = text.replace(word, unit)
    return re.sub("/+", "/", text)


def scale(quantity: str, text: str, gravity: float) -> Scale | None:
    """What a value in a unit is in SI; None for a unit that the quantity does not have.

    quantity: rate, force, time, warmth, angle. gravity: m/s² that one g is. Counts are written by
    their sensitivity, as 131/dps, or by the unit of one count, as 0.061mg.
    """
    unit = plain(text)
    if quantity == "warmth":
        return Scale(text, *WARMTH[unit]) if unit in WARMTH else None
    factor = _factor(quantity, unit, gravity)
    if factor is None and (found := COUNTS.fullmatch(unit)) and float(found[1]):
        per = _factor(quantity, found[2], gravity)
        factor = None if per is None else per / float(found[1])
    if factor is None and (found := SCALED.fullmatch(unit)):
        per = _factor(quantity, found[2].strip("()"), gravity)
        factor = None if per is None else per * float(found[1])
    return None if factor is None else Scale(text, factor)


def is_in_g(text: str) -> bool:
    """Whether a specific force in this unit depends on what one g is."""
    one, two = (scale("force", text, gravity) for gravity in (1.0, 2.0))
    return one != two


def quantity_of(text: str) -> str | None:
    """The quantity that a unit alone identifies, if any: `g` and `s` do, a stray word does not."""
    for quantity in ("rate", "force", "time", "angle", "warmth"):
        if text and scale(quantity, text, 1.0) is not None:
            return quantity
    return None


def _factor(quantity: str, unit: str, gravity: float) -> float | None:
    if quantity == "rate":
        return RATE.get(unit)
    if quantity == "force":
        return FORCE.get(unit, GRAVITIES[unit] * gravity if unit in GRAVITIES else None)
    return (TIME if quantity == "time" else ANGLE).get(unit)


# Times as loggers and people write them, as seconds.

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
            row,
            float(steps[row - 1]),
            row in begun_at or (anew and 0.0 <= times.seconds[row] < BEGUN),
        )
        for row in moved_at.tolist()
    )


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
