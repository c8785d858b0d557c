"""A short run on three table axes, to whose readings a test adds what it likes at a given z.

z: the norm of what the standard's model leaves of the signal, in units of the noise.
"""

from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from scipy.fft import dct

from schemas.recording import ACCEL, GYRO, Recording
from tests.proof.plant.case import Case, channel_noise
from tests.proof.plant.simulate import simulate

RATE = 50  # Hz
CHANNELS = (*GYRO, *ACCEL)


@dataclass(frozen=True)
class ShortRun:
    """t: (n,) s. rate, force: (n, 3) rad/s and m/s² that the table reports."""

    recording: Recording
    t: np.ndarray
    rate: np.ndarray
    force: np.ndarray

    @property
    def step(self) -> float:
        return float(self.t[1] - self.t[0])

    @cached_property
    def columns(self) -> list[np.ndarray]:
        """The standard's columns (n, k) of each channel, at one size."""
        one = np.ones((len(self.t), 1))
        gyro = np.hstack([self.rate, self.force, one])
        accel = [np.hstack([self.force, one, np.delete(self.rate**2, i, 1)]) for i in range(3)]
        return [c / np.sqrt((c**2).mean(axis=0)) for c in (*[gyro] * 3, *accel)]

    def z(self, signal: np.ndarray) -> float:
        """How visible a signal (n, 6) is beside the standard's model."""
        power = 0.0
        frequency = np.maximum(np.arange(len(self.t)), 0.5) * RATE / (2 * len(self.t))
        for series, columns, noise in zip(
            signal.T, self.columns, channel_noise("industrial"), strict=True
        ):
            if not series.any():
                continue
            root = np.sqrt(noise.density(frequency) * RATE / 2.0)[:, None]
            both = dct(np.column_stack([columns, series]), norm="ortho", axis=0) / root
            found, *_ = np.linalg.lstsq(both[:, :-1], both[:, -1], rcond=1e-10)
            power += float(((both[:, -1] - both[:, :-1] @ found) ** 2).sum())
        return float(np.sqrt(power))

    def with_signal(self, signal: np.ndarray, z: float) -> Recording:
        """The recording with a signal (n, 6) of any size, made as visible as asked for."""
        return self.with_readings(signal * (z / self.z(signal)))

    def with_readings(self, added: np.ndarray) -> Recording:
        """The recording with more readings (n, 6), rounded to the unit's steps again."""
        columns = dict(self.recording.imu.columns)
        for name, more, noise in zip(CHANNELS, added.T, channel_noise("industrial"), strict=True):
            columns[name] = np.round((columns[name] + more) / noise.step) * noise.step
        return replace(self.recording, imu=replace(self.recording.imu, columns=columns))


@cache
def short_run(seed: int, dwell_s: float = 6.0) -> ShortRun:
    """Twelve positions and three rates both ways about each axis: of 6 s each, some 5 minutes."""
    made = simulate(
        Case(seed=seed, rate_hz=RATE, rates_deg_s=(20.0, 80.0, 200.0), dwell_s=dwell_s,
             order=("rising", "alternating", "shuffled")[seed % 3])
    )  # fmt: skip
    t = made.recording.imu.t
    return ShortRun(made.recording, t, made.reported[:, :3], made.reported[:, 3:])
