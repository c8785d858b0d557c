"""A JJF 1536 run by plain algebra: model (1) summed over the angles turned, Earth turning too."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from schemas.recording import ANGLE, GYRO, Manifest, Recording, Stream

AXES = "xyz"
RATE_HZ = 10.0
RATES = (-300.0, -200.0, -100.0, -10.0, 10.0, 100.0, 200.0, 300.0)
EARTH = 7.292115e-5 * np.array([0.0, np.cos(np.radians(40)), np.sin(np.radians(40))])
COMPASS = {"E": [1, 0, 0], "W": [-1, 0, 0], "N": [0, 1, 0], "S": [0, -1, 0],
           "U": [0, 0, 1], "D": [0, 0, -1]}  # fmt: skip
FOUR = {"x": ("ENU", "ESD", "WSU", "WND"), "y": ("UEN", "DES", "UWS", "DWN"),
        "z": ("NUE", "SDE", "SUW", "NDW")}  # fmt: skip
NONE = np.zeros((3, 3))
PAUSE = 2.0  # s between the segments, at rest
HEAD = {
    "format": "mimu-recording/1", "recording_id": "ahrs", "standard": "JJF 1536-2015",
    "unit": {"manufacturer": "test", "model": "ideal", "serial": "1"},
    "station": {"id": "test", "latitude_deg": 40.0, "gravity_m_s2": 9.8},
    "table_time": {
        "half_width_s": 0.0, "commanded_rate": {"half_width": 2e-4, "distribution": "normal"},
    },
}  # fmt: skip


class Bench:
    """Holds, turns and notes what an AHRS with errors K, L, B then puts out."""

    def __init__(self, K: Any, L: Any, B_deg_s: Any, rate_hz: float) -> None:
        self.matrix = np.diag(K) + np.asarray(L)
        self.zero = np.radians(B_deg_s)
        self.rate_hz = rate_hz
        self.increments: list[np.ndarray] = [np.zeros((1, 3))]
        self.turned: list[np.ndarray] = [np.zeros(1)]
        self.segments: list[dict[str, Any]] = []
        self.rows = 0

    def add(self, label: dict[str, Any], rate: np.ndarray, seconds: float, spin: float = 0) -> None:
        """A segment at a constant rate (rad/s) of the body, and a pause without motion."""
        for held, body in ((seconds, rate), (PAUSE, np.zeros(3))):
            count = round(held * self.rate_hz)
            gain = (self.matrix @ body + self.zero) / self.rate_hz
            self.increments.append(np.tile(gain, (count, 1)))
            moving = spin / self.rate_hz if held is seconds else 0.0
            self.turned.append(np.full(count, moving))
            if held is seconds:
                start = self.rows / self.rate_hz
                self.segments.append({**label, "t_start": start, "t_end": start + seconds})
            self.rows += count

    def rest(self, axis: int, name: str) -> None:
        up = np.eye(3)[axis]
        label = {"name": f"{name}_{AXES[axis]}", "kind": "static", "item": "scale_factor",
                 "up": f"+{AXES[axis]}"}  # fmt: skip
        self.add(label, up * EARTH[2], 20.0)

    def turn(self, axis: int, rate_deg_s: float, label: dict[str, Any], seconds: float) -> None:
        """Turning about the vertical axis: Earth's level part averages out over whole turns."""
        up, rate = np.eye(3)[axis], np.radians(rate_deg_s)
        about = {"axis": AXES[axis], "up": f"+{AXES[axis]}", **label}
        self.add(about, up * (rate + EARTH[2]), seconds, rate)

    def position(self, axis: str | None, points: str, seconds: float) -> None:
        """A rest with x, y, z toward three letters of the compass."""
        body = np.array([COMPASS[letter] for letter in points]) @ EARTH
        label = {"name": f"zero_{axis}_{points}", "kind": "static", "item": "four_position",
                 "axis": axis, "points": dict(zip(AXES, points, strict=True))}  # fmt: skip
        self.add(label, body, seconds)

    def recording(
        self, angle_noise: float = 1e-9, rate_noise: float = 0.0, step: float = 0.0, seed: int = 1
    ) -> Recording:
        """angle_noise: rad, white; rate_noise: rad/√s; step: rad, resolution of the angle."""
        random = np.random.default_rng(seed)
        gains = np.concatenate(self.increments)
        gains = gains + rate_noise / np.sqrt(self.rate_hz) * random.normal(size=gains.shape)
        angles = gains.cumsum(axis=0)
        angles = angles + angle_noise * random.normal(size=angles.shape)
        if step:
            angles = step * np.round(angles / step)
        t = np.round(np.arange(len(angles)) / self.rate_hz, 9)
        air = np.arange(0.0, t[-1] + 1.0)
        room = {"temperature": np.full(len(air), 20.0), "humidity": np.full(len(air), 50.0)}
        columns = dict(zip(ANGLE, angles.T.copy(), strict=True))
        manifest = Manifest.model_validate({**HEAD, "segments": self.segments})
        return Recording(
            manifest, Stream(t, columns), environment=Stream(air, room), digest="0" * 64
        )


@pytest.fixture(scope="session")
def bench() -> Callable[..., Bench]:
    """Makes a bench with an AHRS of the given errors: K (3,), L (3, 3) ratios, B (3,) deg/s."""

    def make(
        K: Any = (1, 1, 1), L: Any = NONE, B: Any = (0, 0, 0), rate_hz: float = RATE_HZ
    ) -> Bench:
        return Bench(K, L, B, rate_hz)

    return make


@pytest.fixture(scope="session")
def ahrs_run(bench) -> Callable[..., Recording]:
    """Builds a whole run: rate points with rests, four positions an axis, ten turns each way."""

    def build(hold: float = 60.0, noise: dict[str, Any] | None = None, **errors: Any) -> Recording:
        made = bench(**errors)
        for axis in range(3):
            made.rest(axis, "start")
            for rate in RATES:
                label = {"name": f"scale_{AXES[axis]}_{rate:+.0f}", "kind": "rate",
                         "item": "scale_factor", "rate_deg_s": rate}  # fmt: skip
                made.turn(axis, rate, label, 20.0)
            made.rest(axis, "end")
        for axis, positions in FOUR.items():
            for points in positions:
                made.position(axis, points, hold)
        for axis in range(3):
            for sign in (1, -1):
                label = {"name": f"turns_{AXES[axis]}", "kind": "rotation",
                         "item": "misalignment", "angle_deg": 3600.0 * sign}  # fmt: skip
                made.turn(axis, 100.0 * sign, label, 36.0)
        return made.recording(**(noise or {}))

    return build


@pytest.fixture(scope="session")
def as_gyro() -> Callable[[Recording], Recording]:
    """The same run as a unit that puts out rates would have recorded it."""

    def convert(recording: Recording) -> Recording:
        imu = recording.imu
        rates = np.diff(imu.stack(ANGLE), axis=0).T / np.diff(imu.t)
        stream = Stream(imu.t[:-1], dict(zip(GYRO, rates, strict=True)))
        return Recording(
            recording.manifest, stream, environment=recording.environment, digest="1" * 64
        )

    return convert
