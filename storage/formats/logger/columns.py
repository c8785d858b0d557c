"""Which column of a logger's table is which channel, by its name and the unit in it."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from schemas.recording import ACCEL, ANGLE, AXES, GYRO, Segment
from schemas.text import Message, Seen
from storage.formats.convert import STANDARD_GRAVITY
from storage.formats.logger.sheet import Sheet
from storage.formats.logger.units import DEG, EXAMPLES, QUANTITIES, Scale, plain, quantity_of, scale

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
        if place not in taken
        and not sheet.is_numeric(place)
        and sheet.text(place).str.contains(":").mean() > 0.5
    ]


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


# The unit of each channel: given, in the header, or by what leaves no doubt.

OF_FORCE = (  # usual sizes of gravity in a unit, and the unit
    (1.0, "g"), (STANDARD_GRAVITY, "m/s2"), (1000.0, "mg"), (16384.0, "16384/g"),
    (8192.0, "8192/g"), (4096.0, "4096/g"), (2048.0, "2048/g"),
)  # fmt: skip
OF_RATE = ("deg/s", "rad/s", "mdps", "131/dps", "65.5/dps", "32.8/dps", "16.4/dps")
NEAR = 0.12  # of a usual size


def scale_of(
    name: str, own: Mapping[str, Column], given: Mapping[str, str], gravity: float,
    raw: Mapping[str, np.ndarray], t: np.ndarray, labels: tuple[Segment, ...],
) -> tuple[Scale | None, str]:  # fmt: skip
    """The unit of a triad and how it is known; or None and what to ask."""
    quantity = QUANTITIES[name]
    written = next(iter(own.values())).unit
    for text, how in ((given.get(name), "--units"), (written, "header")):
        if text and (one := scale(quantity, text, gravity)) is not None:
            return one, how
        if text and how == "--units":
            return None, f"--units {name}={text}: no such unit; it may be {EXAMPLES[quantity]}"
    if name == "temperature":
        return Scale("degC", 1.0), "taken for °C"
    values = np.array(list(raw.values()))
    if name == "accel":
        size = float(np.nanmedian(np.linalg.norm(values, axis=0)))
        for usual, text in OF_FORCE:
            if abs(size / usual - 1.0) < NEAR:
                return scale(quantity, text, gravity), f"gravity reads {size:.5g}"
    if name == "gyro" and (text := _unit_by_rates(raw, t, labels)):
        return scale(quantity, text, gravity), "by the rates of the protocol"
    stated = f" (its header says {written!r})" if written else ""
    return None, (
        f"{name}: in which unit are {', '.join(c.name for c in own.values())}?{stated} Give "
        f"--units {name}=…: {EXAMPLES[quantity]}"
    )


def _unit_by_rates(
    raw: Mapping[str, np.ndarray], t: np.ndarray, labels: tuple[Segment, ...]
) -> str | None:
    """The usual unit in which the gyros read the rates that the protocol says."""
    ratios = []
    for label in labels:
        rows = slice(*np.searchsorted(t, (label.t_start, label.t_end)))
        if label.kind != "rate" or not label.rate_deg_s or rows.stop - rows.start < 3:
            continue
        if all(channel in raw for channel in GYRO):
            means = [abs(float(np.nanmedian(raw[f"gyro_{axis}"][rows]))) for axis in AXES]
            ratios.append(abs(label.rate_deg_s) / max(*means, 1e-12))
    if not ratios:
        return None
    usual = float(np.median(ratios)) * DEG
    fits = [(abs(np.log(usual / one.factor)), text) for text in OF_RATE
            if (one := scale("rate", text, 1.0)) is not None]  # fmt: skip
    nearest = min(fits)
    return nearest[1] if nearest[0] < NEAR else None


# What stands in a table that is no reading of its one unit: marks of no data, copies of a column,
# rows of another sensor.
#
# A mark is one number for each axis that stands there again and again, and is not near what
# stands beside it: an end of the codes' range, exact zeros, a constant. A shock or a turn that a
# range cuts off reaches the same end, but does so axis by axis, and through what lies between; a
# sensor that hangs repeats the row before.

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
        for mark in _no_data_candidates(values):
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


def _no_data_candidates(values: np.ndarray) -> Iterator[np.ndarray]:
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
