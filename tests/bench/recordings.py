"""Recordings of any length to measure on."""

import numpy as np

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tests.manifests import manifest_of

RATE_HZ = 1000.0
DWELLS = 48  # twelve positions, ten rates and two rests about each axis
GRAVITY = 9.8
NOISE = [1e-3] * 3 + [1e-2] * 3  # rad/s, m/s²


def recording(rows: int = 1_440_000, seed: int = 0) -> Recording:
    """A JJF 2003 run of about so many rows: twelve positions, ten rates and two rests per axis."""
    rng = np.random.default_rng(seed)
    count = rows // DWELLS
    values = np.empty((6, DWELLS * count))
    segments: list[dict[str, object]] = []

    def hold(name: str, rate: np.ndarray, upward: np.ndarray, **label: object) -> None:
        level = np.concatenate([rate, upward * GRAVITY])
        first = count * len(segments)
        values[:, first : first + count] = (level + rng.normal(0.0, NOISE, (count, 6))).T
        # Whole nanoseconds, as the rows: no row of a neighbour is within.
        start, end = (round(rows / RATE_HZ, 9) for rows in (first, first + count))
        segments.append({"name": name, "t_start": start, "t_end": end, **label})

    still = np.zeros(3)
    for axis, letter in enumerate("xyz"):
        up = np.eye(3)[axis]
        for sign, mark in ((1, "+"), (-1, "-")):
            for turn in (0, 180):
                hold(f"{mark}{letter}{turn}", still, sign * up, kind="static",
                     item="twelve_position", up=mark + letter, turn_deg=turn)  # fmt: skip
    for axis, letter in enumerate("xyz"):
        up = np.eye(3)[axis]
        rest = {"kind": "static", "item": "rate_sensitivity", "up": "+" + letter}
        hold(f"rest_{letter}", still, up, **rest)
        for rate in (-300, -200, -100, -50, -10, 10, 50, 100, 200, 300):
            hold(f"{letter}{rate}", up * np.radians(rate), up, kind="rate", item="scale_factor",
                 axis=letter, up="+" + letter, rate_deg_s=rate)  # fmt: skip
        hold(f"rest2_{letter}", still, up, **rest)
    manifest = manifest_of(
        f"bench {rows} {seed}",
        {"latitude_deg": 40.0, "gravity_m_s2": GRAVITY},
        standard="JJF 2003-2022",
        segments=segments,
    )
    t = np.round(np.arange(values.shape[1]) / RATE_HZ, 9)
    return Recording(manifest, Stream(t, dict(zip(GYRO + ACCEL, values, strict=True))))
