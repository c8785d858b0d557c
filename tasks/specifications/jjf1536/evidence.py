"""What a recording offers to JJF 1536 in addition: attitudes, turns, angles."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from schemas.recording import (
    ACCEL,
    ANGLE,
    AXES,
    GYRO,
    MEASURED,
    Axis,
    Recording,
    Segment,
    Stream,
    Up,
)
from tasks.motion.table import EARTH_RATE
from tasks.readings.plausibility import longest_run, steps
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
    allan_variances,
    coarsely_quantised,
    far_rows,
    one_pass,
    rows_of,
    summarise,
    summarise_all,
)
from tasks.specifications.evidence import REFUTED, ClauseEvidence, EarthRotationGain, steady_gain
from tasks.uncertainty.type_a import covariance_of_means, fit_noise

# The rate of an AHRS that outputs angles: the angle gained, over the time.
#
# F of eq. (10) is the mean of the increments per second over a segment, which is the angle gained
# from its beginning to its end divided by the time between. The same holds for N of (16), (17).

FLICKER_ALLAN = 2.0 * np.log(2.0)
ROUNDS = 5  # of weighting by the model fitted before
FAINT = 0.1  # of the white part: less is what is left of a difference
AS_LONG = 0.9  # of the longest rest: rests that show noise as slow as it does
STEP_ROWS = 8000  # rows that the resolution of an angle is looked for in
OUTLYING = 5.0  # times the 90 % quantile of a turn's increments: no increment of that turn


# Noise of accumulated angles, from their increments inside the rests.
#
# Three parts: white noise of the rate, which makes the angle walk (N², rad²/s); white noise and
# rounding of the angle itself (q², rad²); flicker of the rate. Their Allan variances are N²/τ,
# 3·q²/τ² and 2·ln 2·h (IEEE Std 952, annex C). What is slower than a rest, `tasks.uncertainty`
# finds between them.


@dataclass(frozen=True)
class AngleNoise:
    """walk: (3,) N², rad²/s; angle: (3,) q², rad², of one reading."""

    walk: np.ndarray
    angle: np.ndarray


@dataclass(frozen=True)
class Increments:
    """Increments of the accumulated angles over one segment.

    increment: (3, n) rad, those that jumped replaced by what lies beside them.
    outlying: (3, n), which ones those are.
    t_start, t_end: s, the first and the last reading.
    """

    increment: np.ndarray
    outlying: np.ndarray
    t_start: float
    t_end: float


def has_angles(recording: Recording) -> bool:
    """Whether the recording holds the AHRS's accumulated angles."""
    return all(name in recording.imu.columns for name in ANGLE)


def as_rates(recording: Recording) -> Recording:
    """The recording with gyro_* (rad/s) made of the angles: the increment that begins at each row.

    Whatever checks a gyro, its steadiness, its lost samples, can then check an AHRS.
    """
    imu = recording.imu
    rates = np.diff(imu.stack(ANGLE), axis=0).T / np.diff(imu.t)
    columns = {name: values[:-1] for name, values in imu.columns.items() if name not in ANGLE}
    columns |= dict(zip(GYRO, rates, strict=True))
    return replace(recording, imu=Stream(imu.t[:-1], columns))


