"""What a recording offers to the items: its segments as positions, rate points, turns, rests."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from schemas.recording import Axis, Kind, Recording, Up
from tasks.segments.rates import TurningPoint
from tasks.segments.summarise import CHANNELS, SegmentMean, coarsely_quantised
from tasks.specifications.earth_rotation import EarthRotationGain
from tasks.uncertainty.type_a import ChannelNoise, covariance_of_means

UPS: tuple[Up, ...] = ("+x", "-x", "+y", "-y", "+z", "-z")
NOMINAL_GRAVITY = 9.8  # m/s², for what a tilt does where the local gravity is not known


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """The segment means of one recording, sorted by what they serve.

    recording: with the columns that the means were taken of.
    segments: all of them; every other field holds indices into it.
    up: for each segment, the axis that points up, as gravity shows it where it can.
    positions: indices by axis up, the rests of 7.2.2.1.
    points: indices of the rate runs about each axis, with `rate` (segments,) rad/s about it.
    turns: indices of the turns by a known angle about each axis.
    rests: indices of the rests beside the rate runs, by axis up.
    turning_points: what encoders or gyro say of each held rate, by index.
    earth: the gain of Earth's rotation in the rests; None where it was not looked for, or where
    neither latitude nor rests are known.
    channel_names: (6,) columns as they were recorded. may_stand_still: whether their resolution
    hides their noise at rest.
    """

    recording: Recording
    segments: tuple[SegmentMean, ...]
    means: np.ndarray
    noise: ChannelNoise
    up: tuple[Up | None, ...]
    positions: dict[str, tuple[int, ...]]
    points: dict[Axis, tuple[int, ...]]
    rate: np.ndarray
    turns: dict[Axis, tuple[int, ...]]
    rests: dict[str, tuple[int, ...]]
    turning_points: dict[int, TurningPoint]
    earth: EarthRotationGain | None = None
    channel_names: tuple[str, ...] = CHANNELS
    may_stand_still: bool = False

    @property
    def gravity(self) -> float | None:
        """Local gravity (m/s²), None where the recording does not state it."""
        return self.recording.manifest.station.gravity_m_s2

    @property
    def latitude_deg(self) -> float | None:
        """Latitude of the station, None where the recording does not state it."""
        return self.recording.manifest.station.latitude_deg

    @property
    def has_table(self) -> bool:
        """Whether the table's encoders were recorded."""
        return self.recording.table is not None

    def of_kind(self, kind: Kind) -> list[int]:
        """Indices of the segments of one kind."""
        return [i for i, s in enumerate(self.segments) if s.segment.kind == kind]

    @cached_property
    def coarse_channels(self) -> np.ndarray:
        """Which channels (6,) have a step that hides their noise in some segment."""
        coarse = [coarsely_quantised(segment) for segment in self.segments]
        return np.any(coarse, axis=0) if coarse else np.zeros(6, bool)

    @property
    def mounted_once(self) -> bool:
        """Whether one mounting held all segments: none has a mounting of its own."""
        return len({repr(segment.segment.mount) for segment in self.segments}) < 2

    def covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means over all segments: noise and rounding."""
        return self.noise_covariance(channel) + self.rounding_covariance(channel)

    def noise_covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means by white noise and drift."""
        return covariance_of_means(self.segments, self.noise, channel)

    def rounding_covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means by the output's step where it hides its noise.

        What a place reads is then wrong by the same part of a step each time it is held: q²/12,
        shared by the segments of one place and one rate. Zero where the noise shows.
        """
        shared = np.zeros((len(self.segments),) * 2)
        if not self.coarse_channels[channel]:
            return shared
        step = max(segment.step[channel] for segment in self.segments)
        labels = [segment.segment for segment in self.segments]
        place = [(u, s.kind, s.axis, s.rate_deg_s) for u, s in zip(self.up, labels, strict=True)]
        for same in set(place):
            held = [i for i, other in enumerate(place) if other == same]
            shared[np.ix_(held, held)] = step**2 / 12.0
        return shared
