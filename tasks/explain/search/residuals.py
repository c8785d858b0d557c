"""Residuals of the standard's model with some parameters of a design, and their noise."""

from collections.abc import Sequence

import numpy as np

from tasks.explain.channels import TRIADS
from tasks.explain.search.design import BandedDesign
from tasks.explain.whitening import (
    ChannelResidual,
    Noise,
    in_band,
    triad_noises,
    weighted,
)
from tasks.model.regression import inverse

UNIT_NOISE = Noise(1.0, 0.0)  # by which every coefficient counts the same


def residuals(
    design: BandedDesign, members: Sequence[int], noises: Sequence[Noise]
) -> list[ChannelResidual]:
    """For each channel what the standard's model and some parameters leave.

    members: numbers of the parameters. noises: by which they are fitted.
    """
    return [_residual(design, number, members, noise) for number, noise in enumerate(noises)]


def residual_noises(
    design: BandedDesign, members: Sequence[int], noises: Sequence[Noise]
) -> tuple[Noise, ...]:
    """The noise of what the standard's model and some parameters leave, triad by triad."""
    found = [UNIT_NOISE] * len(design.channels)
    left = residuals(design, members, noises)
    for triad in TRIADS:
        recorded = [c for c in triad if design.channels[c] is not None]
        floors = [design.blocks.floor[c] for c in recorded]
        estimates = triad_noises([left[c] for c in recorded], design.bands, floors)
        for c, noise in zip(recorded, estimates, strict=True):
            found[c] = noise
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
        more = in_band(weighted(signals, design.blocks.weight[:, number]), design.blocks)
        columns = np.vstack([columns, more])
    level = 1.0 / noise.of_coefficients(design.bands)
    solved = inverse((columns * level) @ columns.T)
    values = solved @ ((columns * level) @ channel.reading)
    taken = ((solved @ columns) * columns).sum(axis=0) * level
    by_band = np.add.reduceat(taken, design.bands.edges[:-1]) / design.bands.sizes
    return ChannelResidual(channel.reading - values @ columns, 1.0 - by_band)
