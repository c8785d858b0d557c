"""What a recording offers to the items: its segments as positions, rate points, turns, rests."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np

from schemas.recording import AXES, GYRO, UPS, Axis, Kind, Recording, Segment, Stream, Up
from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import north_at_rest, unit_vector
from tasks.readings.stamps import with_instants
from tasks.segments.find import GRAVITY_LIKE, find_segments, up_of
from tasks.segments.rates import TurningPoint, turning_points
from tasks.segments.summarise import (
    ACCEL_COLUMNS,
    CHANNELS,
    MIN_ROWS,
    SegmentMean,
    cosine_and_sine,
    rows_of,
    summarise_all,
)
from tasks.uncertainty.drift import WALK
from tasks.uncertainty.type_a import ChannelNoise, covariance_of_means, fit_noise
from tasks.words import Message, message
from tasks.words.numbers import MINUS

# The gain λ of Earth's rotation in a recording: 1 in full, 0 absent.

REFUTED = 3.0  # standard uncertainties from a gain that the data then refute

State = Literal["present", "not_visible", "not_shown", "odd"]


@dataclass(frozen=True)
class EarthRotationGain:
    """The gain λ with its standard uncertainty, and what it rests on.

    level: from the horizontal part, which a g-sensitivity cannot imitate; else from readings up
    minus down, which contain a g-sensitivity too.
    """

    gain: float
    u: float
    level: bool

    @property
    def state(self) -> State:
        """Which of `present` (1) and `absent` (0) the data allow, at three u; odd: neither."""
        present = abs(self.gain - 1.0) <= REFUTED * self.u
        absent = abs(self.gain) <= REFUTED * self.u
        if present:
            return "not_visible" if absent else "present"
        if absent:
            return "not_shown"
        return "odd" if self.level else "not_visible"

    @property
    def refuted(self) -> bool:
        """Whether the data show that Earth's rotation is not in them."""
        return self.level and self.state == "not_shown"


def earth_rotation_message(earth: EarthRotationGain | None) -> Message:
    """What the data show of Earth's rotation, a clause without its full stop."""
    if earth is None:
        return message("earth-rotation-unknown")
    gain = f"λ = {earth.gain:.3f} ± {2.0 * earth.u:.3f}, k = 2".replace("-", MINUS)
    basis = "level" if earth.level else "vertical"
    return message(f"earth-rotation-{basis}-{earth.state.replace('_', '-')}", gain=gain)


