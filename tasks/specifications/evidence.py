"""What a recording offers to the items: its segments as positions, rate points, turns, rests."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from schemas.recording import AXES, GYRO, UPS, Axis, Kind, Recording, Segment, Stream, Up
from tasks.motion.whole import north_at_rest
from tasks.segments.one_pass import cosine_and_sine
from tasks.segments.rates import TurningPoint
from tasks.segments.summarise import CHANNELS, SegmentMean
from tasks.specifications.earth_gain import EarthRotationGain
from tasks.uncertainty.drift import WALK
from tasks.uncertainty.type_a import ChannelNoise, covariance_of_means

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
