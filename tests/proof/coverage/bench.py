"""Recordings of JJF 2003 as laboratories make them, in numpy alone: the judge of stated U.

Nothing of the product makes them: rotations are matrices, noise is shaped in the spectrum, every
error of the equipment is drawn here from what Table 1 allows. A `Bench` says what differs from a
run in which everything is in order.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

DEG = np.pi / 180.0
ARCSECOND = DEG / 3600.0
EARTH = 7.292115e-5
HZ, DWELL, MOVE, PAUSE = 20.0, 30.0, 2.0, 0.5
G, LATITUDE = 9.8015, 39.9 * DEG
RATES = (-300.0, -200.0, -100.0, -50.0, -10.0, 10.0, 50.0, 100.0, 200.0, 300.0)
FACES = {
    "+x": (90.0, 90.0), "-x": (90.0, -90.0), "+y": (90.0, 0.0), "-y": (90.0, 180.0),
    "+z": (0.0, 0.0), "-z": (180.0, 0.0),
}  # fmt: skip
AXES = "xyz"
Made = tuple[dict[str, Any], dict[str, Any], dict[str, Any]]  # manifest, streams, truth


@dataclass(frozen=True)
class Bench:
    """How a run differs from one in order.

    mount_deg: of the unit in the fixture, about a random axis, and stated. table: whether encoders
    were recorded. rate_off: half-width of the true rate's error, relative. gyro_tc, accel_tc: of
    the scale factors, 1/K, over warming_k. warm_up: of the bias's range, as 1 − exp(−t/600 s).
    step: of each channel over its noise, 0 for none. headings: of the positions. rates: °/s.
    polled_s: half-width of the encoders' times at 10 Hz. hum: m/s² and rad/s over the noise of a
    row, folded to a slow frequency. levels: longest time (s) of the 1/f; 0: none.
    """

    mount_deg: float = 0.0
    table: bool = True
    standard: str = "JJF 2003-2022"
    rate_off: float = 1e-5
    warming_k: float = 0.0
    gyro_tc: float = 0.0
    accel_tc: float = 0.0
    warm_up: float = 0.0
    step: tuple[float, float] = (0.0, 0.0)
    headings: tuple[float, ...] = (0.0, 180.0)
    rates: tuple[float, ...] = RATES
    dwell: float = DWELL
    ripple: float | None = None
    polled_s: float = 0.0
    hum: float = 0.0
    hum_hz: float = 0.03
    longest_s: float = 1000.0
    flicker: float = 1.0
    tactical: bool = False


def cross_matrix(v: np.ndarray) -> np.ndarray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def turn(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Matrices (n, 3, 3) of turns by (n,) rad about a unit axis (Rodrigues)."""
    k = cross_matrix(axis)
    s, c = np.sin(angle)[:, None, None], (1.0 - np.cos(angle))[:, None, None]
    return np.eye(3) + s * k + c * (k @ k)


def small(v: np.ndarray) -> np.ndarray:
    size = float(np.linalg.norm(v))
    return np.eye(3) if size == 0.0 else turn(v / size, np.array([size]))[0]


def pink(random: np.random.Generator, n: int, longest_s: float) -> np.ndarray:
    """(6, n) noise with S(f) = 1/f between 1/(2π·longest) and the row rate, one-sided."""
    if not longest_s:
        return np.zeros((6, n))
    whole = int(2 ** np.ceil(np.log2(max(n, 8.0 * longest_s * HZ))))
    f = np.fft.rfftfreq(whole, 1.0 / HZ)
    corner = 1.0 / (2.0 * np.pi * longest_s)
    density = np.zeros(len(f))
    # Relaxations spread evenly over the logarithm of their time: (2/πf)·arctan(f/corner).
    density[1:] = 2.0 / (np.pi * f[1:]) * np.arctan(f[1:] / corner)
    density[0] = 2.0 / (np.pi * corner)
    size = np.sqrt(density * whole * HZ / 2.0 / 2.0)
    shape = (6, len(f))
    spectrum = size * (random.standard_normal(shape) + 1j * random.standard_normal(shape))
    spectrum[:, 0] = spectrum[:, 0].real * np.sqrt(2.0)
    return np.fft.irfft(spectrum, whole, axis=1)[:, :n]


