"""Made recordings of a unit whose firmware joins, wraps or loses bits: the right numbers are known.

Shares no code with what finds such faults: words are packed to bytes and read back as the firmware
would, with the standard library's integers.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from schemas.recording import Recording, Stream
from tests.manifests import THREE_AXES, manifest_of

GRAVITY = 9.8015
# Angles of middle and inner axis, and which axis of the unit then points up.
PLACES = (
    (0.0, 0.0, "+z"), (90.0, 0.0, "+y"), (90.0, 90.0, "+x"), (90.0, 180.0, "-y"),
    (90.0, 270.0, "-x"), (180.0, 270.0, "-z"),
)  # fmt: skip


@dataclass(frozen=True)
class Made:
    """A recording, its right readings (n, 6), and the rows (n,) bool of its segments."""

    recording: Recording
    right: np.ndarray
    held: np.ndarray
    step: np.ndarray


@dataclass(frozen=True)
class Unit:
    """rate: Hz. bits: of a word. counts: per deg/s and per g. noise: deg/s and g. quick: deg/s²."""

    rate: float = 100.0
    bits: int = 16
    counts: tuple[float, float] = (131.0, 8192.0)
    noise: tuple[float, float] = (0.05, 0.002)
    quick: float = 100.0
    top: float = 200.0


UNITS = (
    Unit(),
    Unit(rate=25.0, counts=(262.4, 16384.0), top=100.0, quick=40.0),
    Unit(rate=200.0, counts=(32.8, 4096.0), noise=(0.1, 0.005)),
    Unit(rate=50.0, counts=(16.4, 2048.0), noise=(0.08, 0.003)),
    Unit(rate=250.0, counts=(131.0, 16384.0), quick=300.0),
    Unit(counts=(65.5, 8192.0), top=400.0, quick=200.0),
    Unit(rate=10.0, quick=40.0),
    Unit(rate=13.0, counts=(262.4, 16384.0), top=100.0, quick=40.0, noise=(0.07, 0.004)),
    Unit(bits=24, counts=(20000.0, 1.0e6), noise=(0.004, 5e-5)),
    Unit(bits=24, rate=200.0, counts=(20000.0, 1.0e6), noise=(0.001, 2e-5)),
    Unit(counts=(16.384, 2048.0), noise=(0.02, 0.0004)),
    Unit(rate=250.0, counts=(120.0, 10000.0), noise=(0.3, 0.01)),
)
FULL = (  # units that turn faster than they can say
    Unit(top=350.0),
    Unit(rate=50.0, counts=(65.5, 8192.0), top=600.0, quick=200.0),
    Unit(rate=200.0, counts=(131.0, 16384.0), top=300.0),
    Unit(rate=25.0, counts=(131.0, 16384.0), top=300.0, quick=50.0),
    Unit(bits=12, counts=(8.0, 512.0), top=300.0, noise=(0.2, 0.003)),
    Unit(bits=12, counts=(8.0, 1024.0), top=300.0, noise=(0.1, 0.003)),
    Unit(bits=14, rate=250.0, counts=(40.0, 4096.0), top=250.0, noise=(0.05, 0.003)),
    Unit(bits=18, counts=(500.0, 50000.0), top=400.0),
    Unit(bits=20, counts=(3000.0, 3e5), top=250.0, noise=(0.01, 0.0003)),
    Unit(bits=24, counts=(30000.0, 1e6), top=350.0, noise=(0.005, 0.0001)),
)


class Table:
    """Angles of three axes row by row, deg; moves with trapezoids of rate; labels beside."""

    def __init__(self, unit: Unit) -> None:
        self.unit, self.angle = unit, np.zeros(3)
        self.angles: list[np.ndarray] = []
        self.labels: list[dict[str, object]] = []

    @property
    def now(self) -> float:
        return len(self.angles) / self.unit.rate

    def rest(self, seconds: float) -> None:
        self.angles += [self.angle.copy()] * round(seconds * self.unit.rate)

    def go(self, axis: int, to: float) -> None:
        """A move with equal acceleration and deceleration."""
        way = to - self.angle[axis]
        rows = max(4, round(2.0 * np.sqrt(abs(way) / self.unit.quick) * self.unit.rate))
        u = np.arange(1, rows + 1) / rows
        course = np.where(u < 0.5, 2.0 * u**2, 1.0 - 2.0 * (1.0 - u) ** 2)
        self._along(axis, way * course)

    def spin(self, speed: float, seconds: float) -> tuple[float, float]:
        """Turns of the outer axis with ramps; when the rate was held."""
        ramp = max(3, round(abs(speed) / self.unit.quick * self.unit.rate))
        hold = round(seconds * self.unit.rate)
        speeds = np.concatenate([
            np.arange(1, ramp + 1) / ramp, np.ones(hold), np.arange(ramp - 1, -1, -1) / ramp,
        ])  # fmt: skip
        before = np.concatenate([[0.0], speeds[:-1]])
        start = self.now + ramp / self.unit.rate
        self._along(0, np.cumsum(0.5 * (speeds + before)) * speed / self.unit.rate)
        return start, start + hold / self.unit.rate

    def _along(self, axis: int, course: np.ndarray) -> None:
        for off in course:
            angle = self.angle.copy()
            angle[axis] += off
            self.angles.append(angle)
        self.angle[axis] += course[-1]

    def label(self, start: float, stop: float, **what: object) -> None:
        margin = 3.0 / self.unit.rate
        name = f"{what['kind']}_{len(self.labels):03d}"
        self.labels.append({"name": name, "t_start": start + margin, "t_end": stop - margin} | what)


def procedure(unit: Unit) -> Table:
    """Six axes up, twice each, and rates about each of three axes."""
    table = Table(unit)
    table.rest(3.0)
    for middle, inner, up in PLACES:
        table.go(1, middle)
        table.go(2, inner)
        for turn in (0.0, 180.0):
            table.go(0, turn)
            start = table.now
            table.rest(6.0)
            table.label(start, table.now, kind="static", up=up, turn_deg=turn,
                        item="twelve_position")  # fmt: skip
        table.go(0, 0.0)
        if up[0] == "+":
            for share in (1.0, -1.0, 0.25, -0.25):
                start, stop = table.spin(share * unit.top, 6.0)
                table.label(start, stop, kind="rate", axis=up[1], up=up,
                            rate_deg_s=share * unit.top, item="scale_factor")  # fmt: skip
                table.rest(2.0)
            table.go(0, 360.0 * round(table.angle[0] / 360.0))
            table.angle[0] = 0.0
    table.rest(3.0)
    return table


def felt(angles: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Body rate (n, 3) rad/s and up (n, 3) of R = Rz(outer)·Rx(middle)·Rz(inner), angles in deg."""
    outer, middle, inner = np.radians(angles).T
    # an angle may be counted anew by whole turns between two rows
    speed = [np.gradient(np.unwrap(each)) * rate for each in (outer, middle, inner)]
    sm, cm, si, ci = np.sin(middle), np.cos(middle), np.sin(inner), np.cos(inner)
    up = np.column_stack([sm * si, sm * ci, cm])
    turning = speed[0][:, None] * up + np.column_stack([
        speed[1] * ci, -speed[1] * si, speed[2],
    ])  # fmt: skip
    return turning, up


