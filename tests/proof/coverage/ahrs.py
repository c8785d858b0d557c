"""Recordings of JJF 1536 as laboratories make them: an AHRS on a one-axis table, re-fixed by hand.

In numpy alone, as those of `bench`: nothing of the program makes them, nor its noise models.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tests.proof.coverage.bench import ARCSECOND, AXES, DEG, EARTH, LATITUDE, G, Made, small

RATES = (-300.0, -200.0, -100.0, -10.0, 10.0, 100.0, 200.0, 300.0)  # deg/s
COMPASS = {"E": (1, 0, 0), "W": (-1, 0, 0), "N": (0, 1, 0), "S": (0, -1, 0),
           "U": (0, 0, 1), "D": (0, 0, -1)}  # fmt: skip
UPRIGHT = {"x": "UEN", "y": "NUE", "z": "ENU"}
FOUR = {"x": ("ENU", "ESD", "WSU", "WND"), "y": ("UEN", "DES", "UWS", "DWN"),
        "z": ("NUE", "SDE", "SUW", "NDW")}  # fmt: skip
RAMP_S, PARTS = 2.0, 8  # of a change of rate, and in how many steps
AROUND_S = 1.0  # of rest in the label of a turn, before and after
LONGEST = {"ends": 3e3, "true": 1e6}  # s: relaxation with which 1/f ends


@dataclass(frozen=True)
class Scenario:
    """How a laboratory's run differs from one in order, which all the defaults are."""

    encoders: bool = False
    angles: bool = True  # the unit gives accumulated angles, else rates
    rate_off: float | None = None  # relative, None: drawn from Table 1
    rate_stated: bool = True  # the laboratory states its own limit of the rate
    crooked: float = 0.0  # rad, of each re-fixing, stated as the segment's mount
    estimator_s: float = 0.0  # s in which the unit takes a steady rate off
    step: float = 0.0  # rad or rad/s
    noise: tuple[float, float] = (3e-4, 3e-3)  # deg/s/√Hz, drawn between
    flicker: tuple[float, float] = (0.0, 1e-4)  # deg/s
    ends: str = "ends"
    warms_k: float = 0.0  # over the whole run, in proportion to time
    warm_up: float = 0.0  # deg/s: of the bias, dies away over two hours of 6.3
    cut_s: float = 0.0  # of the label of a turn, at each end
    heading: float = 0.0  # rad, not stated
    delay_s: float = 0.0  # of the unit behind the table
    past: float = 0.0  # rad by which a turn ends elsewhere
    position_s: float = 600.0
    rest_s: float = 20.0
    hz: float = 2.0
    of_run: bool = False  # the true zero offset is the mean over the run, else over all time


ORDER = Scenario()
SCENARIOS: dict[str, Scenario] = {
    "in order, encoders": Scenario(encoders=True),
    "in order, labels, limit of the rate stated": ORDER,
    "labels, exact rates, no limit stated": Scenario(rate_off=0.0, rate_stated=False),
    "labels 0.02 % off, no limit stated": Scenario(rate_off=2e-4, rate_stated=False),
    "labels 0.05 % off, no limit stated": Scenario(rate_off=5e-4, rate_stated=False),
    "takes steady rates off, labels": Scenario(estimator_s=60.0),
    "takes steady rates off, encoders": Scenario(estimator_s=60.0, encoders=True),
    "re-fixed crooked, labels": Scenario(crooked=0.5 * DEG),
    "re-fixed crooked, encoders": Scenario(crooked=0.5 * DEG, encoders=True),
    "rates in steps, encoders": Scenario(angles=False, step=0.1 * DEG, encoders=True),
    "rates in steps, labels": Scenario(angles=False, step=0.1 * DEG),
    "rates, in order": Scenario(angles=False, encoders=True),
    "unit warms by 5 K, K at its own temperature": Scenario(
        warms_k=5.0, encoders=True, of_run=True
    ),
    "warm-up over two hours": Scenario(warm_up=0.005, encoders=True, of_run=True),
    "turns cut by 1 s, labels": Scenario(cut_s=1.0),
    "turns cut by 1 s, encoders": Scenario(cut_s=1.0, encoders=True),
    "true 1/f, mean over all time": Scenario(encoders=True, ends="true", flicker=(3e-4, 3e-4)),
    "true 1/f, mean over the run": Scenario(
        encoders=True, ends="true", flicker=(3e-4, 3e-4), of_run=True
    ),
    "rests of 10 s in flicker": Scenario(encoders=True, rest_s=10.0, flicker=(1e-4, 3e-4)),
    "rests of 60 s in flicker": Scenario(encoders=True, rest_s=60.0, flicker=(1e-4, 3e-4)),
    "angles in steps of 0.01°": Scenario(encoders=True, step=0.01 * DEG),
    "angles in steps of 0.1°": Scenario(encoders=True, step=0.1 * DEG),
    "heading 0.5° off": Scenario(encoders=True, heading=0.5 * DEG),
    "turns that end elsewhere": Scenario(encoders=True, past=0.5 * DEG),
    "delay of 20 ms": Scenario(encoders=True, delay_s=0.02),
}  # fmt: skip