def resolution(imu: Stream) -> np.ndarray:
    """Smallest difference (3,) rad between two readings of each accumulated angle."""
    sample = np.sort(imu.stack(ANGLE)[:: max(1, len(imu) // STEP_ROWS)], axis=0)
    apart = np.diff(sample, axis=0)
    rounding = 8 * np.finfo(float).eps * np.abs(sample).max(axis=0)
    smallest = np.where(apart > rounding, apart, np.inf).min(axis=0, initial=np.inf)
    return np.where(np.isfinite(smallest), smallest, 0.0)


def angle_increments(imu: Stream, segment: Segment, step: np.ndarray) -> Increments | None:
    """The increments of a segment, None with fewer than two readings.

    The reading at the segment's end closes its last increment; if the angles were reset there, that
    increment jumps. step: (3,) resolution, rad.
    """
    rows = imu.rows(segment.t_start, segment.t_end)
    if rows.stop - rows.start < 2:
        return None
    interval = float(np.median(np.diff(imu.t[rows])))
    stop = rows.stop
    if stop < len(imu) and imu.t[stop] < segment.t_end + 0.5 * interval:
        stop += 1
    within = slice(rows.start, stop)
    t = imu.t[within]
    increment = np.diff(imu.channels(ANGLE, within), axis=1)
    share = interval / np.diff(t)
    replaced = np.zeros(increment.shape, bool)
    row = np.arange(len(share))
    for channel, values in enumerate(increment * share):
        outlying = _outlying_rows(values, step[channel], segment)
        if outlying is not None and not outlying.all():
            calm = np.interp(row[outlying], row[~outlying], values[~outlying])
            increment[channel, outlying] = calm / share[outlying]
            replaced[channel] = outlying
    return Increments(increment, replaced, float(t[0]), float(t[-1]))


def _outlying_rows(values: np.ndarray, step: float, segment: Segment) -> np.ndarray | None:
    """Which increments (n,) are a spike's or a restart's; in a turn they may differ a lot."""
    if segment.kind != "rotation":
        return far_rows(values, step)
    return np.abs(values) > OUTLYING * np.quantile(np.abs(values), 0.9) + 4.5 * step


def is_coarse(rests: list[np.ndarray], step: np.ndarray) -> bool:
    """Whether an angle often stands still at rest, because its resolution hides its noise."""
    for channel in range(3):
        size = np.abs(np.concatenate([rest[channel] for rest in rests] or [np.ones(1)]))
        moved = size > 0.5 * step[channel]
        if (
            step[channel] > 0
            and moved.mean() < 0.9
            and (not moved.any() or np.median(size[moved]) < 3 * step[channel])
        ):
            return True
    return False


def summarise_angles(
    recording: Recording, rates: Recording, segments: tuple[Segment, ...], origin: Origin
) -> tuple[tuple[SegmentMean, ...], AngleNoise, bool]:
    """Summaries of the segments, the noise of the angles, and whether their resolution is coarse.

    recording: with the angles; rates: the same from `as_rates`. The gyro's part of a summary is
    the angle gained over the time.
    """
    step = resolution(recording.imu)
    every_step = steps(rates.imu)
    interval = float(np.median(np.diff(recording.imu.t))) if len(recording.imu) > 1 else 1.0
    every_step[GYRO_COLUMNS] = step / interval
    kept = []
    for segment in segments:
        base = summarise(rates.imu, segment, origin, every_step)
        gain = angle_increments(recording.imu, segment, step)
        if base is not None and gain is not None:
            kept.append((base, gain))
    rests = [gain.increment for base, gain in kept if base.segment.kind == "static"]
    noise = fit_angle_noise(rests, interval, step)
    means = tuple(_with_angles(base, gain) for base, gain in kept)
    return _with_slow_noise(means, noise), noise, is_coarse(rests, step)


def _with_angles(base: SegmentMean, gain: Increments) -> SegmentMean:
    """The summary with the angle gained over the time as its rates, and their Allan variances."""
    seconds = gain.t_end - gain.t_start
    mean, step, far = base.mean.copy(), base.step.copy(), base.far_rows.copy()
    mean[GYRO_COLUMNS] = gain.increment.sum(axis=1) / seconds
    step[GYRO_COLUMNS] = 0.0  # the rounding of the angle is counted once, as its noise
    rate = gain.increment * gain.increment.shape[1] / seconds
    variances, tau = allan_variances(one_pass(rate).blocks, seconds)
    allan = np.zeros((len(tau), len(mean)))
    allan[:, GYRO_COLUMNS] = variances
    far[GYRO_COLUMNS] = gain.outlying.sum(axis=1)
    any_outlying = np.asarray(gain.outlying.any(axis=0))
    return replace(
        base,
        t_start=gain.t_start,
        t_end=gain.t_end,
        left_out=int(any_outlying.sum()),
        far_rows=far,
        longest_burst=longest_run(any_outlying),
        mean=mean,
        step=step,
        allan=allan,
        tau=tau,
    )


def _with_slow_noise(means: tuple[SegmentMean, ...], noise: AngleNoise) -> tuple[SegmentMean, ...]:
    """The summaries with the Allan variances that the rests show together.

    The longest rests keep what they show, the mean over all of them; the others, and whatever
    turns, have the white noise of the rate.
    """
    rests = {i: m for i, m in enumerate(means) if m.segment.kind == "static"}
    levels = max((len(m.tau) for m in rests.values()), default=0)
    longest = max((m.seconds for m in rests.values()), default=0.0)
    long = {
        i: m.allan[:, GYRO_COLUMNS]
        for i, m in rests.items()
        if m.seconds > AS_LONG * longest and len(m.tau) == levels
    }
    changed = []
    for i, m in enumerate(means):
        allan = np.zeros_like(m.allan)
        allan[:, GYRO_COLUMNS] = noise.walk / m.tau[:, None]
        if i in long:
            allan[:, GYRO_COLUMNS] = slow_allan(list(long.values()), m.tau, noise)
        changed.append(replace(m, allan=allan))
    return tuple(changed)


def fit_angle_noise(rests: list[np.ndarray], interval: float, step: np.ndarray) -> AngleNoise:
    """Noise that all rests together show.

    rests: increments (3, n) rad each, `interval` s apart; step: (3,) rad, resolution. The noise
    of the angle is never less than that of rounding, step²/12.
    """
    rounding = step**2 / 12.0
    variance, count = pooled_allan(rests, interval)
    if not len(count):
        return AngleNoise(np.zeros(3), rounding)
    tau = interval * 2.0 ** np.arange(len(count))
    fitted = np.array([_fit(tau, variance[:, channel], count) for channel in range(3)])
    return AngleNoise(walk=fitted[:, 1], angle=np.maximum(fitted[:, 0], rounding))


def pooled_allan(rests: list[np.ndarray], interval: float) -> tuple[np.ndarray, np.ndarray]:
    """Allan variances (levels, 3) of the rate at 1, 2, 4 … intervals, and how many differences."""
    levels = max((rest.shape[1].bit_length() - 1 for rest in rests), default=0)
    total, count = np.zeros((levels, 3)), np.zeros(levels, int)
    for rest in rests:
        gain = rest
        for level in range(rest.shape[1].bit_length() - 1):
            square = np.diff(gain, axis=1) ** 2 / (interval * 2.0**level) ** 2
            total[level] += 0.5 * square.sum(axis=1)
            count[level] += square.shape[1]
            even = gain.shape[1] // 2 * 2
            gain = gain[:, 0:even:2] + gain[:, 1:even:2]
    return total / count[:, None], count


def _fit(tau: np.ndarray, variance: np.ndarray, count: np.ndarray) -> np.ndarray:
    """q², N² and h (3,), none negative: least squares, each level as it knows its own size."""
    from scipy.optimize import nnls  # late: a tenth of a start

    if not variance.any():
        return np.zeros(3)
    design = np.column_stack([3.0 / tau**2, 1.0 / tau, np.full(len(tau), FLICKER_ALLAN)])
    expected, terms = variance.clip(min=1e-6 * variance.max() / len(tau)), np.zeros(3)
    for _ in range(ROUNDS):
        weight = np.sqrt(count) / expected
        scaled = design * weight[:, None]
        size = np.linalg.norm(scaled, axis=0)
        terms = nnls(scaled / size, variance * weight)[0] / size
        expected = np.maximum(design @ terms, 1e-12 * variance.max())
    return terms


def slow_allan(variances: list[np.ndarray], tau: np.ndarray, noise: AngleNoise) -> np.ndarray:
    """Mean Allan variance (levels, 3) of equally long rests, without the part of the angle.

    variances: (levels, 3) of each rest at block lengths tau (levels,). Never less than a part of
    what the white rate noise gives.
    """
    slow = np.mean(variances, axis=0) - 3.0 * noise.angle / tau[:, None] ** 2
    return np.maximum(slow, FAINT * noise.walk / tau[:, None])


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
