"""Recordings without a logger's fault in which a lot happens: taps, falls, saturation, pauses,
backlogs, steps of temperature, hum, fast turns, slow and coarse loggers.

By plain kinematics of a table that turns about the vertical and tilts; it knows nothing of what
looks for faults.
"""

import numpy as np

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tests.manifests import THREE_AXES, manifest_of

G = 9.8031
ROWS = 5000  # at most
RATES = (1.0, 2.0, 7.0, 10.0, 25.0, 50.0, 100.0, 200.0, 417.0)  # Hz
TILTS = {0.0: "+z", 90.0: "+y", 180.0: "-z", -90.0: "-y"}
SPANS = (60.0, 125.0, 250.0, 500.0, 1000.0, 2000.0), (2.0, 4.0, 8.0, 16.0)  # deg/s, g


def eventful(seed: int) -> tuple[Recording, list[str]]:
    """A recording, and what happens in it."""
    rng = np.random.default_rng([seed, 55])
    rate = float(rng.choice(RATES))
    seconds = min(300.0, ROWS / rate)
    span = np.radians(rng.choice(SPANS[0])), 9.80665 * rng.choice(SPANS[1])
    t = np.arange(0.0, seconds, 1.0 / rate)
    fastest = np.radians(rng.choice([30.0, 100.0, 300.0, 700.0]))
    spin, turned, tilt, labels = _driven(rng, t, seconds, fastest)
    read = _felt(rng, t, spin, tilt)
    happens = [
        name
        for name, chance in (
            ("taps", 0.5), ("falls", 0.25), ("temperature", 0.3), ("hum", 0.3),
            ("pauses", 0.3), ("backlog", 0.25), ("jitter", 0.3),
        )
        if rng.random() < chance
    ]  # fmt: skip
    if "taps" in happens:
        _taps(rng, t, read, span)
    if "falls" in happens:
        _falls(rng, t, read, span[1])
    if "temperature" in happens:
        late = 1.0 - np.exp(-np.maximum(t - rng.uniform(0.2, 0.6) * seconds, 0.0) / 20.0)
        read += np.outer(late, rng.normal(0.0, [0.01] * 3 + [0.1] * 3))
    if "hum" in happens:
        read += np.sin(2 * np.pi * 50.02 * t)[:, None] * rng.uniform(0.0, [0.02] * 3 + [0.3] * 3)
    noise = rng.choice([0.2, 1.0, 5.0]) * np.array([1e-3] * 3 + [1e-2] * 3)
    read += noise * rng.standard_normal(read.shape)
    read = _converted(rng, read, span)
    kept, stamps = _logged(rng, t, rate, happens)
    known = str(rng.choice(["table", "labels", "neither"]))
    manifest = manifest_of(
        f"eventful-{seed}",
        {"latitude_deg": 40.0, "gravity_m_s2": G, "heading_deg": 0.0},
        THREE_AXES if known == "table" else None,
        standard="JJF 2003-2022",
        segments=labels if known != "neither" and labels else None,
    )
    imu = Stream(stamps, dict(zip((*GYRO, *ACCEL), read[kept].T.copy(), strict=True)))
    angles = (turned, tilt, np.zeros(len(t)))
    table = Stream(t, {f"{n}_angle": a for n, a in zip(THREE_AXES, angles, strict=True)})
    happens += [f"{rate:g} Hz", known]
    return Recording(manifest, imu, table=table if known == "table" else None), happens


def _driven(
    rng: np.random.Generator, t: np.ndarray, seconds: float, fastest: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, object]]]:
    """Rate and angle of the outer axis and the tilt, (n,), and labels: turns and rests in turn."""
    ways = list(TILTS)
    spin, tilt, labels = np.zeros(len(t)), np.zeros(len(t)), list[dict[str, object]]()
    now, held = 1.0, 0.0
    while now + 22.0 < seconds:
        aim = float(rng.choice(ways))
        course = np.clip((t - now) / 4.0, 0.0, 1.0)
        tilt = np.where(t >= now, held + (aim - held) * (3 * course**2 - 2 * course**3), tilt)
        held, up = aim, TILTS[aim]
        name = f"{len(labels):03d}"
        labels.append({
            "name": f"rest_{name}", "kind": "static", "up": up, "item": "twelve_position",
            "t_start": now + 4.5, "t_end": now + 10.5,
        })  # fmt: skip
        size = float(fastest * rng.choice([-1.0, -0.3, 0.3, 1.0]))
        ramp = np.clip(np.minimum(t - now - 11.0, now + 21.0 - t) / 2.0, 0.0, 1.0)
        spin += size * ramp
        labels.append({
            "name": f"turn_{name}", "kind": "rate", "up": up, "axis": up[1], "item": "scale_factor",
            "rate_deg_s": float(np.degrees(size)), "t_start": now + 13.5, "t_end": now + 18.5,
        })  # fmt: skip
        now += 21.5
    turned = np.concatenate([[0.0], np.cumsum(0.5 * (spin[1:] + spin[:-1]) * np.diff(t))])
    return spin, turned, np.radians(tilt), labels