@dataclass
class Run:
    """What is held one after the other: labels, table angle by time, mounts (true, stated)."""

    scenario: Scenario
    random: np.random.Generator
    t: float = 0.0
    labels: list[dict[str, Any]] = field(default_factory=list)
    knots: list[tuple[float, float]] = field(default_factory=lambda: [(0.0, 0.0)])
    held: list[tuple[float, np.ndarray]] = field(default_factory=list)
    stated: np.ndarray = field(default_factory=lambda: np.eye(3))
    rate: float = 0.0

    def fix(self, points: str) -> None:
        """Re-fixed by hand, so that its axes point there (the table at zero)."""
        wrong = self.random.uniform(-1.0, 1.0, 3) * self.scenario.crooked
        self.stated = np.array([COMPASS[p] for p in points], float).T @ small(wrong)
        tilt = self.random.uniform(-5.0, 5.0, 3) * ARCSECOND  # 6.2.2 b)
        self.held.append((self.t, self.stated @ small(tilt)))

    def turn(self, rate: float, seconds: float) -> None:
        """At a rate (rad/s) that is reached evenly, over 2 s where it changes."""
        for i in range(PARTS if rate != self.rate else 0):
            self._move(self.rate + (i + 0.5) / PARTS * (rate - self.rate), RAMP_S / PARTS)
        self._move(rate, seconds)
        self.rate = rate

    def _move(self, rate: float, seconds: float) -> None:
        self.t += seconds
        self.knots.append((self.t, self.knots[-1][1] + rate * seconds))

    def label(self, start: float, **fields: object) -> None:
        self.labels.append({"t_start": start, "t_end": self.t, **fields, **mount_of(self.stated)})

    def creep(self, angle: float) -> None:
        """The table's angle creeps by so much over what was held last."""
        self.knots[-1] = (self.knots[-1][0], self.knots[-1][1] + angle)


def mount_of(matrix: np.ndarray) -> dict[str, Any]:
    """A mount as the manifest has it: the quaternion of a rotation matrix."""
    k = np.zeros((4, 4))
    m = matrix
    k[0] = [np.trace(m), m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]
    k[1:, 1:] = m + m.T - np.trace(m) * np.eye(3)
    k[1:, 0] = k[0, 1:]
    vector = np.linalg.eigh(k)[1][:, -1]
    return {"mount": {"quaternion_wxyz": [float(x) for x in vector]}}