SAMPLES = 20  # times within a rest at which north is looked up
COURSE = 4000  # samples of a turn, at most twice as many: a hundred a turn and more
TERMS = range(1, 41)  # of the series of rounding: the rest of it is a per cent of q²/12
DITHERED = 0.8  # noise in steps beyond which nothing of the steps is left in a mean
FLIPS = 0.25  # steps²: most that going to and fro between two codes scatters
SILENT, ONE_CODE = 0.1, 1e-3  # steps: noise that hardly leaves a code, means that are one
NOISES = np.linspace(0.0, 1.0, 201)  # in steps, and the variance that rows rounded from it have
SEEN = NOISES**2 + 1.0 / 12.0 - sum(
    np.exp(-4.0 * (np.pi * k * NOISES) ** 2) / k**2 for k in range(1, 2001)
) / (2.0 * np.pi**2)  # fmt: skip


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
    hides their noise at rest. course: (6, n) the course of each channel's zero about its mean over
    the run, where the rests show one beside noise and equipment. per_kelvin: (6, n) what 1 K does
    to each mean through the channel's gain, where it follows the recorded temperature.
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
    course: np.ndarray | None = None
    per_kelvin: np.ndarray | None = None

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

    @cached_property
    def mean_turns(self) -> dict[int, complex]:
        """Mean of e^(iψ) over each segment that is no rest, by index; ψ: what the unit read of its
        turn about the axis so far. Zero where it is not known.
        """
        turning = (i for i, label in enumerate(self.labels) if label.kind != "static")
        return {i: _mean_turn(self.recording.imu, self.labels[i]) for i in turning}

    @property
    def mounted_once(self) -> bool:
        """Whether one mounting held all segments: none has a mounting of its own."""
        return len({repr(label.mount) for label in self.labels}) < 2

    @property
    def accumulates(self) -> bool:
        """Whether the unit accumulates angles, so that its mean rates are formed by the times."""
        return False

    @property
    def tells_of_site(self) -> bool:
        """Whether Earth's rotation in the rests can be held against latitude and heading."""
        return True

    @property
    def mountings(self) -> list[str]:
        """What tells the unit's mountings in its fixture apart, of each segment."""
        if self.mounted_once:
            return [""] * len(self.segments)
        return [up or label.name for up, label in zip(self.up, self.labels, strict=True)]

    def covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means over all segments: noise and rounding."""
        total = self.noise_covariances[channel] + self._by_temperature(channel)
        if self.course is not None:
            total = total + np.outer(self.course[channel], self.course[channel])
        return np.asarray(total + self._rounding[channel])

    def _by_temperature(self, channel: int) -> np.ndarray:
        """(n, n): the gain of a channel that follows the temperature, about its mean in the run."""
        if self.per_kelvin is None:
            return np.zeros(2 * (len(self.segments),))
        warmed = self.per_kelvin[channel] * (self.temperatures - self.temperatures.mean())
        return np.outer(warmed, warmed)

    def drift(self, channel: int, weights: np.ndarray) -> float:
        """By how much o·U is off by the course of the channel's zero and, of what is not at one
        temperature, of its gain; weights: o (n,).
        """
        shift = 0.0 if self.course is None else abs(float(weights @ self.course[channel]))
        if self.per_kelvin is None or not (by_gain := weights * self.per_kelvin[channel]).any():
            return shift
        at = np.average(self.temperatures, weights=np.abs(by_gain))
        return shift + abs(float(by_gain @ (self.temperatures - at)))

    @cached_property
    def temperatures(self) -> np.ndarray:
        """Mean temperature (n,) °C of the unit in each segment; NaN where it was not recorded."""
        imu, means = self.recording.imu, np.full(len(self.segments), np.nan)
        if "temperature" in imu.columns:
            for i, segment in enumerate(self.segments):
                values = imu.columns["temperature"][segment.place]
                means[i] = (
                    values[np.isfinite(values)].mean() if np.isfinite(values).any() else np.nan
                )
        return means

    def fast_covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means without walk and trend: noise and rounding."""
        walk = np.tensordot(self.noise.drift[WALK:, channel], self.noise.shapes[WALK:], axes=1)
        fast = self.noise_covariances[channel] - walk + self._by_temperature(channel)
        return np.asarray(fast + self._rounding[channel])

    @cached_property
    def noise_covariances(self) -> np.ndarray:
        """Covariances (6, n, n) of each channel's means by white noise and drift."""
        channels = range(len(CHANNELS))
        return np.array([covariance_of_means(self.noise, c) for c in channels])

    def rounding_covariance(self, channel: int) -> np.ndarray:
        """Covariance (n, n) of one channel's means by the steps q of the output: a place reads
        wrong by the same part of a step each time it is held.

        Noise of s dithers it: q²/(2π²)·Σ exp(−2π²k²(sᵢ² + sⱼ²)/q²)·cos(2πkΔ/q)/k² for means that
        differ by Δ, over an unknown offset (q²/12 without noise). Between places Δ is known as well
        as the means are; where both read one code throughout, or are one place, it is as read.
        """
        q = max((segment.step[channel] for segment in self.segments), default=0.0)
        noise = self._noise_over(q, channel)
        if not (noise < DITHERED).any():
            return np.zeros((len(noise),) * 2)
        square = noise[:, None] ** 2 + noise**2
        apart = np.nan_to_num(self.means[:, channel, None] - self.means[:, channel]) / q
        own = sum((np.exp(-4.0 * (np.pi * k * noise) ** 2) / k**2 for k in TERMS), 0.0 * noise)
        own = own / (2.0 * np.pi**2)
        unsure = np.where(self._same_place(noise, apart), 0.0, own[:, None] + own)
        terms = (
            np.exp(-2.0 * (np.pi * k) ** 2 * (square + unsure))
            * np.cos(2 * np.pi * k * apart)
            / k**2
            for k in TERMS
        )
        shared = sum(terms, start=np.zeros_like(apart)) / (2.0 * np.pi**2)
        np.fill_diagonal(shared, own)
        sizes, ways = np.linalg.eigh(
            shared
        )  # what is known of some pairs alone is no covariance yet
        return np.asarray(q**2 * (ways * sizes.clip(min=0.0)) @ ways.T)

    def rounding(self, channel: int, weights: np.ndarray) -> tuple[float, float]:
        """Variance of o·U by the output's steps, and of how many independent draws it is.

        weights: o (n,). Where places read one code nothing tells whether their errors are one,
        which a difference is free of, or independent, which a mean divides: the larger counts.
        """
        covariance = self._rounding[channel]
        alone = weights**2 * np.diag(covariance)
        together, apart = float(weights @ covariance @ weights), float(alone.sum())
        if apart == 0.0:
            return 0.0, 1.0
        draws = apart**2 / float((alone**2).sum())
        return max(together, apart), draws * min(1.0, apart / max(together, apart))

    @cached_property
    def _rounding(self) -> np.ndarray:
        """Rounding covariances (6, n, n)."""
        return np.array([self.rounding_covariance(c) for c in range(len(CHANNELS))])

    def _noise_over(self, q: float, channel: int) -> np.ndarray:
        """Noise (n,) of a channel's rows in steps, of what is held pooled.

        One code shows none of it, and a mean between two codes shows their flips, however little
        noise makes them. What varies in a turn by an angle is the turn itself. What rounding leaves
        of a deviation s is s² + q²/12 less what it does to a mean.
        """
        if not q > 0.0:
            return np.full(len(self.segments), np.inf)
        square = (np.array([each.deviation[channel] for each in self.segments]) / q) ** 2
        rests = self.of_kind("static")
        held = square[[*rests, *self.of_kind("rate")]]
        usual = held[held <= FLIPS] if (held <= FLIPS).any() else square[rests]
        pooled = float(np.mean(usual)) if len(usual) else 0.0
        seen = np.where(square > pooled + FLIPS, square, pooled)
        seen[~np.isfinite(square)] = np.inf
        seen[[*rests, *self.of_kind("rotation")]] = pooled
        return np.where(seen < SEEN[-1], np.interp(seen, SEEN, NOISES), np.sqrt(seen))

    def _same_place(self, noise: np.ndarray, apart: np.ndarray) -> np.ndarray:
        """Which pairs (n, n) are of one place and rate, or read one and the same code."""
        known = zip(self.up, self.labels, strict=True)
        place = [(up, s.kind, s.axis, s.rate_deg_s, s.angle_deg) for up, s in known]
        numbers = np.array([place.index(each) for each in place])
        one_code = (np.abs(apart) < ONE_CODE) & (noise[:, None] < SILENT) & (noise < SILENT)
        return np.asarray((numbers[:, None] == numbers) | one_code)


