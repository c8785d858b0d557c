"""Which column of a logger's table is which channel, by its name and the unit in it."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

from schemas.recording import ACCEL, ANGLE, AXES, GYRO
from storage.formats.logger.sheet import Sheet
from storage.formats.logger.units import plain, quantity_of

CHANNELS = ("t", *GYRO, *ACCEL, "temperature", *ANGLE)
GYRO_WORDS = {"gyro", "gyr", "gy", "gyros", "gyroscope", "omega", "w", "angvel", "angrate"}
ACCEL_WORDS = {"accel", "acc", "ac", "accels", "acceleration", "accelerometer", "a", "f"}
RATE_WORDS = ({"angular", "ang", "rotation", "turn"}, {"rate", "velocity", "vel", "speed"})
FILLING = {  # words without further information
    "imu", "sensor", "data", "raw", "of", "axis", "value", "reading", "specific", "force", "field",
    "angular", "rotation", "rate", "velocity", "ang", "vel", "lsb", "counts", "msg", "scaled",
}  # fmt: skip
OTHER = {  # words of what is neither rate nor specific force
    "mag", "magn", "magnetometer", "magnetic", "compass", "quat", "quaternion", "euler", "ypr",
    "rpy", "lat", "lon", "latitude", "longitude", "gps", "gnss", "bias", "std", "sigma", "var",
    "cov", "covariance", "delta", "dv", "dq", "dtheta", "integral", "relative", "clip", "clipping",
    "timestamp", "time", "count", "counter", "status", "gravity", "grav", "err", "error", "dt",
    "position", "pos", "temp", "temperature", "offset", "heading", "field_b", "orientation",
}  # fmt: skip
WITHOUT_GRAVITY = {"linear", "user", "free", "lin"}  # used only if there is nothing else
PENALTY = 10
TIME_WORDS = {
    "time", "timestamp", "timestamps", "t", "ts", "elapsed", "millis", "micros", "clock", "seconds",
    "secs", "datetime", "epoch", "utc", "uptime", "date", "stamp", "nanos",
}  # fmt: skip
TIME_FILLING = {
    "accelerometer", "gyro", "accel", "imu", "sensor", "sample", "fine", "since", "reboot", "boot",
    "startup", "system", "start", "unix", "abs", "absolute",
}  # fmt: skip
EXACT_TIME = {"t", "time", "timestamp", "elapsed", "x_value", "sampletimefine", "ms", "us", "ns"}
NO_TIME = {
    "zone", "week", "relative", "delta", "dt", "age", "location", "gps", "heading", "offset",
    "battery", "activity", "pedometer", "altimeter", "integral",
}  # fmt: skip
WARM = {"temp", "temperature", "tmp"}
BRACKETED = re.compile(r"[\[(]([^\])]*)[\])]")
WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
LAST_AXIS = re.compile(r"(.+?)([xyz])")
UNIT_ENDS = (  # of names such as wx_rad_s
    "rad_per_s", "deg_per_s", "m_per_s2", "rad_s", "deg_s", "rads", "dps", "mdps", "degs", "m_s2",
    "ms2", "mps2", "mg", "g", "rad", "deg", "s", "ms", "us", "ns", "usec", "msec", "sec", "lsb",
    "c", "degc",
)  # fmt: skip


@dataclass(frozen=True)
class Column:
    """A column that was found: its channel, its place, its name and unit as they were written.

    penalty: how many of its words are not those of its channel. stem: its name without the axis.
    """

    channel: str
    place: int
    name: str
    unit: str
    penalty: int
    stem: str


@dataclass(frozen=True)
class Found:
    """The columns by channel; question: what is not clear, with the way to say it; or nothing.

    times: all that may be the time, the likeliest first.
    """

    columns: Mapping[str, Column]
    question: str = ""
    times: tuple[Column, ...] = ()


def find_columns(sheet: Sheet, given: Mapping[str, str]) -> Found:
    """The columns of a sheet; `given` are by name or, from 1, by number, and go before what is
    found. Faults of what is given stand in the sheet's faults.
    """
    columns = {channel: _given(sheet, channel, text) for channel, text in given.items()}
    known = {channel: column for channel, column in columns.items() if column is not None}
    unclear: list[str] = []
    times = [known["t"]] if "t" in known else []
    if sheet.named:
        every = [c for k in range(len(sheet.names)) for c in _candidates(sheet, k)]
        for triad in (GYRO, ACCEL):
            free = [c for c in every if c.place not in {one.place for one in known.values()}]
            missing = [channel for channel in triad if channel not in known]
            chosen, several = _triad(free, triad)
            known |= {channel: chosen[channel] for channel in missing if channel in chosen}
            unclear += several if len(missing) == len(triad) else []
        for channel in ("t", "temperature"):
            one = sorted((c for c in every if c.channel == channel), key=lambda c: c.penalty)
            if one and channel not in known:
                known[channel] = one[0]
                times += one if channel == "t" else []
        times += () if times else _clocks(sheet, {one.place for one in known.values()})
    twice = [name for name in dict.fromkeys(sheet.names) if name and sheet.names.count(name) > 1]
    why = f" ({', '.join(twice)} stands twice in the header)" if twice else ""
    sheet.faults += [
        f"{triad[0][:-2]}: no column is found for {', '.join(missing)}{why}; name it by --columns"
        for triad in (GYRO, ACCEL)
        if (missing := [c for c in triad if c not in known]) and len(missing) < len(triad)
    ]
    if not set(known) & {*GYRO, *ACCEL, *ANGLE} and not unclear:
        unclear.append("no column is found that is a rate or a specific force")
    if not unclear:
        return Found(known, times=tuple(times))
    listed = ", ".join(f"{k}: {name or '-'}" for k, name in enumerate(sheet.names, start=1))
    wanted = ",".join(f"{c}=…" for c in ("t", *GYRO, *ACCEL) if c not in known)
    return Found(
        known,
        f"{'; '.join(unclear)}: which are they? Give --columns {wanted} by name or number (there "
        f"are {listed})",
    )


def _clocks(sheet: Sheet, taken: set[int]) -> list[Column]:
    """Columns that are a time by their form, in whatever language their names are."""
    return [
        Column("t", place, name, "", PENALTY, "")
        for place, name in enumerate(sheet.names)
        if place not in taken and not sheet.is_numeric(place)
        and sheet.text(place).str.contains(":").mean() > 0.5
    ]  # fmt: skip


def _given(sheet: Sheet, channel: str, text: str) -> Column | None:
    wanted = text.strip()
    folded = [name.casefold() for name in sheet.names]
    place = folded.index(wanted.casefold()) if wanted.casefold() in folded else None
    if place is None and wanted.isdecimal() and 1 <= int(wanted) <= len(sheet.names):
        place = int(wanted) - 1
    if place is None:
        close = [k for k, name in enumerate(folded) if _bare(name) == _bare(wanted.casefold())]
        place = close[0] if len(close) == 1 else None
    if place is None:
        sheet.faults.append(
            f"--columns {channel}={text}: there is no such column (there are "
            f"{', '.join(sheet.names)})"
        )
        return None
    return Column(channel, place, sheet.names[place], _named_unit(sheet, place)[1], 0, "")


def _bare(name: str) -> str:
    return BRACKETED.sub("", name).strip(" _")


def _named_unit(sheet: Sheet, place: int) -> tuple[str, str]:
    """The name without its unit, and the unit: in brackets, at its end, or in a row of units."""
    name = sheet.names[place]
    inside = [text for text in BRACKETED.findall(name) if text.strip() and not text.isdecimal()]
    unit = sheet.units[place].strip("[]() ") or next(iter(inside), "")
    bare = BRACKETED.sub(lambda one: f" {one[1]} " if one[1].isdecimal() else " ", name).strip()
    for end in UNIT_ENDS:
        for joint in ("_", " ", "/", ","):
            if bare.lower().endswith(joint + end) and len(bare) > len(end) + 1:
                head = bare[: -len(end) - 1]
                return head, unit or end
            place_of = bare.lower().find(f"{joint}{end} ")
            if place_of > 0:  # gyro_rad[0], accelerometer_m_s2[0]
                return bare[:place_of] + bare[place_of + len(end) + 1 :], unit or end
    return bare, unit


def words_of(name: str) -> list[str]:
    return [word.lower() for word in WORD.findall(name)]


def _candidates(sheet: Sheet, place: int) -> list[Column]:
    """What a column may be, by its words and its unit."""
    bare, unit = _named_unit(sheet, place)
    name, words = sheet.names[place], words_of(bare)
    quantity = quantity_of(unit)
    made: list[Column] = []
    is_exact = bare.lower().replace(" ", "") in EXACT_TIME
    is_time = bool(set(words) & TIME_WORDS) or is_exact or quantity == "time"
    if is_time and not set(words) & NO_TIME and quantity in (None, "time"):
        strange = len([w for w in words if w not in TIME_WORDS | TIME_FILLING])
        strange += PENALTY * (not set(words) & TIME_WORDS)  # by its unit alone
        made.append(Column("t", place, name, unit, 0 if is_exact else 1 + strange, ""))
    is_warm = bool(set(words) & WARM) or (quantity == "warmth" and not words)
    if is_warm and quantity in (None, "warmth"):
        made.append(Column("temperature", place, name, unit, len(words) - 1, ""))
    axis, rest = _axis(_from_zero(words, sheet.names, name))
    if axis is None or set(rest) & OTHER:
        return made
    kind = _kind(rest, quantity)
    if kind is not None:
        vocabulary = FILLING | (GYRO_WORDS if kind == "gyro" else ACCEL_WORDS)
        penalty = len([w for w in rest if w not in vocabulary and w not in WITHOUT_GRAVITY])
        penalty += PENALTY * len(WITHOUT_GRAVITY & set(rest)) * (quantity != "count")
        stem = " ".join(rest)
        made.append(Column(f"{kind}_{axis}", place, name, unit, penalty, stem))
    return made


def _from_zero(words: list[str], names: Sequence[str], name: str) -> list[str]:
    """The words of a name with its number from 0 where those of its kind are 1, 2 and 3."""
    kind = re.sub(r"[123](?=\D*$)", "{}", name)
    is_numbered = kind != name and all(kind.format(k) in names for k in (1, 2, 3))
    if not is_numbered or kind.format(0) in names or not words[-1].isdecimal():
        return words
    return [*words[:-1], str(int(words[-1]) - 1)]


def _axis(words: list[str]) -> tuple[str | None, list[str]]:
    """The axis that a name tells, and its other words."""
    numbers = {"0": "x", "1": "y", "2": "z"}
    for k in reversed(range(len(words))):
        if words[k] in AXES:
            return words[k], words[:k] + words[k + 1 :]
    last = words[-1] if words else ""
    if last in numbers and len(words) > 1:
        return numbers[last], words[:-1]
    found = LAST_AXIS.fullmatch(last)
    stems = GYRO_WORDS | ACCEL_WORDS | {"g", "rate", "rot"}
    if found and found[1] in stems:
        return found[2], [*words[:-1], found[1]]
    return None, words


def _kind(words: Sequence[str], quantity: str | None) -> str | None:
    """gyro or accel: by the unit where it tells, else by the words."""
    is_gyro = bool(GYRO_WORDS & set(words)) or all(set(words) & some for some in RATE_WORDS)
    is_accel = bool(ACCEL_WORDS & set(words))
    if quantity == "rate":
        return "gyro"
    if quantity == "force" and not is_gyro:
        return "accel" if is_accel or "g" not in words else None
    if "g" in words and not is_accel and quantity != "force":  # gx beside ax
        is_gyro = True
    if is_gyro == is_accel:
        return None
    return "gyro" if is_gyro else "accel"


def _triad(every: list[Column], triad: tuple[str, ...]) -> tuple[dict[str, Column], list[str]]:
    """The whole triad with the fewest strange words; several alike are not clear."""
    own = sorted((c for c in every if c.channel in triad), key=lambda c: (c.stem, plain(c.unit)))
    families = [list(group) for _, group in groupby(own, key=lambda c: (c.stem, plain(c.unit)))]
    whole = [family for family in families if {c.channel for c in family} == set(triad)]
    if not whole:
        return {c.channel: c for c in own}, []
    least = min(family[0].penalty for family in whole)
    best = [family for family in whole if family[0].penalty == least]
    if len(best) > 1 or any(len(family) > len(triad) for family in best):
        names = " or ".join(family[0].name for family in best)
        return {}, [f"{triad[0][:-2]} may begin with {names}"]
    return {c.channel: c for c in best[0]}, []