def journey(s: Scenario, random: np.random.Generator, off: float) -> Run:
    """The sequence of clause 7: rates about each axis, four positions for each, turns."""
    run = Run(s, random)
    for axis in AXES:
        run.fix(UPRIGHT[axis])
        upright = {"axis": axis, "up": f"+{axis}", "item": "scale_factor"}
        for name, rate in (("start", 0.0), *((f"{r:+.0f}", r) for r in RATES), ("end", 0.0)):
            start = run.t + (RAMP_S if rate != 0.0 or name == "end" else 0.0)
            run.turn(rate * DEG * (1.0 + off), 20.0 if rate else s.rest_s)
            kind = {"kind": "rate", "rate_deg_s": rate} if rate else {"kind": "static"}
            run.label(start, name=f"scale_{axis}_{name}", **kind, **upright)
    for axis, positions in FOUR.items():
        for points in positions:
            run.fix(points)
            start = run.t
            run.knots.append((run.t, 0.0))
            run.turn(0.0, s.position_s)
            run.creep(random.normal(0.0, 5.0 * ARCSECOND))
            run.label(start, name=f"zero_{axis}_{points}", kind="static", item="four_position",
                      axis=axis, points=dict(zip(AXES, points, strict=True)))  # fmt: skip
    for axis in AXES:
        run.fix(UPRIGHT[axis])
        for sign in (1.0, -1.0):
            run.turn(0.0, 2.0)
            start, edge = run.t - AROUND_S, s.cut_s + AROUND_S * (s.cut_s > 0.0)
            run.turn(sign * 100.0 * DEG * (1.0 + off), 34.0 + s.past / (100.0 * DEG))
            run.turn(0.0, 0.0)
            run.turn(0.0, AROUND_S)
            end, run.t = run.t, run.t - edge
            run.label(start + edge, name=f"turns_{axis}_{sign:+.0f}", kind="rotation",
                      item="misalignment", axis=axis, up=f"+{axis}",
                      angle_deg=sign * 3600.0)  # fmt: skip
            run.t = end
        run.turn(0.0, 2.0)
    return run


def slow_noise(random: np.random.Generator, n: int, dt: float, longest: float) -> np.ndarray:
    """1/f of unit flicker, (n,): relaxations two to the octave up to the longest, stationary."""
    total = np.zeros(n)
    times = 2.0 * 2.0 ** np.arange(0.0, np.log2(longest / 2.0), 0.5)
    for tau in times:
        keep = np.exp(-dt / tau)
        drive = random.normal(0.0, np.sqrt(1.0 - keep**2), n)
        drive[0] = random.normal()
        total += relaxed(drive, keep)
    return total * np.sqrt(np.log(2.0) * 0.5)


def relaxed(drive: np.ndarray, keep: float) -> np.ndarray:
    """x[k] = keep·x[k − 1] + drive[k], block by block."""
    block, out, last = 256, np.empty_like(drive), 0.0
    lower = np.tril(keep ** np.maximum(np.subtract.outer(np.arange(block), np.arange(block)), 0))
    for i in range(0, len(drive), block):
        part = drive[i : i + block]
        m = len(part)
        out[i : i + m] = lower[:m, :m] @ part + last * keep ** np.arange(1, m + 1)
        last = out[i + m - 1]
    return out


