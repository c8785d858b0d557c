"""What a recording offers to JJF 1536 in addition: attitudes, turns, angles."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from schemas.recording import ACCEL, ANGLE, AXES, GYRO, MEASURED, Axis, Recording, Up
from tasks.motion.table import EARTH_RATE
from tasks.readings.stamps import with_instants
from tasks.segments.attitude import COMPONENTS, attitude_vector, with_attitude
from tasks.segments.find import find_segments, up_of
from tasks.segments.rates import turning_points
from tasks.segments.summarise import (
    ACCEL_COLUMNS,
    CHANNELS,
    GYRO_COLUMNS,
    MIN_ROWS,
    Origin,
    SegmentMean,
    coarsely_quantised,
    rows_of,
    summarise_all,
)
from tasks.specifications.earth_gain import REFUTED, EarthRotationGain
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.gather import steady_gain
from tasks.specifications.jjf1536.angles import as_rates, has_angles, summarise_angles
from tasks.uncertainty.type_a import covariance_of_means, fit_noise

SCALE_ITEMS = ("scale_factor", "rate_sensitivity")  # rests with these labels are no positions

OTHER_RATE = np.radians(2.0)  # rad/s: a zero offset is no other rate
KEPT = 0.8  # of Earth's rotation: an AHRS in order shows 0.9 and more


@dataclass(frozen=True, kw_only=True)
class AhrsEvidence(ClauseEvidence):
    """Evidence with what JJF 1536 needs beside it.

    attitude: (3, 15) of each rest (`attitude_vector`), None where it is not known and
    where it turns.
    angle_noise: (3,) rad², variance of one reading of the angle; 0 for rates.
    by_angle: whether the rates are increments of accumulated angles.
    """

    attitude: tuple[np.ndarray | None, ...]
    angle_noise: np.ndarray
    by_angle: bool

    @cached_property
    def rests(self) -> dict[str, tuple[int, ...]]:
        """The rests beside the rate runs, by axis up."""
        rests = self.of_kind("static")
        return self.by_up(i for i in rests if self.labels[i].item in (None, *SCALE_ITEMS))

    @cached_property
    def positions(self) -> dict[str, tuple[int, ...]]:
        """All rests by axis up."""
        return self.by_up(self.of_kind("static"))

    @cached_property
    def points(self) -> dict[Axis, tuple[int, ...]]:
        """The rate runs of 7.1 about each axis: those that read the axis that was turned."""
        return self.by_axis(
            i
            for i in self.of_kind("rate")
            if self.labels[i].item != "misalignment"
            and np.isfinite(self.rate[i])
            and not reads_another_rate(self.segments[i], self.rate[i])
        )

    @cached_property
    def turns(self) -> dict[Axis, tuple[int, ...]]:
        """The turns of 7.3 about each axis, whether labelled by their angle or by their rate."""
        return self.by_axis(
            i
            for i, label in enumerate(self.labels)
            if label.kind == "rotation" or (label.kind == "rate" and label.item == "misalignment")
        )

    def attitudes_of(self, rests: list[int]) -> np.ndarray | None:
        """Attitude vectors (rests, 3, 15), None where one is not known."""
        known = [vector for i in rests if (vector := self.attitude[i]) is not None]
        exact = np.array(known).reshape(-1, 3, COMPONENTS).round(9)  # the cosine of 90° is nothing
        return exact if len(known) == len(rests) else None

    @cached_property
    def earth_in_attitude(self) -> np.ndarray | None:
        """Earth's rotation (15,) rad/s along an attitude vector; None where north is not known.

        North is where the station's heading has it, or where labels alone say that the axes point.
        """
        station, held = self.recording.manifest.station, filter(is_zero_position, self.segments)
        labelled = not self.has_table and all(
            "points" in (s.segment.model_extra or {}) for s in held
        )
        if station.latitude_deg is None or (station.heading_deg is None and not labelled):
            return None
        phi, earth = np.radians(station.latitude_deg), np.zeros(COMPONENTS)
        earth[1:3] = EARTH_RATE * np.array([np.cos(phi), np.sin(phi)])
        return earth

    @cached_property
    def north(self) -> np.ndarray:
        """As encoders show it in each rest, else as the labels of the positions have it."""
        north = super().north
        if self.earth_in_attitude is not None:
            for i, vector in enumerate(self.attitude):
                if vector is not None and np.isnan(north[i]).any():
                    north[i] = vector[:, 1]
        return north

    @property
    def hidden_by_steps(self) -> bool:
        """Whether in a rest the steps of the output hide what is less than a step."""
        rests = self.of_kind("static")
        return any(coarsely_quantised(self.segments[i])[GYRO_COLUMNS].any() for i in rests)

    @cached_property
    def loses_steady_rates(self) -> bool:
        """Whether far less of Earth's rotation is in the readings than the positions turn it by."""
        shown = self.earth
        return shown is not None and shown.gain + REFUTED * shown.u < KEPT

    @property
    def tells_of_site(self) -> bool:
        return self.has_table and not (self.hidden_by_steps or self.loses_steady_rates)

    @property
    def accumulates(self) -> bool:
        return self.by_angle

    @property
    def mountings(self) -> list[str]:
        """On a table of one axis the unit is mounted anew for each position of 7.2 and each axis
        that is turned; one of several axes brings it there.
        """
        if self.has_table and self.recording.manifest.station.table_axes:
            return super().mountings
        known = zip(self.segments, self.attitude, self.up, strict=True)
        return [
            str(np.round(attitude, 1)) if is_zero_position(s) and attitude is not None
            else str(up or s.segment.axis or s.segment.name)
            for s, attitude, up in known
        ]  # fmt: skip

    @cached_property
    def noise_covariances(self) -> np.ndarray:
        """Covariances (6, n, n) of each channel's mean rates: rate noise, drift, and angle noise.

        A mean rate is the difference of two readings of the angle over the time; segments that
        share a reading share its error, with opposite signs.
        """
        channels = range(len(CHANNELS))
        rates = [covariance_of_means(self.noise, c) for c in channels]
        angle_noise = np.append(self.angle_noise, np.zeros(3))  # accelerometers read no angle
        return np.array(rates) + angle_noise[:, None, None] * _shared_readings(self.segments)