def _mean_turn(imu: Stream, label: Segment) -> complex:
    rows, gyro = imu.rows(label.t_start, label.t_end), GYRO[AXES.index(label.axis or "x")]
    t, rate = imu.t[rows], imu.views((gyro,), rows)[0]
    if len(t) < 2 or not np.isfinite(rate).all():
        return 0j
    steps = rate[1:] + rate[:-1]
    steps *= np.diff(t)
    every = max(1, len(steps) // COURSE)
    whole = (len(steps) - 1) // every
    between = steps[1 : 1 + whole * every].reshape(whole, every) @ np.ones(every)
    turned = 0.5 * np.cumsum(np.append(steps[0], between))
    cosine, sine = cosine_and_sine(turned)
    return complex(cosine.mean(), sine.mean())


# Least squares as the clauses write it, kept as a linear operator to propagate uncertainty.

RANK_TOLERANCE = 1e-9
TINY = 1e-9  # of a variance: keeps a covariance invertible
EXCESS_LEVEL = 0.01  # scatter that noise alone would give in one case of a hundred
BLOCKING_EXCESS = 10.0  # beyond it no larger uncertainty makes up for what is wrong


@dataclass(frozen=True)
class Solution:
    """Parameters of U = H·θ.

    operator: (p, n), θ = operator·U.
    estimable: (p,) bool, which parameters the points determine (θ_j is a combination of the
        readings only where the unit vector lies in the row space of H).
    """

    operator: np.ndarray
    estimable: np.ndarray

    def of(self, readings: np.ndarray) -> np.ndarray:
        """θ of (n,) readings; NaN where not estimable."""
        return np.where(self.estimable, self.operator @ readings, np.nan)

    def uncertainty(self, covariance: np.ndarray) -> np.ndarray:
        """Standard uncertainty (p,) of θ, from the covariance (n, n) of the readings."""
        variance = (self.operator @ covariance * self.operator).sum(axis=1)
        return np.where(self.estimable, np.sqrt(np.maximum(variance, 0.0)), np.nan)


def solve(design: np.ndarray) -> Solution:
    """(HᵀH)⁻¹Hᵀ of a (n, p) design, by the pseudo-inverse where the points are too few."""
    return _solved(design.astype(float).tobytes(), design.shape)


@lru_cache(maxsize=8)  # the same points come for every channel
def _solved(numbers: bytes, shape: tuple[int, int]) -> Solution:
    design = np.frombuffer(numbers).reshape(shape)
    scale = np.linalg.norm(design, axis=0)
    scale[scale == 0] = 1.0
    operator = np.linalg.pinv(design / scale, rcond=RANK_TOLERANCE) / scale[:, None]
    resolution = np.diag(operator @ design)
    return Solution(operator=operator, estimable=np.abs(resolution - 1.0) < 1e-6)


def last_shown(
    design: np.ndarray, readings: np.ndarray, covariance: np.ndarray, count: int
) -> tuple[np.ndarray, float]:
    """θ (p,) by generalised least squares, and how often noise alone makes the last ones so large.

    1 where points or noise do not tell.
    """
    from scipy.special import chdtrc  # late: a tenth of a start

    untold = np.full(design.shape[1], np.nan), 1.0
    if len(readings) <= design.shape[1] or not np.isfinite(readings).all():
        return untold
    sizes, ways = np.linalg.eigh(covariance)
    if not sizes[-1] > 0.0:
        return untold
    white = (ways / np.sqrt(np.maximum(sizes, TINY * sizes[-1]))).T
    solution = solve(white @ design)
    found, last = solution.of(white @ readings), solution.operator[-count:]
    if not solution.estimable[-count:].all():
        return untold
    chi2 = found[-count:] @ np.linalg.solve(last @ last.T, found[-count:])
    return found, float(chdtrc(count, chi2))


@dataclass(frozen=True)
class Residuals:
    """Residuals (n,) of a fit, their covariance (n, n) by that of the readings, and χ²."""

    values: np.ndarray
    covariance: np.ndarray
    chi2: float


def residuals_of(
    solution: Solution, design: np.ndarray, readings: np.ndarray, covariance: np.ndarray
) -> Residuals:
    """What the fit leaves of the readings."""
    maker = np.eye(len(readings)) - design @ solution.operator
    values, spread = maker @ readings, maker @ covariance @ maker.T
    variances, directions = np.linalg.eigh(spread)
    known = np.abs(variances) > 1e-6 * np.abs(variances).max(initial=0.0)
    along = values @ directions[:, known]
    return Residuals(values, spread, float((along**2 / variances[known]).sum()))


@dataclass(frozen=True)
class BirgeRatio:
    """By how much residuals exceed what the noise explains, 1 if they do not, and their dof."""

    factor: float = 1.0
    dof: float = math.inf


def birge_ratio(
    solution: Solution, design: np.ndarray, readings: np.ndarray, covariance: np.ndarray
) -> BirgeRatio:
    """√(χ²/dof) of the residuals where noise alone would reach it in fewer than 1 case of 100.

    The residuals' own covariance follows from the readings' covariance. The degrees of freedom
    are n − p.
    """
    from scipy.special import chdtrc  # late: a tenth of a start

    if not len(readings) or not np.isfinite(readings).all():
        return BirgeRatio()
    degrees = len(readings) - np.linalg.matrix_rank(design)
    if degrees < 1:
        return BirgeRatio()
    chi2 = residuals_of(solution, design, readings, covariance).chi2
    if chdtrc(degrees, chi2) < EXCESS_LEVEL:
        return BirgeRatio(float(np.sqrt(chi2 / degrees)), float(degrees))
    return BirgeRatio()


# The evidence of a recording for JJF 2003: its segments summarised and sorted.


def gather(recording: Recording) -> ClauseEvidence:
    """Summarise a recording's segments, labelled or found, and sort them."""
    recording = with_instants(recording)
    labels = recording.manifest.segments
    if labels:
        long_enough = tuple(s for s in labels if rows_of(recording, s) >= MIN_ROWS)
        segments = summarise_all(recording, long_enough, "label")
    else:
        segments = summarise_all(recording, find_segments(recording), "found")
    points = turning_points(recording, segments)
    rate = np.array([points[i].rate if i in points else np.nan for i in range(len(segments))])
    up = tuple(_up(segment) for segment in segments)
    evidence = ClauseEvidence(
        recording=recording,
        segments=segments,
        means=np.array([segment.mean for segment in segments]).reshape(-1, 6),
        noise=fit_noise(segments, up, rate),
        up=up,
        rate=rate,
        turning_points=points,
    )
    return replace(evidence, earth=earth_rotation_gain(evidence))


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


def earth_rotation_gain(evidence: ClauseEvidence) -> EarthRotationGain | None:
    """λ by least squares over the rests; None without a latitude, or where no rest determines it.

    Where north is known in the rests: for each gyro, bias, three g-sensitivities and λ times the
    north component of Earth's rate; the vertical part cannot be separated from the g-sensitivity
    and does not count. Else: (up − down)/2 over ωe·sin φ, as if the g-sensitivity were none. The
    gyros together by their weights; where they disagree u is enlarged. A scale factor of 1 is
    taken.
    """
    rests = [
        i
        for i in evidence.of_kind("static")
        if evidence.segments[i].has_gyro and evidence.up[i] is not None
    ]
    if evidence.latitude_deg is None or not rests:
        return None
    phi = np.radians(evidence.latitude_deg)
    up = np.array([unit_vector(evidence.up[i]) for i in rests])
    north = evidence.north[rests]
    level = bool(np.isfinite(north).all())
    earth = np.cos(phi) * north if level else np.sin(phi) * up
    return gain_over(evidence, rests, up, earth, level)


def gain_over(
    evidence: ClauseEvidence, rests: list[int], up: np.ndarray, earth: np.ndarray, level: bool
) -> EarthRotationGain | None:
    """λ over some rests; up, earth: (rests, 3) the vertical, and the part of Earth's rotation."""
    by_gyro = [_of_gyro(evidence, rests, up, EARTH_RATE * earth, c, level) for c in range(3)]
    gains = np.array([gain for gain in by_gyro if gain is not None])
    if not len(gains):
        return None
    weights = 1.0 / gains[:, 1] ** 2
    mean = float(weights @ gains[:, 0] / weights.sum())
    square = float(weights @ (gains[:, 0] - mean) ** 2) / max(len(gains) - 1, 1)
    return EarthRotationGain(mean, float(np.sqrt(max(square, 1.0) / weights.sum())), level)


def steady_gain(
    evidence: ClauseEvidence, rests: list[int], attitude: np.ndarray, level: float
) -> EarthRotationGain | None:
    """How much of Earth's level rotation (rad/s) rests show, along whatever level direction.

    attitude: (rests, 3, 3) axes of the unit along east, north and up. A wrong heading shows all of
    it along another one.
    """
    east, north, up = np.moveaxis(attitude, 2, 0)
    parts = [
        gain_over(evidence, rests, up, level / EARTH_RATE * part, True) for part in (north, east)
    ]
    if parts[0] is None or parts[1] is None:
        return None
    return EarthRotationGain(float(np.hypot(parts[0].gain, parts[1].gain)), parts[0].u, True)


def _of_gyro(
    evidence: ClauseEvidence,
    rests: list[int],
    up: np.ndarray,
    earth: np.ndarray,
    gyro: int,
    level: bool,
) -> tuple[float, float] | None:
    """λ and u of one gyro; None where its rests do not determine it."""
    bias, rate = np.ones(len(rests)), earth[:, gyro]
    columns = (bias, *up.T, rate) if level else (bias, rate)
    if not level:
        rests = [i for i, on in zip(rests, rate, strict=True) if on]
        columns = (bias[rate != 0.0], rate[rate != 0.0])
    design = np.column_stack(columns)
    if not len(design):
        return None
    solution = solve(design)
    readings = evidence.means[rests, gyro]
    covariance = evidence.covariance(gyro)[np.ix_(rests, rests)]
    u = float(solution.uncertainty(covariance)[-1])
    u *= birge_ratio(solution, design, readings, covariance).factor
    value = float(solution.of(readings)[-1])
    return (value, u) if np.isfinite(value) and u > 0.0 else None
