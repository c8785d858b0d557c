"""The design matrix of all candidates, transformed once, as Gram matrices in bands of frequency.

With Gram matrices by band a noise spectrum is a set of weights: gains, fits, covariances and new
noise estimates are algebra on small matrices, however long the recording was. The parameters of
all channels stand in one system of normal equations, so that an effect of several channels has
one set of parameters; the standard's model is projected out of it first (Frisch, Waugh, Lovell).
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np

from tasks.explain.explanation import TRIADS
from tasks.explain.inputs.blocks import Blocks
from tasks.explain.noise import (
    Bands,
    ChannelResidual,
    Noise,
    compared_bands,
    flicker_over_gaps,
    in_band,
    known_share,
    triad_noises,
    weighted,
)
from tasks.model.fit import inverse, of_channel
from tasks.model.model import CHANNEL_COUNT, STANDARD, STEP, Design, Model
from tasks.model.term import Column, Inputs, Term, TermKey, parameters_of
from tasks.model.terms.standard import regressors
from tasks.motion.whole import Motion

POWER_ROUNDING = 1e-13  # of a column's power
TOGETHER = 64  # columns that are projected and transformed at once
ABSORBED = 1e-6  # of a column's power: less than this is left of it by the standard's model
UNIT_NOISE = Noise(1.0, 0.0)  # by which every coefficient counts the same


@dataclass(frozen=True)
class ChannelDesign:
    """One channel: which parameters (k,) it reads; transformed base (b, n) and reading (n,).

    rows: (b + k + 1, n) base, columns and reading in single precision, divided by `size`
    (b + k + 1,); designs that differ in a few share them, and have their own in `changed`, by
    number. basis: (b, n) orthonormal rows of what was projected out, not transformed. grams:
    (bands, b + k + 1, b + k + 1) in the order of the rows, in their precision.
    """

    which: np.ndarray
    base: np.ndarray
    reading: np.ndarray
    grams: np.ndarray
    rows: np.ndarray
    changed: Mapping[int, np.ndarray]
    size: np.ndarray
    basis: np.ndarray


@dataclass(frozen=True)
class BandedDesign:
    """All channels; None for one that was not recorded. columns: of every parameter.

    half: (p,) half of the range that a parameter may plausibly have, which is prior knowledge.
    latest: the normal equations that were asked for last, by their noises.
    """

    blocks: Blocks
    bands: Bands
    channels: tuple[ChannelDesign | None, ...]
    columns: tuple[Column, ...]
    half: np.ndarray
    latest: dict[tuple[Noise, ...], "NormalEquations"] = field(default_factory=dict, init=False)


@dataclass(frozen=True)
class NormalEquations:
    """Normal equations of all parameters, each at unit size, without the standard's model.

    normal: (p, p), right: (p,), both for columns divided by `scale` (p,). misfit: chi-squared of
    the standard's model alone. A parameter that the standard absorbs whole has zero scale⁻¹.
    """

    normal: np.ndarray
    right: np.ndarray
    scale: np.ndarray
    misfit: float

    @property
    def power(self) -> np.ndarray:
        """(p,) uᵀS⁻¹u of each column; zero where the standard absorbs it."""
        return np.divide(1.0, self.scale**2, out=np.zeros_like(self.scale), where=self.scale > 0)


def banded_design(
    blocks: Blocks, readings: np.ndarray, columns: Sequence[Column], half: np.ndarray
) -> BandedDesign:
    """The design of the standard's columns, the candidates' columns and the readings (n, 6).

    half: (p,) half of each parameter's plausible range.
    """
    bands = compared_bands(blocks)
    channels = tuple(
        _channel_design(blocks, readings, columns, bands, channel)
        if blocks.weight[:, channel].any()
        else None
        for channel in range(readings.shape[1])
    )
    return BandedDesign(blocks, bands, channels, tuple(columns), half)


def _channel_design(
    blocks: Blocks, readings: np.ndarray, columns: Sequence[Column], bands: Bands, channel: int
) -> ChannelDesign:
    which, signals = of_channel(columns, readings, channel)
    standard, weight = regressors(blocks.motion, channel).T, blocks.weight[:, channel]
    stack = weighted(standard, weight, blocks)
    basis = np.linalg.qr(stack.T)[0].T
    parts = [_at_unit_size(stack, blocks)]
    for first in range(0, len(signals), TOGETHER):
        rest = _projected(weighted(signals[first : first + TOGETHER], weight, blocks), basis)
        parts.append(_at_unit_size(rest, blocks))
    rows, size = (np.concatenate(each) for each in zip(*parts, strict=True))
    grams = _products(rows, rows, bands, size, size)
    base, reading = in_band(stack, blocks), in_band(rest[-1], blocks)
    return ChannelDesign(which, base, reading, grams, rows, {}, size, basis)


def with_columns(
    design: BandedDesign, columns: Mapping[int, Column], readings: np.ndarray | None = None
) -> BandedDesign:
    """The design with other columns for some parameters, in the same channels, and other
    readings (n, 6) if given.
    """
    channels = tuple(
        channel and _with_columns(design, channel, number, columns, readings)
        for number, channel in enumerate(design.channels)
    )
    every = list(design.columns)
    nothing = np.zeros(len(design.blocks.t))
    for p, column in columns.items():
        every[p] = {c: column.get(c, nothing) for c in design.columns[p]}
    return replace(design, channels=channels, columns=tuple(every))


def _with_columns(
    design: BandedDesign,
    channel: ChannelDesign,
    number: int,
    columns: Mapping[int, Column],
    readings: np.ndarray | None,
) -> ChannelDesign:
    row_of = {int(p): row for row, p in enumerate(channel.which, len(channel.base))}
    nothing = np.zeros(len(design.blocks.t))
    changed = [p for p in columns if p in row_of]
    signals = [columns[p].get(number, nothing) for p in changed]
    at = [row_of[p] for p in changed]
    if readings is not None:
        signals.append(readings[:, number])
        at.append(len(channel.size) - 1)
    if not at:
        return channel
    weight = design.blocks.weight[:, number]
    rest = _projected(weighted(signals, weight, design.blocks), channel.basis)
    new, new_size = _at_unit_size(rest, design.blocks)
    own, size = {**channel.changed, **dict(zip(at, new, strict=True))}, channel.size.copy()
    size[at] = new_size
    grams, places = channel.grams.copy(), list(own)
    crossed = _products(new, channel.rows, design.bands, new_size, size)
    crossed[:, :, places] = _products(
        new, np.array([own[place] for place in places]), design.bands, new_size, size[places]
    )
    grams[:, at, :] = crossed
    grams[:, :, at] = crossed.transpose(0, 2, 1)
    reading = channel.reading if readings is None else in_band(rest[-1], design.blocks)
    return replace(channel, reading=reading, grams=grams, changed=own, size=size)


def _projected(stack: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """The rows minus their projection on the basis (ordinary least squares).

    The remainder of a column is small relative to the column; only this way do its products keep
    their digits.
    """
    before = np.einsum("kn,kn->k", stack, stack)
    stack -= (stack @ basis.T) @ basis
    stack[np.einsum("kn,kn->k", stack, stack) < POWER_ROUNDING * before] = 0.0
    return stack


def _at_unit_size(stack: np.ndarray, blocks: Blocks) -> tuple[np.ndarray, np.ndarray]:
    """Transformed rows in single precision, each divided by its root mean square."""
    size = np.sqrt(np.einsum("kn,kn->k", stack, stack) / stack.shape[1])
    size[size == 0] = 1.0
    return in_band((stack / size[:, None]).astype(np.float32), blocks), size


def _products(
    some: np.ndarray, others: np.ndarray, bands: Bands, size: np.ndarray, other_size: np.ndarray
) -> np.ndarray:
    """(bands, k, m) products of rows (k, n) and (m, n) times their sizes within each band."""
    pairs = zip(bands.edges[:-1], bands.edges[1:], strict=True)
    scale = (size[:, None] * other_size).astype(np.float32)
    return np.stack([some[:, a:b] @ others[:, a:b].T * scale for a, b in pairs])


def normal_equations(design: BandedDesign, noises: Sequence[Noise]) -> NormalEquations:
    """The normal equations by the noise of each channel."""
    wanted = tuple(noises)
    if wanted not in design.latest:
        design.latest.clear()
        design.latest[wanted] = _normal_equations(design, wanted)
    return design.latest[wanted]


def _normal_equations(design: BandedDesign, noises: Sequence[Noise]) -> NormalEquations:
    count = len(design.columns)
    normal, right, full = np.zeros((count, count)), np.zeros(count), np.zeros(count)
    misfit = 0.0
    for channel, noise in zip(design.channels, noises, strict=True):
        if channel is None:
            continue
        gram = _by_noise(channel.grams, noise.variance(design.bands.frequency))
        first = len(channel.base)
        shared = gram[:first, first:]
        left = gram[first:, first:] - shared.T @ (inverse(gram[:first, :first]) @ shared)
        normal[np.ix_(channel.which, channel.which)] += left[:-1, :-1]
        right[channel.which] += left[:-1, -1]
        full[channel.which] += np.diag(gram)[first:-1]
        misfit += left[-1, -1]
    power = np.diag(normal)
    observable = power > ABSORBED * full
    scale = np.where(observable, 1.0 / np.sqrt(np.where(observable, power, 1.0)), 0.0)
    whole = normal * scale[:, None] * scale + np.diag((scale / design.half) ** 2)
    return NormalEquations(whole, right * scale, scale, misfit)


def _by_noise(grams: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """(k, k) sum of grams (bands, k, k) over the variance of each band, in their precision."""
    least = float(variance.min())
    weights = (least / variance).astype(grams.dtype)
    summed = weights @ grams.reshape(len(grams), -1)
    return np.asarray(summed.reshape(grams.shape[1:]).astype(float) / least)


def residuals(
    design: BandedDesign, members: Sequence[int], noises: Sequence[Noise]
) -> list[ChannelResidual]:
    """For each channel what the standard's model and some parameters leave.

    members: numbers of the parameters. noises: by which they are fitted.
    """
    return [_residual(design, number, members, noise) for number, noise in enumerate(noises)]


def residual_noises(
    design: BandedDesign,
    members: Sequence[int],
    noises: Sequence[Noise],
    derivatives: tuple[int, int] = (0, 0),
) -> tuple[Noise, ...]:
    """The noise of what the standard's model and some parameters leave, triad by triad.

    derivatives: powers of the frequency by which the reference's noise rises in each.
    """
    found = [UNIT_NOISE] * len(design.channels)
    left = residuals(design, members, noises)
    wider = flicker_over_gaps(design.blocks.gap_ratio)
    for triad, order in zip(TRIADS, derivatives, strict=True):
        recorded = [c for c in triad if design.channels[c] is not None]
        floors = [0.0 if order else design.blocks.floor[c] for c in recorded]
        # Rows that say nothing are zero: the others have all the power that there is.
        root = [np.sqrt(known_share(design.blocks, c)) for c in recorded]
        whole = [
            replace(left[c], coefficients=left[c].coefficients / r)
            for c, r in zip(recorded, root, strict=True)
        ]
        estimates = triad_noises(whole, design.bands, floors, order)
        for c, noise in zip(recorded, estimates, strict=True):
            found[c] = replace(noise, flicker=noise.flicker * wider)
    return tuple(found)


def _residual(
    design: BandedDesign, number: int, members: Sequence[int], noise: Noise
) -> ChannelResidual:
    channel = design.channels[number]
    if channel is None:
        return ChannelResidual(np.zeros(0), np.ones(0))
    signals = [design.columns[p][number] for p in members if number in design.columns[p]]
    columns = channel.base
    if signals:
        weight = design.blocks.weight[:, number]
        more = in_band(weighted(signals, weight, design.blocks), design.blocks)
        columns = np.vstack([columns, more])
    level = 1.0 / noise.of_coefficients(design.bands)
    solved = inverse((columns * level) @ columns.T)
    values = solved @ ((columns * level) @ channel.reading)
    taken = ((solved @ columns) * columns).sum(axis=0) * level
    by_band = np.add.reduceat(taken, design.bands.edges[:-1]) / design.bands.sizes
    return ChannelResidual(channel.reading - values @ columns, 1.0 - by_band)


# A model that is linearised again and again about nearly the same values, as a fit does.
#
# What is felt changes by a small rotation, a lever arm and the like in proportion to their
# parameters. So what is felt per unit of each is computed once, about some values of all of them,
# and kept as long as it says what the terms do at the values that they have now; else it is
# computed about these.

DERIVATIVE_ROUNDING = 1e-9  # rad/s, m/s²: of derivatives times what their parameters are
LINEAR = 0.01  # of what terms change of what is felt: columns that err by less are good enough
Shape = tuple[TermKey, tuple[float, ...]]


@dataclass
class Derivatives:
    """What is felt, (n, 6) rate and force, per unit of each parameter of motion and input.

    about: the terms and their values about which that is; felt: with these.
    by_shape: what was computed so far, by shape and number of the parameter.
    """

    motion: Motion
    about: dict[Shape, tuple[Term, np.ndarray]] = field(default_factory=dict)
    felt: np.ndarray | None = None
    by_shape: dict[tuple[Shape, int], np.ndarray] = field(default_factory=dict)

    def at(self, acting: dict[Shape, tuple[Term, np.ndarray]]) -> tuple[Motion, np.ndarray]:
        """The real motion and what is felt with these terms and values, about which the derivatives
        hold from now on.
        """
        moved, inputs = felt(acting, self.motion)
        if self.felt is None or not self._hold(acting, inputs, self.felt):
            self.about, self.felt = acting, inputs
            self.by_shape.clear()
        return moved, inputs

    def of(self, term: Term, number: int) -> np.ndarray:
        """Of one parameter of a term, beside the others."""
        shape = term.key, term.at
        if (shape, number) not in self.by_shape:
            low, high = term.parameters[number].plausible
            step = np.zeros(len(term.parameters))
            step[number] = STEP * (high - low)
            _, values = self.about.get(shape, (term, np.zeros(len(step))))
            more, less = (
                felt({**self.about, shape: (term, values + side)}, self.motion)[1]
                for side in (step, -step)
            )
            self.by_shape[shape, number] = (more - less) / (2.0 * step[number])
        return self.by_shape[shape, number]

    def _hold(
        self, acting: dict[Shape, tuple[Term, np.ndarray]], inputs: np.ndarray, before: np.ndarray
    ) -> bool:
        """Whether they say what is felt with these terms and values; before: with the others."""
        known = [{shape for shape, (term, _) in some.items() if not term.parameters}
                 for some in (acting, self.about)]  # fmt: skip
        if known[0] != known[1]:
            return False
        change = np.zeros_like(inputs)
        for shape, (term, _) in (self.about | acting).items():
            nothing = term, np.zeros(len(term.parameters))
            now, then = acting.get(shape, nothing)[1], self.about.get(shape, nothing)[1]
            for number in np.flatnonzero(now != then).tolist():
                change += (now - then)[number] * self.of(term, number)
        size, error = (np.nan_to_num(np.abs(each)).max(axis=0)
                       for each in (inputs - before, inputs - before - change))  # fmt: skip
        return not (error > LINEAR * size + DERIVATIVE_ROUNDING).any()


def felt(acting: dict[Shape, tuple[Term, np.ndarray]], motion: Motion) -> tuple[Motion, np.ndarray]:
    """The real motion and what the sensors feel of it, (n, 6) rate and force, each term acting on
    those before it.
    """
    for term, values in acting.values():
        motion = term.moved(motion, values)
    inputs = Inputs.of(motion)
    for term, values in acting.values():
        inputs = term.felt(motion, inputs, values)
    return motion, np.hstack([inputs.rate, inputs.force])


@dataclass(frozen=True)
class FittedModel(Model):
    """A model that is fitted on the motion of `derivatives`."""

    derivatives: Derivatives = field(kw_only=True)

    @classmethod
    def of_model(cls, model: Model, derivatives: Derivatives) -> "FittedModel":
        """Any model with these derivatives."""
        own = {each.name: getattr(model, each.name) for each in fields(Model)}
        return cls(**own, derivatives=derivatives)

    def without(self, some: Collection[TermKey]) -> "FittedModel":
        """As `Model.without` has it."""
        return self.of_model(super().without(some), self.derivatives)

    def with_term(self, term: Term) -> "FittedModel":
        """As `Model.with_term` has it."""
        return self.of_model(super().with_term(term), self.derivatives)

    def linearised(self, motion: Motion, wanted: np.ndarray | None = None) -> Design:
        """Prediction and columns, those of motion and input by the derivatives."""
        wanted = np.ones(len(self.values), bool) if wanted is None else wanted
        kept = self._kept(wanted) if motion is self.derivatives.motion else {}
        rest = wanted.copy()
        rest[list(kept)] = False
        design = super().linearised(motion, rest)
        columns = list(design.columns)
        for p, slope in kept.items():
            columns[p] = slope
        return Design(design.prediction, tuple(columns))

    def _kept(self, wanted: np.ndarray) -> dict[int, Column]:
        """Readings per unit of the parameters of motion and input among those that are wanted,
        through the standard's terms only.
        """
        own = self.places
        acting = {
            (term.key, term.at): (term, self.values[own[term.key]].copy())
            for term in self.terms
            if term.stage in ("motion", "input")
        }
        asked = {p: (term, number) for term, _ in acting.values()
                 for number, p in enumerate(range(own[term.key].start, own[term.key].stop))
                 if wanted[p]}  # fmt: skip
        if not asked:
            return {}
        moved, now = self.derivatives.at(acting)
        read = self._standard(moved, now)
        ranges = [np.ptp(parameter.plausible) for parameter in parameters_of(self.terms)]
        return {p: self._slope(moved, now, read, self.derivatives.of(*one), STEP * ranges[p])
                for p, one in asked.items()}  # fmt: skip

    def _slope(
        self, motion: Motion, now: np.ndarray, read: np.ndarray, change: np.ndarray, step: float
    ) -> Column:
        """Readings per unit of what changes the inputs (n, 6) so."""
        slope = (self._standard(motion, now + step * change) - read) / step
        slope = np.where(self.derivatives.motion.felt, slope, np.nan)
        own = self.places
        for term in self.terms:
            slope = term.passed(motion, slope, self.values[own[term.key]])
        return {c: slope[:, c] for c in range(CHANNEL_COUNT) if slope[:, c].any()}

    def _standard(self, motion: Motion, inputs: np.ndarray) -> np.ndarray:
        """(n, 6) what the standard's terms read of inputs (n, 6)."""
        readings, own = np.zeros((CHANNEL_COUNT, len(inputs))), self.places
        for term in self.terms:
            if term.family == STANDARD:
                columns = term.columns(motion, Inputs(inputs[:, :3], inputs[:, 3:]))
                for value, column in zip(self.values[own[term.key]], columns, strict=True):
                    for channel, each in column.items():
                        readings[channel] += value * each
        return readings.T