def record(  # noqa: C901, PLR0915 - one recording, from the journey to the streams
    bench: Bench, seed: int
) -> Made:
    """Manifest, streams {name: {column: values}}, and truth of a unit drawn by the seed.

    truth: item → element → value in printed units; 'mean' holds (6,) what drift and flicker add
    to the zero on average over the measured segments.
    """
    r = np.random.default_rng((seed, 77))
    uniform = r.uniform
    fine = 1.0 if bench.tactical else 4.0
    white = np.array([3e-5 * fine] * 3 + [3e-4 * fine] * 3)  # rad/s/√Hz, m/s²/√Hz
    deviation = white * np.sqrt(HZ)
    grade = np.array([2e-6] * 3 + [3e-5] * 3) * np.exp(uniform(-1.0, 1.0, 6)) * fine * bench.flicker
    K = (
        np.eye(3)
        + np.diag(uniform(-3e-3, 3e-3, 3))
        + uniform(-3e-3, 3e-3, (3, 3)) * (1 - np.eye(3))
    )
    force = (
        np.eye(3)
        + np.diag(uniform(-3e-3, 3e-3, 3))
        + uniform(-3e-3, 3e-3, (3, 3)) * (1 - np.eye(3))
    )
    bias_range = np.array([0.1 * DEG] * 3 + [0.03] * 3)
    B = bias_range * uniform(-1, 1, 6) * (20.0 if any(bench.step) else 1.0)  # over many steps
    lean = uniform(-1, 1, (3, 3)) * 0.01 * DEG / G
    p = uniform(-0.03, 0.03, (3, 3)) * (1 - np.eye(3))

    # Journey in the table's own angles.
    segments: list[dict[str, Any]] = []
    errors_at: dict[tuple[int, float], float] = {}
    off, last = np.zeros(3), np.full(3, np.nan)
    pieces: list[np.ndarray] = []
    state, error = np.zeros(3), np.zeros(3)

    def steps(seconds: float) -> np.ndarray:
        return np.arange(round(seconds * HZ)) / HZ

    def go(place: tuple[float, float, float]) -> None:
        nonlocal state, error
        new = np.zeros(3)
        for k, angle in enumerate(place):
            key = (k, angle % 360.0)
            errors_at.setdefault(key, uniform(-10, 10) * ARCSECOND)
            if last[k] != angle:
                off[k] = uniform(-5, 5) * ARCSECOND
                last[k] = angle
            new[k] = errors_at[key] + off[k]
        goal = np.array(place) * DEG
        goal[0] = state[0] + (goal[0] - state[0] + np.pi) % (2 * np.pi) - np.pi
        part = 0.5 - 0.5 * np.cos(np.pi * steps(MOVE) / MOVE)
        pieces.append(np.vstack([
            state[:, None] + (goal - state)[:, None] * part,
            error[:, None] + (new - error)[:, None] * part,
        ]))  # fmt: skip
        state, error = goal, new

    def hold(rate: float, seconds: float) -> None:
        nonlocal state
        t = steps(seconds)
        piece = np.vstack([np.tile(state[:, None], len(t)), np.tile(error[:, None], len(t))])
        piece[0] += rate * DEG * t
        pieces.append(piece)
        state = state + np.array([rate * DEG * len(t) / HZ, 0, 0])

    def ramp(before: float, after: float) -> None:
        nonlocal state
        t = steps(MOVE)
        piece = np.vstack([np.tile(state[:, None], len(t)), np.tile(error[:, None], len(t))])
        piece[0] += DEG * (before * t + 0.5 * (after - before) / MOVE * t**2)
        pieces.append(piece)
        state = state + np.array([DEG * 0.5 * (before + after) * len(t) / HZ, 0, 0])

    def stay(rate: float, label: dict[str, Any], seconds: float) -> None:
        hold(rate, PAUSE)
        start = sum(piece.shape[1] for piece in pieces) / HZ
        hold(rate, seconds)
        segments.append({**label, "t_start": start, "t_end": start + len(steps(seconds)) / HZ})
        hold(rate, PAUSE)

    for up, inside in FACES.items():
        for heading in bench.headings:
            go((heading, *inside))
            stay(0.0, {
                "name": f"position_{up}_{heading:03.0f}", "kind": "static", "up": up,
                "item": "twelve_position", "turn_deg": heading,
            }, bench.dwell)  # fmt: skip
    for axis in AXES:
        up = f"+{axis}"
        go((0.0, *FACES[up]))
        rest = {"kind": "static", "item": "rate_sensitivity", "up": up}
        stay(0.0, {"name": f"before_{axis}", **rest}, bench.dwell)
        before = 0.0
        for rate in bench.rates:
            ramp(before, rate)
            before = rate
            stay(rate, {
                "name": f"rate_{axis}_{rate:+.0f}", "kind": "rate", "item": "scale_factor",
                "axis": axis, "up": up, "rate_deg_s": rate,
            }, bench.dwell)  # fmt: skip
        ramp(before, 0.0)
        stay(0.0, {"name": f"after_{axis}", **rest}, bench.dwell)

    track = np.hstack(pieces)
    n = track.shape[1]
    t = np.arange(n) / HZ
    # The truth behind the angles.
    rate_off = uniform(-1, 1) * bench.rate_off
    ripple = uniform(-5e-4, 5e-4) if bench.ripple is None else bench.ripple
    phase = uniform(0, 2 * np.pi)
    level, joints = uniform(-10, 10, 2) * ARCSECOND, uniform(-10, 10, 2) * ARCSECOND
    fixture = uniform(-10, 10, 3) * ARCSECOND
    gravity, latitude = G + uniform(-5e-4, 5e-4), LATITUDE + uniform(-0.05, 0.05) * DEG
    angle = track[:3] + track[3:]
    outer = angle[0] * (1.0 + rate_off) + ripple * np.sin(angle[0] + phase)
    x, z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    direction = r.standard_normal(3)
    direction /= np.linalg.norm(direction)
    half = 0.5 * bench.mount_deg * DEG
    quaternion = [float(np.cos(half)), *(float(v) for v in np.sin(half) * direction)]
    mount = small(bench.mount_deg * DEG * direction)
    tilt = small(np.array([level[0], level[1], 0.0]))
    attitude = tilt @ turn(z, outer) @ small(np.array([0, joints[0], 0])) @ turn(x, angle[1])
    attitude = attitude @ small(np.array([0, joints[1], 0])) @ turn(z, angle[2])
    attitude = attitude @ mount @ small(fixture)
    # Mean rate of a row by what the attitude does from half a row before to half a row after.
    between = np.swapaxes(attitude[:-1], 1, 2) @ attitude[1:]
    cos = np.clip((np.trace(between, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0)
    vee = np.stack([
        between[:, 2, 1] - between[:, 1, 2], between[:, 0, 2] - between[:, 2, 0],
        between[:, 1, 0] - between[:, 0, 1],
    ], axis=1) / 2.0  # fmt: skip
    sine = np.linalg.norm(vee, axis=1)
    size = np.arctan2(sine, cos)
    step = vee * np.where(sine > 1e-12, size / np.maximum(sine, 1e-12), 1.0)[:, None] * HZ
    omega = np.empty((n, 3))
    omega[1:-1] = 0.5 * (step[1:] + step[:-1])
    omega[0], omega[-1] = step[0], step[-1]
    up = attitude[:, 2, :]
    earth = EARTH * (np.cos(latitude) * attitude[:, 1, :] + np.sin(latitude) * up)
    warm = bench.warming_k * (1.0 - np.exp(-t / 600.0))
    sign = np.sign(uniform(-1, 1, 6))
    tc = sign * np.array([bench.gyro_tc] * 3 + [bench.accel_tc] * 3)
    mean_warm = float(np.mean(warm))
    gain = 1.0 + np.outer(warm - mean_warm, tc)
    true = np.hstack([
        ((omega + earth) @ K.T) * gain[:, :3] + gravity * up @ lean.T,
        (gravity * up @ force.T) * gain[:, 3:] + omega**2 @ p.T,
    ])  # fmt: skip
    slow = grade[:, None] * pink(r, n, bench.longest_s)
    slow = slow + bench.warm_up * np.outer(sign * bias_range, 1.0 - np.exp(-t / 600.0))
    read = true + B + slow.T + deviation * r.standard_normal((n, 6))
    if bench.hum:
        read += bench.hum * deviation * np.sin(2 * np.pi * bench.hum_hz * t[:, None] + r.uniform(
            0, 2 * np.pi, 6))  # fmt: skip
    if any(bench.step):
        q = deviation / np.exp(uniform(*np.log(bench.step)))
        read = np.rint(read / q) * q
    manifest = {
        "format": "mimu-recording/1", "recording_id": f"bench-{seed}", "standard": bench.standard,
        "unit": {"manufacturer": "Bench", "model": "B", "serial": f"S{seed}"},
        "station": {"id": "bench", "gravity_m_s2": G, "heading_deg": 0.0,
                    "latitude_deg": LATITUDE / DEG,
                    "table_axes": [{"name": "outer", "direction": [0, 0, 1]},
                                   {"name": "middle", "direction": [1, 0, 0]},
                                   {"name": "inner", "direction": [0, 0, 1]}]},
        "segments": segments,
    }  # fmt: skip
    if bench.mount_deg:
        manifest["mount"] = {"quaternion_wxyz": quaternion}
    names = [f"gyro_{a}" for a in AXES] + [f"accel_{a}" for a in AXES]
    imu: dict[str, np.ndarray] = dict(zip(names, read.T, strict=True))
    if bench.warming_k:
        imu["temperature"] = 25.0 + warm
    streams: dict[str, Any] = {"imu": (t, imu)}
    if bench.table:
        at = t
        if bench.polled_s:
            at = np.arange(0.1, t[-1] - 0.1, 0.1)
            seen = at + r.uniform(-bench.polled_s, bench.polled_s, len(at))
        else:
            seen = t
        streams["table"] = (at, {
            name: np.interp(seen, t, track[k]) for k, name in
            enumerate(("outer_angle", "middle_angle", "inner_angle"))
        })  # fmt: skip
    air = np.arange(0.0, t[-1] + 10.0, 10.0)
    streams["environment"] = (air, {"temperature": 20.0 + 0 * air, "humidity": 45.0 + 0 * air})
    over_run = slow.mean(axis=1)
    felt = lean * gravity + K * EARTH * np.sin(latitude)
    truth = items(K, force, B, felt, lean * gravity, p)
    truth["per K"] = {
        "gyro_scale_factor": dict(zip(AXES, tc[:3] * np.diag(K), strict=True)),
        "accel_scale_factor": dict(zip(AXES, tc[3:] * np.diag(force), strict=True)),
        "at": 25.0 + mean_warm,
    }
    truth["mean over the run"] = {
        "gyro_bias": {a: float(over_run[i] / DEG) for i, a in enumerate(AXES)},
        "accel_bias": {a: float(over_run[3 + i]) for i, a in enumerate(AXES)},
        "gyro_fit_offset": {a: float(over_run[i] / DEG) for i, a in enumerate(AXES)},
    }
    return manifest, streams, truth


def items(
    gyro: np.ndarray, accel: np.ndarray, bias: np.ndarray, felt: np.ndarray, free: np.ndarray,
    p: np.ndarray,
) -> dict[str, Any]:  # fmt: skip
    """Item → element → value in printed units."""

    def vector(v: np.ndarray) -> Mapping[str, float]:
        return {a: float(x) for a, x in zip(AXES, v, strict=True)}

    def matrix(m: np.ndarray, own: bool) -> Mapping[str, float]:
        return {
            AXES[i] + AXES[j]: float(m[i, j]) for i in range(3) for j in range(3) if own or i != j
        }

    return {
        "gyro_scale_factor": vector(np.diag(gyro)),
        "gyro_cross_coupling": matrix(gyro, False),
        "gyro_fit_offset": vector((bias[:3] + np.diag(felt)) / DEG),
        "gyro_bias": vector(bias[:3] / DEG),
        "gyro_g_sensitivity": matrix(felt / DEG, True),
        "gyro_g_sensitivity_without": matrix(free / DEG, True),
        "accel_scale_factor": vector(np.diag(accel)),
        "accel_cross_coupling": matrix(accel, False),
        "accel_bias": vector(bias[3:]),
        "accel_rate_sensitivity": matrix(-p, False),
    }


SCENARIOS: dict[str, Bench] = {
    "in order": Bench(),
    "mount": Bench(mount_deg=1.0),
    "labels": Bench(table=False, rate_off=2e-4),
    "labels, mount": Bench(table=False, mount_deg=1.0),
    "no specification": Bench(table=False, standard="other", rate_off=2e-4),
    "warms 3 K": Bench(warming_k=3.0, gyro_tc=2e-4, accel_tc=1e-4),
    "warm-up": Bench(warm_up=0.05),
    "steps below 0.05": Bench(step=(0.01, 0.05), tactical=True),
    "steps 0.15 to 0.5": Bench(step=(0.15, 0.5), tactical=True),
    "one heading": Bench(headings=(0.0,), tactical=True),
    "two rates": Bench(rates=(-10.0, 10.0), dwell=9.0, ripple=5e-4),
    "two rates, ripple drawn": Bench(rates=(-10.0, 10.0), dwell=9.0),
    "polled": Bench(polled_s=0.02),
    "hum": Bench(hum=0.3),
    "true 1/f": Bench(longest_s=3e4, flicker=3.0, tactical=True),
}
