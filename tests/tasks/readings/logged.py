"""Recordings of a unit on a three-axis table, by plain kinematics, and what loggers do to their
stamps; it knows nothing of what puts them right.

The table's axes are z, x, z from the outside: R = Rz(a)·Rx(b)·Rz(c). Each move of an axis is a
raised cosine in rate, each turn at a rate has ramps of the same form.
"""

from dataclasses import dataclass, field

import numpy as np

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tests.manifests import THREE_AXES, manifest_of

GRAVITY, EARTH = 9.8015, 7.292115e-5
LATITUDE = np.radians(39.9)
POSES = {  # middle and inner angle, rad, that bring an axis up
    "+z": (0.0, 0.0), "-z": (np.pi, 0.0), "+x": (np.pi / 2, np.pi / 2),
    "-x": (np.pi / 2, 3 * np.pi / 2), "+y": (np.pi / 2, 0.0), "-y": (np.pi / 2, np.pi),
}  # fmt: skip


@dataclass
class Course:
    """Pieces of the three axes' rates: from, until (s), axis, form, size."""

    until: float = 0.0
    angles: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    pieces: list[tuple[float, float, int, str, float]] = field(default_factory=list)
    segments: list[dict] = field(default_factory=list)

    def wait(self, seconds: float, **label: object) -> None:
        self._label(seconds, **label)

    def move(self, targets: tuple[float, float, float], seconds: float) -> None:
        for axis, target in enumerate(targets):
            turned = target - self.angles[axis]
            if turned:
                self.pieces.append((self.until, self.until + seconds, axis, "move", turned))
            self.angles[axis] = target
        self._label(seconds, kind="transition")

    def turn(self, rate: float, hold: float, ramp: float, **label: object) -> None:
        """Of the outer axis, at a rate (rad/s)."""
        start = self.until
        self.pieces.append((start, start + ramp, 0, "up", rate))
        self._label(ramp, kind="transition")
        self.pieces.append((self.until, self.until + hold, 0, "hold", rate))
        self._label(hold, kind="rate", **label)
        self.pieces.append((self.until, self.until + ramp, 0, "down", rate))
        self._label(ramp, kind="transition")
        self.angles[0] += rate * (hold + ramp)

    def swing(self, axis: int, size: float, hertz: float, seconds: float) -> None:
        self.pieces.append((self.until, self.until + seconds, axis, f"swing {hertz}", size))
        self._label(seconds, kind="transition")

    def _label(self, seconds: float, **label: object) -> None:
        name = str(label.pop("name", f"{label['kind']}{len(self.segments):03d}"))
        self.segments.append(
            {"name": name, "t_start": self.until, "t_end": self.until + seconds, **label}
        )
        self.until += seconds

    def at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Angles and rates (n, 3) of the axes."""
        angles, rates = np.zeros((len(t), 3)), np.zeros((len(t), 3))
        for start, stop, axis, form, size in self.pieces:
            long = stop - start
            x = np.clip((t - start) / long, 0.0, 1.0)
            inside = (t >= start) & (t < stop)
            if form == "move":
                angle = size * (x - np.sin(2 * np.pi * x) / (2 * np.pi))
                rate = size * (1 - np.cos(2 * np.pi * x)) / long
            elif form in ("up", "down"):
                eased = 0.5 * size * long * (x - np.sin(np.pi * x) / np.pi)
                wave = 0.5 * size * (1 - np.cos(np.pi * x))
                down = form == "down"
                angle = size * long * x - eased if down else eased
                rate = size - wave if down else wave
            elif form == "hold":
                angle, rate = size * long * x, np.full(len(t), size)
            else:
                w = 2 * np.pi * float(form.split()[1])
                eased = np.sin(np.pi * x) ** 2  # begins and ends at rest
                angle = size * eased * np.sin(w * x * long)
                rate = size * (
                    eased * w * np.cos(w * x * long)
                    + np.pi / long * np.sin(2 * np.pi * x) * np.sin(w * x * long)
                )
            angles[:, axis] += angle
            rates[:, axis] += np.where(inside, rate, 0.0)
        return angles, rates


def procedure(
    rest: float = 8.0, move: float = 3.0, ramp: float = 1.0, hold: float = 8.0,
    rates: tuple[float, ...] = (50.0, -50.0, 100.0, -100.0), turns: tuple[int, ...] = (0, 180),
) -> Course:  # fmt: skip
    """Positions, then rates about each axis held upright."""
    course = Course()
    course.wait(5.0, kind="settle", name="warm")
    for up, (middle, inner) in POSES.items():
        for turn in turns:
            course.move((np.radians(turn), middle, inner), move)
            course.wait(
                rest, kind="static", name=f"position_{up}_{turn:03d}", up=up, turn_deg=turn,
                item="twelve_position",
            )  # fmt: skip
    for up in ("+x", "+y", "+z"):
        course.move((course.angles[0], *POSES[up]), move)
        for rate in rates:
            course.wait(2.0, kind="settle")
            course.turn(
                float(np.radians(rate)), hold, ramp, name=f"rate_{up[1]}_{rate:+.0f}", axis=up[1],
                up=up, rate_deg_s=rate, item="scale_factor",
            )  # fmt: skip
    course.wait(5.0, kind="settle")
    return course


def swinging(seconds: float = 240.0) -> Course:
    """Rests and swings about two axes."""
    course = Course()
    course.wait(10.0, kind="settle")
    for k in range(int(seconds // 40)):
        course.swing(0, 0.5 + 0.1 * k, 0.3 + 0.13 * k, 20.0)
        course.wait(2.0, kind="settle")
        course.swing(1, 0.4, 0.9, 16.0)
        course.wait(2.0, kind="settle")
    return course


@dataclass(frozen=True)
class Unit:
    """gyro_noise rad/s, accel_noise m/s² of a sample; steps of the outputs."""

    gyro_noise: float = 1e-3
    accel_noise: float = 0.01
    steps: tuple[float, float] = (1e-4, 1e-3)
    arm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turns_with_earth: bool = True


def moved(course: Course, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """In the body at the instants (n,) s: its rate on the ground, up, and Earth's rate (n, 3)."""
    angles, rates = course.at(at)
    a, b, c = angles.T
    zero, one = np.zeros(len(at)), np.ones(len(at))

    def about_inner(v: np.ndarray) -> np.ndarray:
        x, y, z = v.T
        return np.column_stack([
            np.cos(c) * x + np.sin(c) * y, -np.sin(c) * x + np.cos(c) * y, z,
        ])  # fmt: skip

    def inwards(v: np.ndarray) -> np.ndarray:
        """From the frame of the outer axis to the body's."""
        x, y, z = v.T
        return about_inner(np.column_stack([
            x, np.cos(b) * y + np.sin(b) * z, -np.sin(b) * y + np.cos(b) * z,
        ]))  # fmt: skip

    up = inwards(np.column_stack([zero, zero, one]))
    rate = rates[:, :1] * up + rates[:, 1:2] * about_inner(np.column_stack([one, zero, zero]))
    rate[:, 2] += rates[:, 2]
    north = EARTH * np.cos(LATITUDE)
    level = np.column_stack([north * np.sin(a), north * np.cos(a), zero])
    return rate, up, inwards(level) + EARTH * np.sin(LATITUDE) * up


