"""Rates and noise of the streams as they arrive, for a live view of the run."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from schemas.recording import ACCEL, ANGLE, GYRO, Stream, joined

ROWS = 400  # the last ones, of which the figures are
MOST_OF = {"gyro": (GYRO, 180.0 / np.pi), "accel": (ACCEL, 1.0)}


@dataclass
class LastRows:
    """The last ROWS of each stream."""

    streams: dict[str, Stream] = field(default_factory=dict)

    def add(self, name: str, stream: Stream) -> None:
        """Take in what came next of a stream."""
        if len(stream):
            parts = [self.streams[name], stream] if name in self.streams else [stream]
            if parts[0].columns.keys() != stream.columns.keys():
                parts = [stream]
            self.streams[name] = joined(parts).at(slice(-ROWS, None))

    @property
    def rates_hz(self) -> Mapping[str, float]:
        """Rows of each stream in a second of its time."""
        return {
            name: (len(stream) - 1) / float(stream.t[-1] - stream.t[0])
            for name, stream in self.streams.items()
            if len(stream) > 1
        }

    @property
    def noise(self) -> Mapping[str, float]:
        """Standard deviation of a sample of the noisiest gyro (deg/s) and accelerometer (m/s²).

        From the differences of samples that follow each other, in which a motion does not count.
        """
        imu = self.streams.get("imu")
        if imu is None or len(imu) < 3:
            return {}
        rates = dict(imu.columns)
        for angle, gyro in zip(ANGLE, GYRO, strict=True):
            if angle in imu.columns:
                rates[gyro] = np.gradient(imu.columns[angle], imu.t)
        found = {}
        for name, (channels, scale) in MOST_OF.items():
            known = [rates[channel] for channel in channels if channel in rates]
            if known:
                steps = np.diff(np.stack(known), axis=1)
                found[name] = scale * float(steps.std(axis=1).max()) / np.sqrt(2.0)
        return {name: value for name, value in found.items() if np.isfinite(value)}