@cache
def words(unit: Unit, seed: int) -> tuple[np.ndarray, np.ndarray, Table]:
    """Right whole numbers (n, 6), the step (6,), and what the table did."""
    rng = np.random.default_rng(seed)
    table = procedure(unit)
    rate, up = felt(np.array(table.angles), unit.rate)
    matrix = [np.eye(3) + rng.normal(0.0, 0.004, (3, 3)) for _ in range(2)]
    bias = rng.normal(0.0, [1.0, 0.03], (3, 2))
    step = np.repeat([np.radians(1.0 / unit.counts[0]), 9.80665 / unit.counts[1]], 3)
    read = np.hstack([
        rate @ matrix[0].T + np.radians(bias[:, 0]),
        GRAVITY * up @ matrix[1].T + 9.80665 * bias[:, 1],
    ])  # fmt: skip
    noise = np.repeat([np.radians(unit.noise[0]), 9.80665 * unit.noise[1]], 3)
    read = read + noise * rng.standard_normal(read.shape)
    return np.rint(read / step).astype(np.int64), step, table


def made(
    unit: Unit, seed: int, fault: Callable[[int], int] | None,
    channels: tuple[int, ...] = tuple(range(6)), known: str = "table",
) -> Made:  # fmt: skip
    """A recording with a fault in some channels; known: table, labels or neither."""
    right, step, did = words(unit, seed)
    labels = did.labels
    wrong = right.copy()
    for c in channels if fault else ():
        numbers, rows = np.unique(right[:, c], return_inverse=True)
        wrong[:, c] = np.array([fault(number) for number in numbers.tolist()])[rows]  # type: ignore[misc]
    t = np.arange(len(right)) / unit.rate
    names = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
    values = wrong * step
    imu = Stream(t, {name: values[:, c].astype(float) for c, name in enumerate(names)})
    held = np.zeros(len(t), bool)
    for one in labels:
        held[imu.rows(one["t_start"], one["t_end"])] = True
    manifest = manifest_of(
        f"made-{seed}",
        {"latitude_deg": None, "gravity_m_s2": GRAVITY, "heading_deg": 0.0},
        THREE_AXES if known == "table" else None,
        standard="JJF 2003-2022",
        segments=labels if known != "neither" else None,
    )
    angles = np.unwrap(np.radians(np.array(did.angles)), axis=0)
    table = Stream(t, {f"{n}_angle": angles[:, k] for k, n in enumerate(THREE_AXES)})
    recording = Recording(manifest, imu, table=table if known == "table" else None)
    return Made(recording, right * step, held, step)


# Firmware, one word at a time, by bytes.


def low_byte_signed(number: int, bits: int = 16) -> int:
    """high << 8, plus the low byte as a signed char."""
    word = (number % (1 << bits)).to_bytes(bits // 8, "big")
    high = int.from_bytes(word[:-1], "big", signed=True)
    return (high << 8) + int.from_bytes(word[-1:], "big", signed=True)


def low_byte_or(number: int, bits: int = 16) -> int:
    """high << 8 | low, where the low byte is a signed char."""
    word = (number % (1 << bits)).to_bytes(bits // 8, "big")
    high = int.from_bytes(word[:-1], "big", signed=True)
    return (high << 8) | int.from_bytes(word[-1:], "big", signed=True)


def bytes_exchanged(number: int, bits: int = 16) -> int:
    word = (number % (1 << bits)).to_bytes(bits // 8, "big")
    return int.from_bytes(word, "little", signed=True)


def read_as_unsigned(number: int, bits: int = 16) -> int:
    return number % (1 << bits)


def wrapped(number: int, bits: int = 16) -> int:
    number %= 1 << bits
    return number - (1 << bits) if number >> bits - 1 else number


def stuck(number: int, bit: int, level: int, bits: int = 16) -> int:
    word = number % (1 << bits)
    word = word | 1 << bit if level else word & ~(1 << bit)
    return word - (1 << bits) if word >> bits - 1 else word
