"""What a recording offers to the items of JJF 2003: positions, rate points, turns, rests."""

from dataclasses import dataclass

import numpy as np

from schemas.recording import AXES, Axis, Recording, Segment, Up
from tasks.motion.table import mean_rate
from tasks.segments.check import GYRO_DISAGREES
from tasks.segments.find import find_segments, up_of
from tasks.segments.summarise import ACCEL_COLUMNS, SegmentMean, summarise_all
from tasks.uncertainty.type_a import ChannelNoise, covariance_of_means, fit_noise

UPS: tuple[Up, ...] = ("+x", "-x", "+y", "-y", "+z", "-z")
SLOWEST_POINT = np.radians(0.05)  # rad/s: a slower «rate» is a rest


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

    def covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means over all segments."""
        return covariance_of_means(self.segments, self.noise, channel)


def gather(recording: Recording) -> Evidence:
    """Summarise a recording's segments, labelled or found, and sort them."""
    labels = recording.manifest.segments
    if labels:
        segments = summarise_all(recording, labels, "label")
    else:
        segments = summarise_all(recording, find_segments(recording), "found")
    rate = np.array([_rate_about_axis(recording, segment) for segment in segments])
    up = tuple(_up(segment) for segment in segments)
    everything = range(len(segments))
    rests = [i for i in everything if segments[i].segment.kind == "static"]
    return Evidence(
        segments=segments,
        means=np.array([segment.mean for segment in segments]).reshape(-1, 6),
        noise=fit_noise(segments),
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


def _is_position(segment: Segment) -> bool:
    """Whether a rest belongs to 7.2.2.1: everything but the rests beside the rate runs."""
    return segment.item != "rate_sensitivity"


def _up(segment: SegmentMean) -> Up | None:
    """The axis up: what gravity shows, else the label; None where gravity shows no axis."""
    found_rest = segment.origin == "found" and segment.segment.kind == "static"
    if found_rest or not segment.has_accel or segment.segment.kind == "rotation":
        return segment.segment.up
    return up_of(segment.mean[ACCEL_COLUMNS])


def _rate_about_axis(recording: Recording, segment: SegmentMean) -> float:
    """Input rate (rad/s) of a rate point: the table's, else the label's; NaN if not known.

    Without encoders a label that the gyro contradicts by more than 5 % is no input.
    """
    label = segment.segment
    if label.kind != "rate" or label.axis is None or label.rate_deg_s is None:
        return float("nan")
    axis = AXES.index(label.axis)
    body = mean_rate(recording, label)
    if body is not None:
        return float(body[axis])
    nominal = float(np.radians(label.rate_deg_s))
    slack = max(GYRO_DISAGREES * abs(nominal), np.radians(2.0))
    contradicted = segment.has_gyro and abs(segment.mean[axis] - nominal) > slack
    return float("nan") if contradicted else nominal