def _felt(
    rng: np.random.Generator, t: np.ndarray, spin: np.ndarray, tilt: np.ndarray
) -> np.ndarray:
    up = np.column_stack([np.zeros(len(t)), np.sin(tilt), np.cos(tilt)])
    rate = spin[:, None] * up
    rate[:, 0] += np.gradient(tilt, t) if len(t) > 1 else 0.0
    gains = [np.eye(3) + rng.normal(0.0, 5e-3, (3, 3)) for _ in range(2)]
    offset = rng.normal(0.0, [5e-3] * 3 + [0.1] * 3)
    return np.hstack([rate @ gains[0].T, G * up @ gains[1].T]) + offset


def _taps(
    rng: np.random.Generator, t: np.ndarray, read: np.ndarray, span: tuple[float, float]
) -> None:
    """Shocks that ring, or are over within a row, up to beyond what the unit can read."""
    for at in rng.uniform(t[0], t[-1], rng.integers(1, 12)):
        age = np.maximum(t - at, 0.0)
        wave = np.exp(-age / rng.choice([2e-3, 0.01, 0.04])) * np.cos(
            2 * np.pi * rng.uniform(8.0, 180.0) * age + rng.uniform(0.0, 6.0)
        )
        axes = rng.normal(0.0, [0.3 * span[0]] * 3 + [span[1]] * 3) * rng.choice([0.3, 1.0, 2.0])
        axes *= rng.random(6) < rng.choice([0.4, 1.0])
        read += np.where(t >= at, wave, 0.0)[:, None] * axes


def _falls(rng: np.random.Generator, t: np.ndarray, read: np.ndarray, span: float) -> None:
    """Dropped: nothing is felt, then a shock, then another attitude's gravity for a while."""
    for at in rng.uniform(t[0], t[-1], 2):
        first, last = np.searchsorted(t, (at, at + rng.uniform(0.2, 0.5)))
        read[first:last, 3:] *= 0.02
        read[last : last + 3, 3:] += span * rng.normal(0.0, 1.5, 3)
        read[last : last + 200, 3:] = read[last : last + 200, 3:][:, [1, 2, 0]]


def _converted(rng: np.random.Generator, read: np.ndarray, span: tuple[float, float]) -> np.ndarray:
    """What an output of some bits holds of the readings, no more than its span."""
    bits, decimals = int(rng.choice([10, 12, 16, 16, 16, 20])), int(rng.choice([0, 3, 5]))
    limit = np.repeat(span, 3)
    step = limit / 2.0 ** (bits - 1)
    code = np.clip(np.rint(read / step), -(2.0 ** (bits - 1)), 2.0 ** (bits - 1) - 1)
    values = code * step if rng.random() < 0.8 else np.clip(read, -limit, limit)
    return np.round(values, decimals) if decimals else values


def _logged(
    rng: np.random.Generator, t: np.ndarray, rate: float, happens: list[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Which rows there are, and their stamps."""
    kept, stamps = np.ones(len(t), bool), t.copy()
    if "pauses" in happens:
        run, pause = rng.uniform(5.0, 40.0), rng.uniform(5.0, 60.0)
        loose = rng.choice([0.0, 0.2])
        now = run
        while now < t[-1] - run:
            until = now + pause * (1.0 + loose * rng.uniform(-1.0, 1.0))
            kept &= (t < now) | (t >= until)
            now = until + run * (1.0 + loose * rng.uniform(-1.0, 1.0))
    rows = np.flatnonzero(kept)
    stamps = t[rows]
    if "jitter" in happens:
        stamps = stamps + np.abs(rng.normal(0.0, rng.choice([0.02, 0.3]) / rate, len(rows)))
    if "backlog" in happens and len(rows) > 400:
        size = int(rng.integers(40, 350))
        first = int(rng.choice([0, int(rng.integers(0, len(rows) - size - 1))]))
        last = stamps[first + size - 1]
        stamps[first : first + size] = last - 1e-4 * np.arange(size)[::-1]
    return kept, np.maximum.accumulate(stamps + 1e-9 * np.arange(len(rows)))
