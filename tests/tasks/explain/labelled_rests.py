"""Labelled rests of an independent hand: nothing is known of the motion between them."""

from collections.abc import Sequence

import numpy as np

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tests.manifests import manifest_of

GRAVITY = 9.8015
UPS = ("+x", "-x", "+y", "-y", "+z", "-z")
RATE = 50.0  # Hz
SIGMA = np.repeat([1.5e-3, 1.5e-2], 3)  # rad/s and m/s², white noise of a sample


def labelled_rests(
    seed: int, rest: float, gap: float, turns: int = 1, flicker: float = 0.0
) -> tuple[np.ndarray, np.ndarray, list[dict[str, object]]]:
    """t (n,), readings (n, 6) and segments of six positions, `turns` times over.

    rest, gap: s. flicker: standard deviation of 1/f noise, of that of a white sample.
    """
    rng = np.random.default_rng(seed)
    count = turns * len(UPS)
    t = np.arange(round(count * (rest + gap) * RATE)) / RATE
    force = np.zeros((len(t), 3))
    segments: list[dict[str, object]] = []
    for k in range(count):
        up, start = UPS[k % len(UPS)], k * (rest + gap)
        sign, axis = (1.0 if up[0] == "+" else -1.0), "xyz".index(up[1])
        force[(t >= start) & (t < start + rest + gap), axis] = sign * GRAVITY
        segments.append({
            "name": f"rest{k}", "kind": "static", "up": up,
            "t_start": start, "t_end": start + rest,
        })  # fmt: skip
    readings = np.hstack([np.zeros_like(force), force])
    readings += rng.standard_normal(readings.shape) * SIGMA
    if flicker:
        for channel in range(6):
            readings[:, channel] += flicker * SIGMA[channel] * one_over_f(len(t), rng)
    return t, readings, segments


def recording_of(
    t: np.ndarray, readings: np.ndarray, segments: Sequence[dict[str, object]]
) -> Recording:
    manifest = manifest_of("rests", {"gravity_m_s2": GRAVITY}, segments=segments)
    columns = {name: readings[:, c].copy() for c, name in enumerate((*GYRO, *ACCEL))}
    return Recording(manifest, Stream(t, columns))


def one_over_f(count: int, rng: np.random.Generator) -> np.ndarray:
    """(count,) noise of variance one whose power density goes as 1/f."""
    size = 4 * count
    f = np.fft.rfftfreq(size)
    f[0] = np.inf
    drift = np.fft.irfft(np.fft.rfft(rng.standard_normal(size)) / np.sqrt(f), size)[:count]
    return np.asarray(drift / drift.std())
