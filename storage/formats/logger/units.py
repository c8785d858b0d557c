"""Units as people and loggers write them, and what a value of theirs is in SI."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from unicodedata import normalize

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
