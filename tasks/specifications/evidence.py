"""What a recording offers to the items: its segments as positions, rate points, turns, rests."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from schemas.recording import AXES, UPS, Axis, Kind, Recording, Segment, Up
from tasks.motion.whole import north_at_rest
from tasks.segments.rates import TurningPoint
from tasks.segments.summarise import CHANNELS, SegmentMean, coarsely_quantised
from tasks.specifications.earth_gain import EarthRotationGain
from tasks.uncertainty.type_a import ChannelNoise, covariance_of_means

SAMPLES = 20  # times within a rest at which north is looked up


@dataclass(frozen=True, kw_only=True)
class ClauseEvidence:
    """The segment means of one recording, and what each serves, by indices into `segments`.

    recording: with the columns that the means were taken of.
    up: for each segment, the axis that points up, as gravity shows it where it can.
    rate: (segments,) rad/s about the axis of a rate run, NaN where it is not known.
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
    rate: np.ndarray
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

    @cached_property
    def labels(self) -> tuple[Segment, ...]:
        """What is known of each segment beside its readings."""
        return tuple(segment.segment for segment in self.segments)

    def of_kind(self, kind: Kind) -> list[int]:
        """Indices of the segments of one kind."""
        return [i for i, label in enumerate(self.labels) if label.kind == kind]

    def by_up(self, indices: Iterable[int]) -> dict[str, tuple[int, ...]]:
        """Indices by the axis that points up."""
        every = tuple(indices)
        return {up: tuple(i for i in every if self.up[i] == up) for up in UPS}

    def by_axis(self, indices: Iterable[int]) -> dict[Axis, tuple[int, ...]]:
        """Indices by the axis that turns."""
        every = tuple(indices)
        return {axis: tuple(i for i in every if self.labels[i].axis == axis) for axis in AXES}

    @cached_property
    def rests(self) -> dict[str, tuple[int, ...]]:
        """The rests by axis up."""
        return self.by_up(self.of_kind("static"))

    @cached_property
    def positions(self) -> dict[str, tuple[int, ...]]:
        """The rests of 7.2.2.1 by axis up: all but those beside the rate runs."""
        rests = self.of_kind("static")
        return self.by_up(i for i in rests if self.labels[i].item != "rate_sensitivity")

    @cached_property
    def points(self) -> dict[Axis, tuple[int, ...]]:
        """The rate runs about each axis whose rate is known."""
        return self.by_axis(i for i in self.of_kind("rate") if np.isfinite(self.rate[i]))

    @cached_property
    def turns(self) -> dict[Axis, tuple[int, ...]]:
        """The turns by a known angle about each axis."""
        return self.by_axis(self.of_kind("rotation"))

    @cached_property
    def coarse_channels(self) -> np.ndarray:
        """Which channels (6,) have a step that hides their noise in some segment."""
        coarse = [coarsely_quantised(segment) for segment in self.segments]
        return np.any(coarse, axis=0) if coarse else np.zeros(6, bool)

    @cached_property
    def north(self) -> np.ndarray:
        """Mean direction (segments, 3) of north in the body in each rest; NaN where not known."""
        rests = self.of_kind("static")
        held = [self.segments[i] for i in rests]
        north = np.full((len(self.segments), 3), np.nan)
        if rests:
            times = [np.linspace(s.t_start, s.t_end, SAMPLES, endpoint=False) for s in held]
            found = north_at_rest(self.recording, np.concatenate(times))
            north[rests] = found.reshape(len(rests), SAMPLES, 3).mean(axis=1)
        return north

    @property
    def mounted_once(self) -> bool:
        """Whether one mounting held all segments: none has a mounting of its own."""
        return len({repr(label.mount) for label in self.labels}) < 2

    @property
    def accumulates(self) -> bool:
        """Whether the unit accumulates angles, so that its mean rates are formed by the times."""
        return False

    @property
    def loses_steady_rates(self) -> bool:
        """Whether the unit itself takes a steady rate for its zero and off its readings."""
        return False

    @property
    def mountings(self) -> list[str]:
        """What tells the unit's mountings in its fixture apart, of each segment."""
        if self.mounted_once:
            return [""] * len(self.segments)
        return [up or label.name for up, label in zip(self.up, self.labels, strict=True)]

    def covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means over all segments: noise and rounding."""
        return self.noise_covariances[channel] + self.rounding_covariance(channel)

    @cached_property
    def noise_covariances(self) -> np.ndarray:
        """Covariances (6, n, n) of each channel's means by white noise and drift."""
        channels = range(len(CHANNELS))
        return np.array([covariance_of_means(self.noise, c) for c in channels])

    def rounding_covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means by the output's step where it hides its noise.

        What a place reads is then wrong by the same part of a step each time it is held: q²/12,
        shared by the segments of one place and one rate or turn. Zero where the noise shows.
        """
        shared = np.zeros((len(self.segments),) * 2)
        if not self.coarse_channels[channel]:
            return shared
        step = max(segment.step[channel] for segment in self.segments)
        known = zip(self.up, self.labels, strict=True)
        place = [(up, s.kind, s.axis, s.rate_deg_s, s.angle_deg) for up, s in known]
        for same in set(place):
            held = [i for i, other in enumerate(place) if other == same]
            shared[np.ix_(held, held)] = step**2 / 12.0
        return shared