def _shared_readings(segments: tuple[SegmentMean, ...]) -> np.ndarray:
    """Covariance (n, n), 1/s², of mean rates per unit variance of one angle reading."""
    seconds = np.array([segment.seconds for segment in segments])
    start = np.array([segment.t_start for segment in segments])
    end = np.array([segment.t_end for segment in segments])
    same = 1.0 * (start[:, None] == start) + 1.0 * (end[:, None] == end)
    opposite = 1.0 * (start[:, None] == end) + 1.0 * (end[:, None] == start)
    return (same - opposite) / np.outer(seconds, seconds)


def reads_another_rate(segment: SegmentMean, rate: float) -> bool:
    """Whether the axis that label or mount says was turned reads something else altogether.

    rate: rad/s, by the table or the label. No scale factor is below a half or above two.
    """
    axis = segment.segment.axis
    read = segment.mean[AXES.index(axis)] if axis else np.nan
    reach = max(0.5 * abs(rate), OTHER_RATE)
    return bool(abs(read - rate) > reach and not 0.5 < read / rate < 2.0)


def is_zero_position(segment: SegmentMean) -> bool:
    """Whether a rest belongs to 7.2: every rest but those beside the rate runs and the turns."""
    label = segment.segment
    return label.kind == "static" and label.item not in (*SCALE_ITEMS, "misalignment")


def gather_ahrs(recording: Recording) -> AhrsEvidence:
    """Summarise a recording's segments, labelled or found, and sort them."""
    recording = with_instants(recording)
    by_angle = has_angles(recording)
    rates = as_rates(recording) if by_angle else recording
    labels = recording.manifest.segments
    origin: Origin = "label" if labels else "found"
    measured = tuple(
        segment
        for segment in labels or find_segments(rates)
        if segment.kind in MEASURED and rows_of(rates, segment) >= MIN_ROWS
    )
    noise, coarse = np.zeros(3), False
    if by_angle and measured:
        segments, angles, coarse = summarise_angles(recording, rates, measured, origin)
        noise = angles.angle
    else:
        segments = summarise_all(rates, measured, origin)
    segments = tuple(s for s in segments if s.has_gyro)
    points = turning_points(rates, segments)
    rate = np.array([points[i].rate if i in points else np.nan for i in range(len(segments))])
    attitudes = tuple(
        attitude_vector(rates, s.segment) if s.segment.kind == "static" else None for s in segments
    )
    up = tuple(_up(s, vector) for s, vector in zip(segments, attitudes, strict=True))
    for_noise = tuple(
        _for_noise(s, vector, points[i].rate if i in points else None)
        for i, (s, vector) in enumerate(zip(segments, attitudes, strict=True))
    )
    evidence = AhrsEvidence(
        recording=rates,
        segments=segments,
        means=np.array([segment.mean for segment in segments]).reshape(-1, len(CHANNELS)),
        noise=fit_noise(for_noise),
        up=up,
        rate=rate,
        turning_points=points,
        attitude=attitudes,
        angle_noise=noise,
        by_angle=by_angle,
        channel_names=(*(ANGLE if by_angle else GYRO), *ACCEL),
        may_stand_still=coarse,
    )
    return replace(evidence, earth=_steady_gain(evidence))


def _steady_gain(evidence: AhrsEvidence) -> EarthRotationGain | None:
    """Of Earth's rotation in the positions; None where they are not known, or steps hide it."""
    rests = [i for i, segment in enumerate(evidence.segments) if is_zero_position(segment)]
    earth, attitude = evidence.earth_in_attitude, evidence.attitudes_of(rests)
    if evidence.hidden_by_steps or earth is None or attitude is None:
        return None
    return steady_gain(evidence, rests, attitude[:, :, :3], float(earth[1]))


def _for_noise(segment: SegmentMean, vector: np.ndarray | None, rate: float | None) -> SegmentMean:
    """A summary with what its place and rate really were, by which drift is recognised.

    A turn whose rate is not known says nothing of drift; nor does a triad that was not recorded.
    """
    label = with_attitude(segment.segment, vector)
    if rate is not None:
        known = {"rate_deg_s": float(np.degrees(rate))} if np.isfinite(rate) else {"up": None}
        label = label.model_copy(update=known)
    return replace(segment, segment=label, allan=np.nan_to_num(segment.allan))


def _up(segment: SegmentMean, vector: np.ndarray | None) -> Up | None:
    """The axis up: what gravity shows in a rest, else the label, else the attitude."""
    label = segment.segment
    if label.kind == "static" and segment.has_accel:
        return up_of(segment.mean[ACCEL_COLUMNS])
    return label.up or with_attitude(label, vector).up
