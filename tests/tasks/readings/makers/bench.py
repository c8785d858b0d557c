"""A unit on a three-axis table (outer z, middle x, inner z) that is put up, down and turned.

As tests/tasks/readings/logged.py moves it.
"""

from dataclasses import dataclass, field

import numpy as np

from tests.tasks.readings.logged import GRAVITY as G
from tests.tasks.readings.logged import POSES, Course, moved

DEG = np.pi / 180.0


@dataclass
class Bench:
    """t (n,) s; angle (n, 3) rad; gyro, accel (n, 3) of a unit in rad/s and m/s²; labels.

    truth: scale matrices (3, 3) and biases (3,) of gyros and accelerometers.
    """

    t: np.ndarray
    angle: np.ndarray
    gyro: np.ndarray
    accel: np.ndarray
    labels: list[dict]
    truth: dict[str, np.ndarray] = field(default_factory=dict)

    def manifest(self, *, table: bool = False, labels: bool = True) -> dict:
        axes = [("outer", [0, 0, 1]), ("middle", [1, 0, 0]), ("inner", [0, 0, 1])]
        return {
            "format": "mimu-recording/1", "recording_id": "made", "standard": "JJF 2003-2022",
            "unit": {"manufacturer": "Made", "model": "M", "serial": "1"},
            "station": {
                "id": "made", "latitude_deg": 39.9, "gravity_m_s2": G, "heading_deg": 0.0,
                "table_axes": [{"name": n, "direction": d} for n, d in axes] if table else None,
            },
            "segments": self.labels if labels else None,
        }  # fmt: skip


def bench(
    seed: int,
    *,
    hertz: float = 100.0,
    dwell: float = 8.0,
    rates: tuple[float, ...] = (50.0, 200.0),
    turns: tuple[float, ...] = (0.0, 180.0),
    margin: float = 0.0,
    poor: float = 1.0,
    lever: float = 0.0,
) -> Bench:
    """Positions at each of `turns` about the vertical, and ± rates with each axis up.

    margin: s between a move and the label. poor: how bad the unit is. lever: m off the axis.
    """
    rng, course = np.random.default_rng(seed), Course()
    course.wait(3.0, kind="settle")
    for up, (b, c) in POSES.items():
        for turn in turns:
            course.move((np.radians(turn), b, c), rng.uniform(2.5, 4.0))
            course.wait(dwell, name=f"position_{up}_{turn:03g}", kind="static", up=up,
                        turn_deg=turn, item="twelve_position")  # fmt: skip
    for axis in "xyz":
        up = f"+{axis}"
        course.move((0.0, *POSES[up]), 4.0)
        course.wait(dwell, name=f"rest_{axis}", kind="static", up=up, item="rate_sensitivity")
        for rate in (sign * size for size in rates for sign in (1.0, -1.0)):
            course.turn(np.radians(rate), dwell, 1.0, name=f"rate_{axis}_{rate:+g}", axis=axis,
                        up=up, rate_deg_s=rate, item="scale_factor")  # fmt: skip
            course.wait(1.0, kind="settle")
    course.wait(2.0, kind="settle")
    labels = [label for label in course.segments if label["kind"] in ("static", "rate")]
    for label in labels:
        label["t_start"] += margin
        label["t_end"] -= margin
    t = np.arange(0.0, course.until, 1.0 / hertz)
    rate, up, _ = moved(course, t)
    arm = lever * np.array([0.6, -0.5, 0.4])
    force = G * up + np.cross(np.gradient(rate, t, axis=0), arm)
    force += np.cross(rate, np.cross(rate, arm))
    truth = {
        "gyro_scale": np.eye(3) + 0.01 * poor * rng.normal(size=(3, 3)),
        "accel_scale": np.eye(3) + 0.005 * poor * rng.normal(size=(3, 3)),
        "gyro_bias": 0.3 * poor * DEG * rng.normal(size=3),
        "accel_bias": 0.05 * poor * rng.normal(size=3),
    }
    gyro = rate @ truth["gyro_scale"].T + truth["gyro_bias"]
    accel = force @ truth["accel_scale"].T + truth["accel_bias"]
    noise = rng.normal(size=(2, len(t), 3)) * np.array([0.05 * DEG, 0.01])[:, None, None]
    return Bench(t, course.at(t)[0], gyro + noise[0], accel + noise[1], labels, truth)
