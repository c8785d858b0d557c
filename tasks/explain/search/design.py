"""The design matrix of all candidates, transformed once, as Gram matrices in bands of frequency.

With Gram matrices by band a noise spectrum is a set of weights: gains, fits, covariances and new
noise estimates are algebra on small matrices, however long the recording was. The parameters of
all channels stand in one system of normal equations, so that an effect of several channels has
one set of parameters; the standard's model is projected out of it first (Frisch, Waugh, Lovell).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

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
from tasks.model.term import Column
from tasks.model.terms.standard import regressors

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
