"""What a recording offers to JJF 1536: rate points, rests, positions and whole turns."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from schemas.recording import AXES, Recording, Up
from tasks.segments.find import find_segments, up_of
from tasks.segments.rates import turning_points
from tasks.segments.summarise import ACCEL_COLUMNS, SegmentMean, summarise_all
from tasks.specifications.evidence import FEWEST_ROWS, UPS, Evidence, rows_of
from tasks.specifications.jjf1536.angles import as_rates, has_angles, summarise_angles
from tasks.specifications.jjf1536.attitudes import placed, pointing
from tasks.uncertainty.type_a import covariance_of_means, fit_noise

SCALE_ITEMS = ("scale_factor", "rate_sensitivity")  # rests with these labels are no positions

UNREAD = np.radians(2.0)  # rad/s: a zero offset is no other rate


@dataclass(frozen=True)
class AhrsEvidence(Evidence):
    """Evidence with what JJF 1536 needs beside it.

    recording: with the rates that the means were taken of.
    pointing: (3, 15) of each rest, None where it is not told and where it turns.
    angle_noise: (3,) rad², variance of one reading of the angle; 0 for rates.
    by_angle: whether the rates are increments of accumulated angles.
    coarse: whether the resolution of the angle hides its noise at rest.
    """

    recording: Recording
    pointing: tuple[np.ndarray | None, ...]
    angle_noise: np.ndarray
    by_angle: bool = False
    coarse: bool = False

    def noise_covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's mean rates: rate noise, drift, and angle noise.

        A mean rate is the difference of two readings of the angle over the time; segments that
        share a reading share its error, with opposite signs.
        """
        rate = covariance_of_means(self.segments, self.noise, channel)
        return rate + self.angle_noise[channel] * _shared_readings(self.segments)


def gather_ahrs(recording: Recording) -> AhrsEvidence:
    """Summarise a recording's segments, labelled or found, and sort them."""
    by_angle = has_angles(recording)
    rates = as_rates(recording) if by_angle else recording
    labels = recording.manifest.segments
    origin: Literal["label", "found"] = "label" if labels else "found"
    wanted = labels or find_segments(rates)
    wanted = tuple(s for s in wanted if rows_of(rates, s) >= FEWEST_ROWS)
    measured = tuple(s for s in wanted if s.kind in ("static", "rate", "rotation"))
    segments: tuple[SegmentMean, ...] = ()
    noise, coarse = np.zeros(3), False
    if by_angle and measured:
        segments, angles, coarse = summarise_angles(recording, rates, measured, origin)
        noise = angles.angle
    elif measured:
        segments = summarise_all(rates, measured, origin)
    segments = tuple(s for s in segments if s.has_gyro)
    return replace(_sorted(rates, segments, noise), by_angle=by_angle, coarse=coarse)


def _sorted(rates: Recording, segments: tuple[SegmentMean, ...], noise: np.ndarray) -> AhrsEvidence:
    known = {i: point.rate for i, point in turning_points(rates, segments).items()}
    everything = range(len(segments))
    rate = np.array([known.get(i, np.nan) for i in everything])
    read = [np.isfinite(rate[i]) and not is_unread(segments[i], rate[i]) for i in everything]
    pointings = tuple(
        pointing(rates, s.segment) if s.segment.kind == "static" else None for s in segments
    )
    up = tuple(_up(s, points) for s, points in zip(segments, pointings, strict=True))
    rests = [i for i in everything if segments[i].segment.kind == "static"]
    labels = [segment.segment for segment in segments]
    seen = tuple(
        _for_noise(s, points, known.get(i))
        for i, (s, points) in enumerate(zip(segments, pointings, strict=True))
    )
    return AhrsEvidence(
        segments=segments,
        means=np.array([segment.mean for segment in segments]).reshape(-1, 6),
        noise=fit_noise(seen),
        up=up,
        positions={u: tuple(i for i in rests if up[i] == u) for u in UPS},
        points={axis: tuple(i for i in everything if labels[i].kind == "rate"
                            and labels[i].axis == axis and labels[i].item != "misalignment"
                            and read[i]) for axis in AXES},
        rate=rate,
        turns={axis: tuple(i for i in everything if labels[i].axis == axis
                           and (labels[i].kind == "rotation" or (labels[i].kind == "rate"
                                and labels[i].item == "misalignment"))) for axis in AXES},
        rests={u: tuple(i for i in rests if up[i] == u and labels[i].item in (None, *SCALE_ITEMS))
               for u in UPS},
        recording=rates,
        pointing=pointings,
        angle_noise=noise,
    )  # fmt: skip


def _for_noise(segment: SegmentMean, points: np.ndarray | None, rate: float | None) -> SegmentMean:
    """A summary with what its place and rate really were, for drift to be told from them.

    A turn whose rate nobody knows tells nothing of drift; nor does a triad that was not recorded.
    """
    label = placed(segment.segment, points)
    if rate is not None:
        known = {"rate_deg_s": float(np.degrees(rate))} if np.isfinite(rate) else {"up": None}
        label = label.model_copy(update=known)
    return replace(segment, segment=label, allan=np.nan_to_num(segment.allan))


def is_unread(segment: SegmentMean, rate: float) -> bool:
    """Whether the axis that a label or a mount says was turned reads something else altogether.

    rate: rad/s, by the table or the label. No scale factor is below a half or above two.
    """
    axis = segment.segment.axis
    shown = segment.mean[AXES.index(axis)] if axis else np.nan
    return bool(abs(shown - rate) > max(0.5 * abs(rate), UNREAD) and not 0.5 < shown / rate < 2.0)


def is_zero_position(segment: SegmentMean) -> bool:
    """Whether a rest belongs to 7.2: every rest but those beside the rate runs and the turns."""
    label = segment.segment
    return label.kind == "static" and label.item not in (*SCALE_ITEMS, "misalignment")


def _up(segment: SegmentMean, points: np.ndarray | None) -> Up | None:
    """The axis up: what gravity shows in a rest, else the label, else the attitude."""
    label = segment.segment
    if label.kind == "static" and segment.has_accel:
        return up_of(segment.mean[ACCEL_COLUMNS])
    return label.up or placed(label, points).up


def _shared_readings(segments: tuple[SegmentMean, ...]) -> np.ndarray:
    """Covariance (n, n), 1/s², of mean rates per unit variance of one angle reading."""
    seconds = np.array([segment.seconds for segment in segments])
    start = np.array([segment.t_start for segment in segments])
    end = np.array([segment.t_end for segment in segments])
    same = 1.0 * (start[:, None] == start) + 1.0 * (end[:, None] == end)
    opposite = 1.0 * (start[:, None] == end) + 1.0 * (end[:, None] == start)
    return (same - opposite) / np.outer(seconds, seconds)
