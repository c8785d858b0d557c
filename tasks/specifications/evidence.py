"""What a recording offers to the items of JJF 2003: positions, rate points, turns, rests."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from schemas.recording import AXES, Axis, Recording, Segment, Up
from tasks.segments.find import GRAVITY_LIKE, find_segments, up_of
from tasks.segments.rates import turning_points
from tasks.segments.summarise import (
    ACCEL_COLUMNS,
    SegmentMean,
    coarsely_quantised,
    summarise_all,
)
from tasks.uncertainty.type_a import ChannelNoise, covariance_of_means, fit_noise

UPS: tuple[Up, ...] = ("+x", "-x", "+y", "-y", "+z", "-z")
FEWEST_ROWS = 4  # a segment with fewer has no mean worth the name


@dataclass(frozen=True)
class Evidence:
    """The segment means of one recording, sorted by what they serve.

    segments: all of them; every other field holds indices into it.
    up: for each segment, the axis that points up, as gravity shows it where it can.
    positions: indices by axis up, the rests of 7.2.2.1.
    points: indices of the rate runs about each axis, with `rate` (segments,) rad/s about it.
    turns: indices of the turns by a known angle about each axis.
    rests: indices of the rests beside the rate runs, by axis up.
    """

    segments: tuple[SegmentMean, ...]
    means: np.ndarray
    noise: ChannelNoise
    up: tuple[Up | None, ...]
    positions: dict[str, tuple[int, ...]]
    points: dict[Axis, tuple[int, ...]]
    rate: np.ndarray
    turns: dict[Axis, tuple[int, ...]]
    rests: dict[str, tuple[int, ...]]

    @cached_property
    def coarse_channels(self) -> np.ndarray:
        """Which channels (6,) have a step that hides their noise in some segment."""
        coarse = [coarsely_quantised(segment) for segment in self.segments]
        return np.any(coarse, axis=0) if coarse else np.zeros(6, bool)

    @property
    def mounted_once(self) -> bool:
        """Whether one mounting held all segments: none tells of a mounting of its own."""
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
        for each in set(place):
            held = [i for i, other in enumerate(place) if other == each]
            shared[np.ix_(held, held)] = step**2 / 12.0
        return shared


def gather(recording: Recording) -> Evidence:
    """Summarise a recording's segments, labelled or found, and sort them."""
    labels = recording.manifest.segments
    if labels:
        long_enough = tuple(s for s in labels if rows_of(recording, s) >= FEWEST_ROWS)
        segments = summarise_all(recording, long_enough, "label")
    else:
        segments = summarise_all(recording, find_segments(recording), "found")
    known = turning_points(recording, segments)
    rate = np.array([known[i].rate if i in known else np.nan for i in range(len(segments))])
    up = tuple(_up(segment) for segment in segments)
    everything = range(len(segments))
    rests = [i for i in everything if segments[i].segment.kind == "static"]
    return Evidence(
        segments=segments,
        means=np.array([segment.mean for segment in segments]).reshape(-1, 6),
        noise=fit_noise(segments, up, rate),
        up=up,
        positions={u: tuple(i for i in rests if up[i] == u and _is_position(segments[i].segment))
                   for u in UPS},
        points={axis: tuple(i for i in everything if segments[i].segment.kind == "rate"
                            and segments[i].segment.axis == axis and np.isfinite(rate[i]))
                for axis in AXES},
        rate=rate,
        turns={axis: tuple(i for i in everything if segments[i].segment.kind == "rotation"
                           and segments[i].segment.axis == axis) for axis in AXES},
        rests={u: tuple(i for i in rests if up[i] == u) for u in UPS},
    )  # fmt: skip


def rows_of(recording: Recording, segment: Segment) -> int:
    """How many rows of the unit's stream a segment has."""
    rows = recording.imu.rows(segment.t_start, segment.t_end)
    return rows.stop - rows.start


def _is_position(segment: Segment) -> bool:
    """Whether a rest belongs to 7.2.2.1: everything but the rests beside the rate runs."""
    return segment.item != "rate_sensitivity"


def _up(segment: SegmentMean) -> Up | None:
    """The axis up: what gravity shows, else the label; None where gravity shows no axis.

    While turning, only what is felt along the spin axis is gravity: a lever arm adds its own
    acceleration across it.
    """
    label = segment.segment
    found_rest = segment.origin == "found" and label.kind == "static"
    if found_rest or not segment.has_accel or label.kind == "rotation":
        return label.up
    accel = segment.mean[ACCEL_COLUMNS]
    if label.kind != "rate" or label.axis is None:
        return up_of(accel)
    along = accel[AXES.index(label.axis)]
    if not GRAVITY_LIKE[0] < abs(along) < GRAVITY_LIKE[1]:
        return None
    return f"{'+' if along > 0 else '-'}{label.axis}"  # type: ignore[return-value]
