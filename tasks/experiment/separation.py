"""How well two models can be told apart on a motion, given the noise of the unit's recording.

What one model reads is fitted by the other, with the standard's parameters and everything else
that it has free: the chi-squared that is left is what a recording would show of the difference.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from schemas.procedure import Procedure
from schemas.recording import Recording, Stream
from tasks.explain.explanation import CHANNELS
from tasks.explain.inputs.blocks import Blocks, FullRate, block_means, full_rate
from tasks.explain.noise import Noise, equations_of
from tasks.explain.search.fitted import FittedSelection, fitted
from tasks.model.fit import inverse
from tasks.model.model import Model
from tasks.motion.encoders import as_mean_rates
from tasks.motion.samples import sample_interval

FINE_HZ, STILL_HZ = 1000.0, 100.0  # of a motion that is planned, and of none
QUIET_NOISE = 1e-4  # rad/s, m/s²: so that noise is told of something
PROBABILITY = 0.95  # of one name, the right one, from which a recording decides


@dataclass(frozen=True)
class UnitNoise:
    """Of a unit and its reference as a recording of it has them. rate: Hz, of `noises`.

    intervals: s, between the samples of the unit and those of its reference.
    """

    noises: tuple[Noise, ...]
    rate: float
    full: FullRate
    intervals: tuple[float, float]

    @classmethod
    def of(cls, recording: Recording, fit: FittedSelection) -> "UnitNoise":
        streams = (recording.imu, recording.table or recording.imu)
        unit, reference = (sample_interval(one.t) for one in streams)
        full = full_rate(as_mean_rates(recording))
        return cls(fit.noises, fit.blocks.rate, full, (unit, reference))

    def _rows(self, fine: Recording) -> tuple[slice, slice]:
        """The rows of a planned motion that the unit and its reference report."""
        step = sample_interval(fine.imu.t)
        unit, reference = (slice(None, None, max(1, round(s / step))) for s in self.intervals)
        return unit, reference

    def observed(self, fine: Recording, truth: Model) -> Blocks:
        """Blocks of the readings of a unit of the true model on a planned motion, weighted as
        its own are. fine: finely sampled; the reference reports it as rarely as it does, so that
        the motion between its samples is as unknown as it will be.
        """
        readings = np.nan_to_num(truth.prediction(self._as_usual(full_rate(fine)).motion))
        readings += np.random.default_rng(0).normal(scale=QUIET_NOISE, size=readings.shape)
        columns = {**fine.imu.columns, **dict(zip(CHANNELS, readings.T.copy(), strict=True))}
        unit, reference = self._rows(fine)
        seen = replace(
            fine,
            imu=Stream(fine.imu.t, columns).at(unit),
            table=fine.table and fine.table.at(reference),
        )
        full = self._as_usual(full_rate(seen))
        variance = self.full.rest_variance.reshape(2, 3).mean(axis=1)
        full = replace(
            full,
            segment_variance=np.tile(variance, (len(full.segments) + 1, 1)),
            steps=self.full.steps,
            dithered=self.full.dithered,
            reference_noise=self.full.reference_noise,
        )
        return block_means(full, self.rate, fewest=1)

    def recording(self, fine: Recording, truth: Model) -> Recording:
        """A possible recording of a unit of the true model on a planned motion, with its white
        noise at rest. fine: finely sampled.
        """
        rows, reference = self._rows(fine)
        readings = np.nan_to_num(truth.prediction(self._as_usual(full_rate(fine)).motion))
        unit, imu = readings[rows], fine.imu.at(rows)
        deviation = np.sqrt(self.full.rest_variance)
        noisy = unit + np.random.default_rng(0).normal(size=unit.shape) * deviation
        columns = {**imu.columns, **dict(zip(CHANNELS, noisy.T.copy(), strict=True))}
        return replace(
            fine,
            imu=Stream(imu.t, columns),
            table=fine.table and fine.table.at(reference),
        )

    def _as_usual(self, full: FullRate) -> FullRate:
        """With what the unit's recording has besides, as it was there on average: a table moves
        no temperature, and a chamber that one alone.
        """
        rows = len(full.motion.t)
        usual = {
            name: np.full(rows, np.nanmedian(values))
            for name, values in self.full.motion.recorded.items()
        }
        recorded = usual | dict(full.motion.recorded)
        return replace(full, motion=replace(full.motion, recorded=recorded))

    def at(self, blocks: Blocks) -> tuple[Noise, ...]:
        return tuple(noise.at_rate(blocks.rate / self.rate) for noise in self.noises)


@dataclass(frozen=True)
class Separation:
    """Normal equations (q, q), (q,) of a model about what the true one reads, with what its prior
    knows, and the chi-squared of their difference. They add up over motions.
    """

    normal: np.ndarray
    right: np.ndarray
    chi2: float
    prior: np.ndarray

    @classmethod
    def of(cls, model: Model, observed: Blocks, noises: Sequence[Noise]) -> "Separation":
        design = model.design(observed.motion)
        misfit = observed.readings - design.prediction
        normal, right, chi2 = equations_of(design.columns, misfit, observed, noises).normal()
        prior = np.zeros(len(right))
        prior[: int(model.free.sum())] = model.prior[model.free]
        return cls(normal, right, chi2, prior)

    def __add__(self, more: "Separation") -> "Separation":
        return Separation(
            self.normal + more.normal, self.right + more.right, self.chi2 + more.chi2, self.prior
        )

    @property
    def left(self) -> float:
        """Chi-squared for which the other model cannot compensate."""
        made_up = self.right @ inverse(self.normal + np.diag(self.prior)) @ self.right
        return max(float(self.chi2 - made_up), 0.0)


def left_by_real_fit(model: Model, observed: Blocks, noises: Sequence[Noise]) -> float:
    """Chi-squared that a model leaves where it is fitted in its real form, with that of what its
    prior has to give way for: a wander that takes all of it is paid for.
    """
    found = fitted(model, observed, noises)
    misfit = observed.readings - found.prediction(observed.motion)
    given_way = float(found.prior[found.free] @ found.values[found.free] ** 2)
    return equations_of([], misfit, observed, noises).normal()[2] + given_way


def probability_right(left: float, bound: float) -> float:
    """That a recording, whose noise moves the difference by 2·√χ², shows more than the bound from
    which the true one is named alone.
    """
    if left <= 0.0:
        return 0.0
    return float(norm.cdf((left - bound) / (2.0 * np.sqrt(left))))


def enough(bound: float) -> float:
    """Chi-squared from which that has PROBABILITY."""
    margin = float(norm.ppf(PROBABILITY))
    return (margin + float(np.sqrt(margin**2 + bound))) ** 2


# A procedure that was chosen, and what it is expected to show.


@dataclass(frozen=True)
class Choice:
    """A procedure, its duration in min, and the chi-squared between the two models that are
    hardest to separate, as large as the recording has their effects. bound: the value that decides
    if there is no noise. expected: the least chi-squared between two of the models that compete.
    """

    procedure: Procedure
    minutes: float
    left: float
    bound: float
    expected: float

    @property
    def probability(self) -> float:
        """Of one name, the right one."""
        return probability_right(self.left, self.bound)

    @property
    def needed(self) -> float:
        """Chi-squared from which it decides."""
        return enough(self.bound)

    @property
    def share(self) -> float:
        """Of what it should show; from one on it decides."""
        return self.left / self.needed

    @property
    def is_enough(self) -> bool:
        """Whether it decides."""
        return self.share >= 1.0