def read(course: Course, at: np.ndarray, unit: Unit, rng: np.random.Generator) -> np.ndarray:
    """(n, 6) what the unit reads at the instants (n,) s."""
    rate, up, earth = moved(course, at)
    change = np.gradient(rate, at, axis=0)
    force = GRAVITY * up + np.cross(change, unit.arm)
    force += np.cross(rate, np.cross(rate, unit.arm))
    if unit.turns_with_earth:
        rate = rate + earth
    gains = np.eye(3) + 1e-3 * rng.uniform(-3, 3, (3, 3))
    gyro = rate @ gains.T + np.radians(rng.uniform(-0.2, 0.2, 3))
    gains = np.eye(3) + 1e-3 * rng.uniform(-3, 3, (3, 3))
    accel = force @ gains.T + rng.uniform(-0.05, 0.05, 3)
    gyro += unit.gyro_noise * rng.standard_normal(gyro.shape)
    accel += unit.accel_noise * rng.standard_normal(accel.shape)
    both = [(gyro, unit.steps[0]), (accel, unit.steps[1])]
    return np.hstack([np.round(v / s) * s if s else v for v, s in both])


def recorded(
    name: str, course: Course, stamps: np.ndarray, readings: np.ndarray, *,
    table_rate: float = 100.0, table: bool = True, step: float = np.radians(1e-4),
) -> Recording:  # fmt: skip
    """The recording of readings (n, 6) stamped (n,) s, beside the encoders or the labels alone."""
    manifest = manifest_of(
        name,
        {"latitude_deg": 39.9, "gravity_m_s2": GRAVITY, "heading_deg": 0.0},
        THREE_AXES,
        standard="JJF 2003-2022",
        segments=course.segments,
    )
    imu = Stream(stamps, dict(zip((*GYRO, *ACCEL), readings.T, strict=True)))
    encoders = None
    if table:
        t = np.arange(0.0, course.until, 1.0 / table_rate)
        angles = np.round(course.at(t)[0] / step) * step
        names = ("outer_angle", "middle_angle", "inner_angle")
        encoders = Stream(t, dict(zip(names, angles.T, strict=True)))
    return Recording(manifest, imu, table=encoders)


def in_packets(
    at: np.ndarray, period: float | None, size: int | tuple[int, int], rng: np.random.Generator,
    latency: float = 1e-3, scatter: float = 1e-4, within: float = 5e-5,
) -> np.ndarray:  # fmt: skip
    """Stamps (n,) s of samples taken at (n,) s that arrive in packets.

    period: s, of a host that asks for what is there; None: the unit sends when `size` samples are
    there, or a number drawn between two. within: s, from one row of a packet to the next.
    """
    if period is not None:
        number = np.ceil((at + 1e-12) / period).astype(int)
        sent = number * period
    else:
        low, high = (size, size) if isinstance(size, int) else size
        sizes = rng.integers(low, high + 1, len(at))
        number = np.repeat(np.arange(len(sizes)), sizes)[: len(at)]
        last = np.append(np.flatnonzero(np.diff(number)), len(at) - 1)
        sent = at[last][number]
    delays = latency + scatter * np.abs(rng.standard_normal(int(number[-1]) + 1))
    first = np.searchsorted(number, number)
    place = np.arange(len(at)) - first
    stamps = sent + delays[number] + within * (place + rng.uniform(0.0, 0.5, len(at)))
    return np.maximum.accumulate(stamps + 1e-9 * np.arange(len(at)))


def numbered(at: np.ndarray, gaps: tuple[tuple[float, int], ...]) -> tuple[np.ndarray, np.ndarray]:
    """Which rows arrive where samples are lost from some times (s) on, so many each time, and the
    stamps of a logger that numbers those that do."""
    kept = np.ones(len(at), bool)
    for when, count in gaps:
        first = int(np.searchsorted(at, when))
        kept[first : first + count] = False
    rows = np.flatnonzero(kept)
    return rows, at[: len(rows)]