def felt_by(run: Run, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angle of the table at t (n,), and the unit's rate and vertical (n - 1, 3) between."""
    at, angle = np.array(run.knots).T
    table = np.interp(t, at, angle)
    middle = 0.5 * (table[1:] + table[:-1]) - run.scenario.heading
    starts = np.array([held for held, _ in run.held])
    which = np.searchsorted(starts, 0.5 * (t[1:] + t[:-1]), side="right") - 1
    attitude = np.array([matrix for _, matrix in run.held])[which]
    north = np.column_stack([np.sin(middle), np.cos(middle), np.zeros(len(middle))])
    rate = EARTH * (np.cos(LATITUDE) * north + np.sin(LATITUDE) * np.array([0.0, 0.0, 1.0]))
    rate[:, 2] += np.diff(table) / np.diff(t)
    return table, np.einsum("nji,nj->ni", attitude, rate), attitude[:, 2, :]


def put_out(
    s: Scenario, t: np.ndarray, read: np.ndarray, felt: np.ndarray
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The unit's stream: accumulated angles, or rates and specific force (n, 3), by time."""
    if s.angles:
        total = np.vstack([np.zeros(3), np.cumsum(read * np.diff(t)[:, None], axis=0)])
        return t + s.delay_s, named("angle", total, s.step)
    middle = 0.5 * (t[1:] + t[:-1]) + s.delay_s
    return middle, named("gyro", read, s.step) | named("accel", felt, 0.0)


def named(name: str, values: np.ndarray, step: float) -> dict[str, np.ndarray]:
    """Columns of (n, 3), in steps."""
    coded = np.round(values / step) * step if step else values
    return {f"{name}_{axis}": column for axis, column in zip(AXES, coded.T, strict=True)}


def record(s: Scenario, seed: int) -> Made:
    """Manifest, streams and truth of a unit drawn by the seed, as `bench.record` gives them."""
    random = np.random.default_rng((seed, 1536))
    drawn = float(random.normal(0.0, 1e-4))
    off = drawn if s.rate_off is None else s.rate_off
    K = np.eye(3) * (1.0 + random.uniform(-5e-3, 5e-3, 3)) + DEG * random.uniform(-0.5, 0.5, (3, 3))
    bias = random.uniform(-0.01, 0.01, 3) * DEG
    gravity = random.normal(0.0, 3e-4, (3, 3)) * DEG
    least, most = np.log(s.noise).tolist()
    noise = np.exp(random.uniform(least, most, 3)) * DEG
    flicker = random.uniform(*s.flicker, 3) * DEG
    scale_k, bias_k = random.normal(0.0, 1e-4, 3), random.normal(0.0, 1e-3, 3) * DEG
    run = journey(s, random, off)
    dt = 1.0 / s.hz
    t = np.arange(0.0, run.t + 2.0, dt)
    table, body, up = felt_by(run, t)
    n = len(body)
    slow = np.column_stack([slow_noise(random, n, dt, LONGEST[s.ends]) for _ in AXES]) * flicker
    warm = s.warms_k * (t[:-1] / t[-1] - 0.5)
    zero = bias + slow + warm[:, None] * bias_k + s.warm_up * DEG * (
        np.exp(-t[:-1] / 2400.0)[:, None] * np.sign(bias))  # fmt: skip
    read = body @ K.T * (1.0 + warm[:, None] * scale_k) + up @ gravity.T + zero
    read += random.normal(0.0, 1.0, (n, 3)) * noise / np.sqrt(dt)
    if s.estimator_s:
        read -= estimated(read, dt, s.estimator_s)
    at, columns = put_out(s, t, read, G * up + random.normal(0.0, 3e-3, (n, 3)))
    if s.warms_k:
        columns["temperature"] = 20.0 + np.interp(at, t[:-1], warm)
    streams = {"imu": (at, columns)}
    if s.encoders:
        shown = table / (1.0 + drawn) if s.rate_off is None else table
        streams["table"] = (t, {"table_angle": shown})
    manifest = {
        "format": "mimu-recording/1", "recording_id": f"ahrs_{seed}", "standard": "JJF 1536-2015",
        "unit": {"manufacturer": "proof", "model": "AHRS", "serial": str(seed)},
        "station": {"id": "one axis", "latitude_deg": 39.9, "gravity_m_s2": G, "heading_deg": 0.0,
                    "table_axes": [{"name": "table", "direction": [0, 0, 1]}]},
        "mount": {"quaternion_wxyz": [1, 0, 0, 0]}, "segments": run.labels,
    }  # fmt: skip
    if s.rate_stated and not s.encoders:
        bound = {"half_width": 2e-4, "distribution": "normal"}  # Table 1
        manifest["table_time"] = {"commanded_rate": bound}
    true_zero = zero.mean(axis=0) if s.of_run else bias
    own = [
        np.mean([np.interp(label["t_start"] + 10.0, t[:-1], warm) for label in run.labels
                 if label["kind"] == "rate" and label["axis"] == axis])
        for axis in AXES
    ]  # fmt: skip
    scale = np.diag(K) * (1.0 + scale_k * np.array(own))
    return (
        manifest,
        streams,
        {
            "ahrs_scale_factor": dict(zip(AXES, scale, strict=True)),
            "ahrs_zero_offset": dict(zip(AXES, true_zero / DEG, strict=True)),
            "ahrs_misalignment": {
                AXES[i] + AXES[j]: K[i, j] / DEG for i in range(3) for j in range(3) if i != j
            },
        },
    )


def estimated(read: np.ndarray, dt: float, seconds: float) -> np.ndarray:
    """What such a unit takes for its own bias (n, 3): followed where it reads less than 1 deg/s."""
    out, now = np.zeros_like(read), np.zeros(3)
    share = 1.0 - np.exp(-dt / seconds)
    for k, each in enumerate(read):
        out[k] = now
        if np.abs(each).max() < 1.0 * DEG:
            now = now + share * (each - now)
    return out
