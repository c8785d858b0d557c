"""Every column of every candidate, transformed once, as Gram matrices in bands of frequency.

With Gram matrices by band a noise spectrum is a set of weights: gains, fits, covariances and new
noise estimates are algebra on small matrices, however long the recording was. The parameters of
all channels stand in one system of normal equations, so that an effect of several channels has
one set of parameters; the standard's model is projected out of it first (Frisch, Waugh, Lovell).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tasks.explain.channels import TRIADS
from tasks.explain.inputs.observed import Observed
from tasks.explain.regression.spectrum import (
    Bands,
    Left,
    Noise,
    bands_of,
    noises_of_triad,
    padded_length,
    transformed,
)
from tasks.model.regression import inverse
from tasks.model.term import Column
from tasks.model.terms.standard import regressors

CHANNEL_COUNT = 6
ROUNDING = 1e-13  # of a column's power
ABSORBED = 1e-6  # of a column's power: less than this is left of it by the standard's model


@dataclass(frozen=True)
class ChannelPool:
    """One channel: which parameters (k,) it reads; transformed base (b, n) and reading (n,).

    rows: (b + k + 1, n) all of them in single precision, divided by `size` (b + k + 1,); basis:
    (b, n) orthonormal rows of what was projected out, not transformed.
    grams: (bands, b + k + 1, b + k + 1) in the order base, columns, reading.
    """

    which: np.ndarray
    base: np.ndarray
    reading: np.ndarray
    grams: np.ndarray
    rows: np.ndarray
    size: np.ndarray
    basis: np.ndarray


@dataclass(frozen=True)
class Pool:
    """All channels; None for one that was not recorded. columns: of every parameter.

    half: (p,) half of the range that a parameter may plausibly have, which is known beforehand.
    """

    observed: Observed
    bands: Bands
    channels: tuple[ChannelPool | None, ...]
    columns: tuple[Column, ...]
    half: np.ndarray


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
    readings: np.ndarray,
    columns: Sequence[Column],
    half: np.ndarray,
) -> Pool:
    """The pool of the standard's columns, the candidates' columns and readings (n, 6).

    half: (p,) half of each parameter's plausible range.
    """
    bands = bands_of(padded_length(len(observed.t)), observed.rate)
    channels: list[ChannelPool | None] = []
    for channel in range(CHANNEL_COUNT):
        if not observed.weight[:, channel].any():
            channels.append(None)
            continue
        which = [p for p, column in enumerate(columns) if channel in column]
        weight = observed.weight[:, channel]
        stack = _weighed(list(regressors(observed.motion, channel).T), weight)
        basis = np.linalg.qr(stack.T)[0].T
        courses = [*(columns[p][channel] for p in which), readings[:, channel]]
        rest = _projected(_weighed(courses, weight), basis)
        rows, size = _at_unit_size(np.vstack([stack, rest]))
        grams = _products(rows, rows, bands) * size[:, None] * size
        channels.append(
            ChannelPool(
                np.array(which, int), transformed(stack), transformed(rest[-1]),
                grams, rows, size, basis,
            )
        )  # fmt: skip
    return Pool(observed, bands, tuple(channels), tuple(columns), half)


def renewed(pool: Pool, columns: Mapping[int, Column], readings: np.ndarray | None) -> Pool:
    """The pool with other columns for some parameters, in the channels that they had, and other
    readings (n, 6); None: the same ones.

    What was found is linearised anew where it stands now; everything else is as it was.
    """
    channels: list[ChannelPool | None] = []
    every = list(pool.columns)
    for number, channel in enumerate(pool.channels):
        if channel is None:
            channels.append(None)
            continue
        mine = [p for p in columns if p in set(channel.which.tolist())]
        weight = pool.observed.weight[:, number]
        nothing = np.zeros(len(weight))
        courses = [columns[p].get(number, nothing) for p in mine]
        first = len(channel.base)
        at = [first + int(np.flatnonzero(channel.which == p)[0]) for p in mine]
        if readings is not None:
            courses.append(readings[:, number])
            at.append(len(channel.size) - 1)
        if not at:
            channels.append(channel)
            continue
        rest = _projected(_weighed(courses, weight), channel.basis)
        new, new_size = _at_unit_size(rest)
        reading = channel.reading if readings is None else transformed(rest[-1])
        rows, size, grams = channel.rows.copy(), channel.size.copy(), channel.grams.copy()
        rows[at], size[at] = new, new_size
        crossed = _products(new, rows, pool.bands) * new_size[:, None] * size
        grams[:, at, :] = crossed
        grams[:, :, at] = crossed.transpose(0, 2, 1)
        channels.append(replace(channel, reading=reading, grams=grams, rows=rows, size=size))
        for p in mine:
            kept = {c: course for c, course in columns[p].items() if c in pool.columns[p]}
            every[p] = {c: kept.get(c, nothing) for c in pool.columns[p]}
    return replace(pool, channels=tuple(channels), columns=tuple(every))


def _weighed(courses: Sequence[np.ndarray], weight: np.ndarray) -> np.ndarray:
    stack = np.zeros((len(courses), padded_length(len(weight))))
    for row, course in zip(stack, courses, strict=True):
        np.multiply(course, weight, out=row[: len(weight)])
    np.nan_to_num(stack, copy=False)
    return stack


def _projected(stack: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """The rows without what the basis explains of them (plain least squares).

    What is left of a column is small beside it; only so do its products keep their digits.
    """
    before = np.einsum("kn,kn->k", stack, stack)
    stack -= (stack @ basis.T) @ basis
    stack[np.einsum("kn,kn->k", stack, stack) < ROUNDING * before] = 0.0
    return stack


def _at_unit_size(stack: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Transformed rows in single precision, each divided by its root mean square."""
    size = np.sqrt(np.einsum("kn,kn->k", stack, stack) / stack.shape[1])
    size[size == 0] = 1.0
    return transformed((stack / size[:, None]).astype(np.float32)), size


