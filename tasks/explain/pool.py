"""Every column of every candidate, transformed once, as Gram matrices in bands of frequency.

With Gram matrices by band a noise spectrum is a set of weights: gains, fits, covariances and new
noise estimates are algebra on small matrices, however long the recording was. The parameters of
all channels stand in one system of normal equations, so that an effect of several channels has
one set of parameters; the standard's model is projected out of it first (Frisch, Waugh, Lovell).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tasks.explain.observed import Observed
from tasks.explain.spectrum import Bands, Noise, bands_of, noise_of, padded_length, transformed
from tasks.model.term import Column

CHANNEL_COUNT = 6
RANK = 1e-9  # of a scaled normal matrix
ROUNDING = 1e-13  # of a column's power
ABSORBED = 1e-6  # of a column's power: less than this is left of it by the standard's model


@dataclass(frozen=True)
class ChannelPool:
    """One channel: which parameters (k,) it reads; transformed base (b, n) and reading (n,).

    grams: (bands, b + k + 1, b + k + 1) in the order base, columns, reading.
    """

    which: np.ndarray
    base: np.ndarray
    reading: np.ndarray
    grams: np.ndarray


@dataclass(frozen=True)
class Pool:
    """All channels; None for one that was not recorded. columns: of every parameter."""

    observed: Observed
    bands: Bands
    channels: tuple[ChannelPool | None, ...]
    columns: tuple[Column, ...]


@dataclass(frozen=True)
class System:
    """Normal equations of all parameters, each at unit size, without the standard's model.

    normal: (p, p), right: (p,), both for columns divided by `scale` (p,). misfit: chi-squared of
    the standard's model alone. A parameter that the standard absorbs whole has zero scale⁻¹.
    """

    normal: np.ndarray
    right: np.ndarray
    scale: np.ndarray
    misfit: float


def pooled(
    observed: Observed,
    base: Sequence[Sequence[np.ndarray]],
    readings: np.ndarray,
    columns: Sequence[Column],
) -> Pool:
    """The pool of base columns (for each channel), candidates' columns and readings (n, 6)."""
    bands = bands_of(padded_length(len(observed.t)), observed.rate)
    channels: list[ChannelPool | None] = []
    for channel in range(CHANNEL_COUNT):
        if not observed.weight[:, channel].any():
            channels.append(None)
            continue
        which = [p for p, column in enumerate(columns) if channel in column]
        courses = [*base[channel], *(columns[p][channel] for p in which), readings[:, channel]]
        stack = _weighed(courses, observed.weight[:, channel])
        first = len(base[channel])
        _project(stack, first)
        grams = _grams(stack, bands)
        channels.append(ChannelPool(np.array(which, int), stack[:first], stack[-1].copy(), grams))
    return Pool(observed, bands, tuple(channels), tuple(columns))


def _weighed(courses: Sequence[np.ndarray], weight: np.ndarray) -> np.ndarray:
    stack = np.zeros((len(courses), padded_length(len(weight))))
    for row, course in zip(stack, courses, strict=True):
        np.multiply(course, weight, out=row[: len(weight)])
    np.nan_to_num(stack, copy=False)
    return transformed(stack)


def _project(stack: np.ndarray, first: int) -> None:
    """Takes what the first rows, the base, explain out of the others (plain least squares).

    What is left of a column is small beside it; only so do its products keep their digits.
    """
    basis = np.linalg.qr(stack[:first].T)[0].T
    rest = stack[first:]
    before = (rest**2).sum(axis=1)
    rest -= (rest @ basis.T) @ basis
    rest[(rest**2).sum(axis=1) < ROUNDING * before] = 0.0


def _grams(stack: np.ndarray, bands: Bands) -> np.ndarray:
    """Products in single precision of rows at unit size: a third of the time."""
    size = np.sqrt((stack**2).mean(axis=1))
    size[size == 0] = 1.0
    unit = (stack / size[:, None]).astype(np.float32)
    pairs = zip(bands.edges[:-1], bands.edges[1:], strict=True)
    grams = np.stack([unit[:, a:b] @ unit[:, a:b].T for a, b in pairs]).astype(float)
    return np.asarray(grams * size[:, None] * size)


def system(pool: Pool, noises: Sequence[Noise]) -> System:
    """The normal equations by the noise of each channel."""
    count = len(pool.columns)
    normal, right, full = np.zeros((count, count)), np.zeros(count), np.zeros(count)
    misfit = 0.0
    for channel, noise in zip(pool.channels, noises, strict=True):
        if channel is None:
            continue
        gram = np.tensordot(1.0 / noise.variance(pool.bands.frequency), channel.grams, axes=1)
        first = len(channel.base)
        shared = gram[:first, first:]
        left = gram[first:, first:] - shared.T @ (inverse(gram[:first, :first]) @ shared)
        normal[np.ix_(channel.which, channel.which)] += left[:-1, :-1]
        right[channel.which] += left[:-1, -1]
        full[channel.which] += np.diag(gram)[first:-1]
        misfit += left[-1, -1]
    power = np.diag(normal)
    seen = power > ABSORBED * full
    scale = np.where(seen, 1.0 / np.sqrt(np.where(seen, power, 1.0)), 0.0)
    return System(normal * scale[:, None] * scale, right * scale, scale, misfit)


def inverse(normal: np.ndarray) -> np.ndarray:
    """Generalised inverse of a symmetric matrix, scaled to a unit diagonal first."""
    scale = np.sqrt(np.maximum(np.diag(normal), 0.0))
    scale = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0)
    values, vectors = np.linalg.eigh(normal * scale[:, None] * scale)
    kept = values > RANK * max(float(values[-1]), 0.0) if len(values) else np.zeros(0, bool)
    turned = vectors[:, kept]
    return np.asarray((turned / values[kept]) @ turned.T * scale[:, None] * scale)


def noises_of(pool: Pool, found: Sequence[int], noises: Sequence[Noise] | None) -> tuple[Noise, ...]:
    """The noise of what the standard's model and the found parameters leave, channel by channel.

    noises: by which they are fitted; without them every coefficient counts the same.
    """
    found = list(found)
    estimated = []
    for number, channel in enumerate(pool.channels):
        if channel is None:
            estimated.append(Noise(1.0, 0.0))
            continue
        mine = [p for p in found if number in pool.columns[p]]
        weight = pool.observed.weight[:, number]
        columns = channel.base
        if mine:
            courses = [pool.columns[p][number] for p in mine]
            columns = np.vstack([columns, _weighed(courses, weight)])
        level = np.ones(len(channel.reading))
        if noises is not None:
            variance = noises[number].variance(pool.bands.frequency)
            level = np.repeat(1.0 / variance, pool.bands.sizes)
        normal = (columns * level) @ columns.T
        values = inverse(normal) @ ((columns * level) @ channel.reading)
        estimated.append(noise_of(channel.reading - values @ columns, pool.bands))
    return tuple(estimated)
