"""A unit on a three-axis table (outer z, middle x, inner z) that is put up, down and turned.

R_n_body = Rz(a)·Rx(b)·Rz(c). Up in the body is (sin b·sin c, sin b·cos c, cos b), and its rate
ȧ·up + ḃ·(cos c, −sin c, 0) + ċ·(0, 0, 1).
"""

from dataclasses import dataclass, field

import numpy as np

G = 9.8015
DEG = np.pi / 180.0
PLACES = {  # middle and inner angle that put an axis up
    "+x": (90.0, 90.0), "-x": (90.0, 270.0), "+y": (90.0, 0.0), "-y": (90.0, 180.0),
    "+z": (0.0, 0.0), "-z": (180.0, 0.0),
}  # fmt: skip


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
    rng = np.random.default_rng(seed)
    times, knots, labels = [0.0], [np.zeros(3)], []

    def move(to: np.ndarray, seconds: float) -> None:
        times.append(times[-1] + seconds)
        knots.append(np.array(to, float))

    def hold(label: dict) -> None:
        start = times[-1]
        move(knots[-1], dwell)
        labels.append({**label, "t_start": start + margin, "t_end": times[-1] - margin})

    move(knots[-1], 3.0)
    for up, (b, c) in PLACES.items():
        for turn in turns:
            move(np.array([turn, b, c]), rng.uniform(2.5, 4.0))
            hold({"name": f"position_{up}_{turn:03g}", "kind": "static", "up": up,
                  "turn_deg": turn, "item": "twelve_position"})  # fmt: skip
    turning = []
    for axis in "xyz":
        up = f"+{axis}"
        b, c = PLACES[up]
        move(np.array([0.0, b, c]), 4.0)
        hold({"name": f"rest_{axis}", "kind": "static", "up": up, "item": "rate_sensitivity"})
        for rate in rates:
            for sign in (1.0, -1.0):
                turning.append((times[-1], sign * rate))
                start = times[-1]
                move(knots[-1] + [sign * rate * (dwell + 1.0), 0, 0], dwell + 2.0)
                labels.append({
                    "name": f"rate_{axis}_{sign * rate:+g}", "kind": "rate", "axis": axis,
                    "up": up, "rate_deg_s": sign * rate, "item": "scale_factor",
                    "t_start": start + 1.0 + margin, "t_end": start + 1.0 + dwell - margin,
                })  # fmt: skip
                knots[-1] = np.array([knots[-2][0] + sign * rate * (dwell + 1.0), b, c])
                move(knots[-1], 1.0)
    move(knots[-1], 2.0)
    t = np.arange(0.0, times[-1], 1.0 / hertz)
    angle, speed, change = _course(t, np.array(times), np.array(knots), turning, dwell)
    up, rate, spin = _felt(angle * DEG, speed * DEG, change * DEG)
    arm = lever * np.array([0.6, -0.5, 0.4])
    force = G * up + np.cross(spin, arm) + np.cross(rate, np.cross(rate, arm))
    truth = {
        "gyro_scale": np.eye(3) + 0.01 * poor * rng.normal(size=(3, 3)),
        "accel_scale": np.eye(3) + 0.005 * poor * rng.normal(size=(3, 3)),
        "gyro_bias": 0.3 * poor * DEG * rng.normal(size=3),
        "accel_bias": 0.05 * poor * rng.normal(size=3),
    }
    gyro = rate @ truth["gyro_scale"].T + truth["gyro_bias"]
    accel = force @ truth["accel_scale"].T + truth["accel_bias"]
    noise = rng.normal(size=(2, len(t), 3)) * np.array([0.05 * DEG, 0.01])[:, None, None]
    return Bench(t, angle * DEG, gyro + noise[0], accel + noise[1], labels, truth)


def _course(
    t: np.ndarray, times: np.ndarray, knots: np.ndarray, turning: list, dwell: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles, speeds and their change (n, 3) in degrees: smooth moves, and ramps of one second."""
    k = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)
    span = (times[1:] - times[:-1])[k]
    s = (t - times[k]) / span
    shape, slope = 10 * s**3 - 15 * s**4 + 6 * s**5, 30 * s**2 - 60 * s**3 + 30 * s**4
    bend = 60 * s - 180 * s**2 + 120 * s**3
    step = (knots[1:] - knots[:-1])[k]
    angle = knots[k] + shape[:, None] * step
    speed, change = (slope / span)[:, None] * step, (bend / span**2)[:, None] * step
    for start, rate in turning:
        rows = (t >= start) & (t < start + dwell + 2.0)
        x = t[rows] - start
        first, last = np.minimum(x, 1.0), np.clip(x - dwell - 1.0, 0.0, 1.0)
        speed[rows, 0] = rate * (first - last)
        change[rows, 0] = rate * ((x < 1.0) * 1.0 - (x > dwell + 1.0))
        held = np.clip(x - 1.0, 0.0, dwell)
        begun = knots[np.searchsorted(times, start + 1e-9, side="right") - 1, 0]
        angle[rows, 0] = begun + rate * (0.5 * first**2 + held + last - 0.5 * last**2)
    return angle, speed, change


def _felt(
    angle: np.ndarray, speed: np.ndarray, change: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Up, rate and angular acceleration (n, 3) in the body."""
    _, b, c = angle.T
    da, db, dc = speed[:, :, None].transpose(1, 0, 2)
    zero = np.zeros_like(b)
    up = np.column_stack([np.sin(b) * np.sin(c), np.sin(b) * np.cos(c), np.cos(b)])
    middle = np.column_stack([np.cos(c), -np.sin(c), zero])
    inner = np.array([0.0, 0.0, 1.0])
    rate = da * up + db * middle + dc * inner
    spin = change[:, :1] * up + change[:, 1:2] * middle + change[:, 2:] * inner
    return up, rate, spin