def _products(some: np.ndarray, others: np.ndarray, bands: Bands) -> np.ndarray:
    """(bands, k, m) products of rows (k, n) and (m, n) within each band."""
    pairs = zip(bands.edges[:-1], bands.edges[1:], strict=True)
    return np.stack([some[:, a:b] @ others[:, a:b].T for a, b in pairs]).astype(float)


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
    whole = normal * scale[:, None] * scale + np.diag((scale / pool.half) ** 2)
    return System(whole, right * scale, scale, misfit)


def residuals(pool: Pool, found: Sequence[int], noises: Sequence[Noise] | None) -> list[np.ndarray]:
    """For each channel what the standard's model and the found parameters leave, transformed (n,).

    noises: by which they are fitted; without them every coefficient counts the same.
    """
    return [_left(pool, number, found, noises).course for number in range(len(pool.channels))]


def noises_of(
    pool: Pool, found: Sequence[int], noises: Sequence[Noise] | None
) -> tuple[Noise, ...]:
    """The noise of what the standard's model and the found parameters leave, triad by triad."""
    made = [Noise(1.0, 0.0)] * len(pool.channels)
    for triad in TRIADS:
        alive = [c for c in triad if pool.channels[c] is not None]
        floors = [pool.observed.rounding[c] for c in alive]
        lefts = [_left(pool, c, found, noises) for c in alive]
        for c, noise in zip(alive, noises_of_triad(lefts, pool.bands, floors), strict=True):
            made[c] = noise
    return tuple(made)


def _left(pool: Pool, number: int, found: Sequence[int], noises: Sequence[Noise] | None) -> Left:
    channel = pool.channels[number]
    if channel is None:
        return Left(np.zeros(0), np.ones(0))
    courses = [pool.columns[p][number] for p in found if number in pool.columns[p]]
    columns = channel.base
    if courses:
        more = transformed(_weighed(courses, pool.observed.weight[:, number]))
        columns = np.vstack([columns, more])
    level = np.ones(len(channel.reading))
    if noises is not None:
        variance = noises[number].variance(pool.bands.frequency)
        level = np.repeat(1.0 / variance, pool.bands.sizes)
    solved = inverse((columns * level) @ columns.T)
    values = solved @ ((columns * level) @ channel.reading)
    taken = ((solved @ columns) * columns).sum(axis=0) * level
    by_band = np.add.reduceat(taken, pool.bands.edges[:-1]) / pool.bands.sizes
    return Left(channel.reading - values @ columns, 1.0 - by_band)
