"""Whether a finding may be named: plausible, the same everywhere, and seen in every channel.

A name stands where each parameter with its U reaches its plausible range and one of them at
least is larger than its U; where they are the same in all parts of the recording; and where every
channel that its equation touches is predicted better on cells that the fit did not use, and none
worse.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tasks.explain.channels import EVERY
from tasks.explain.evidence.cells import scatter_cells
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.homogeneity import PartwiseEstimate, partitions, partwise
from tasks.explain.evidence.lookalikes import (
    SIZE,
    Examined,
    jump_at_one_end,
    loops_both_ways,
    made_by_placing,
    swings,
    unseen_turning,
)
from tasks.explain.explanation import UNNAMED, Refusal
from tasks.explain.odds import COVERAGE
from tasks.explain.search.candidates import columns_of
from tasks.model.regression import inverse

UNLIKE = 1e-3  # p value, corrected, from which on the parts of a recording are not alike
MATERIAL = 0.25  # of a finding's amplitude: parts that differ by less are one law, and u covers it
TOUCHED = 25.0  # chi-squared that a finding adds to a channel it materially touches
MIN_TOUCHED = 0.02  # of what it adds to all channels
TOLERATED = 4.5  # nats that a channel may lose by chance: 3·√a − a/2 at its largest, a added


@dataclass(frozen=True)
class Scrutiny:
    """A finding tested against the parts and channels of the recording and the plausible range.

    homogeneity_p: corrected for the number of partitions; None if none determines it. u: (k,)
    standard uncertainties of its own columns, widened by the residual and the differences between
    parts.
    """

    homogeneity_p: float | None
    u: np.ndarray
    refusal: Refusal | None

    @classmethod
    def of(cls, evidence: Evidence, number: int) -> "Scrutiny":
        group = evidence.groups[number]
        own, values = evidence.own[number]
        u = evidence.u(number)
        if group.random or group.absorbed_by or not own:
            return cls(None, u, None)
        apart = list(_estimated_apart(evidence, number))
        p = min((1.0, *(len(apart) * one.p for one in apart))) if apart else None
        unlike = [one for one in apart if len(apart) * one.p < UNLIKE]
        spread = np.max([np.zeros(len(own)), *(one.spread for one in unlike)], axis=0)
        u = np.hypot(u, spread)
        if group.name == UNNAMED:
            return cls(p, u, None)
        one = Examined(evidence, number, values, u)
        refusal = (
            _implausible(one)
            or _inhomogeneous(one, unlike)
            or _channel_worse(one)
            or _undetermined(one)
            or unseen_turning(one)
            or made_by_placing(one)
            or jump_at_one_end(one)
            or loops_both_ways(one)
            or swings(one)
        )
        return cls(p, u, refusal)


def _estimated_apart(evidence: Evidence, number: int) -> Iterator[PartwiseEstimate]:
    """The finding's parameters in the parts of every partition that determines them."""
    scatter, blocks = evidence.scatter, evidence.fit.blocks
    places, own = scatter.determined(number), scatter.own[number]
    if not len(places):
        return
    information = scatter.information_by_cell(number)
    for partition, parts in partitions(blocks, scatter_cells(blocks), information):
        one = partwise(scatter.cells, own[places], scatter.prior, scatter.values, partition, parts)
        if one is not None:
            yield one.among(places, len(own))


def _implausible(one: Examined) -> Refusal | None:
    """Where a parameter lies beyond its plausible range by more than its U, the furthest."""
    furthest: tuple[float, Refusal] | None = None
    for k, (parameter, value, u) in enumerate(zip(one.parameters, one.values, one.u, strict=True)):
        value = float(value)
        if parameter is SIZE:
            value += float(one.evidence.scatter.change(one.number)[0])
        low, high = parameter.plausible
        limit = high if value > high else low
        if low - COVERAGE * u <= value <= high + COVERAGE * u:
            continue
        off = abs(value - limit) / (high - low)
        if furthest is None or off > furthest[0]:
            furthest = off, one.refused("implausible", k, value, limit)
    return furthest and furthest[1]


def _inhomogeneous(one: Examined, unlike: list[PartwiseEstimate]) -> Refusal | None:
    """Where parts of the recording differ materially, those that differ the most."""
    material = [each for each in unlike if each.differing > MATERIAL]
    if not material:
        return None
    worst = max(material, key=lambda each: each.differing)
    k = int(np.argmax(worst.spread / np.maximum(one.evidence.u(one.number), 1e-300)))
    parameter, sizes = one.parameters[k], worst.values[:, k]
    return Refusal(
        "inhomogeneous", one.group.name, parameter.name, parameter.si,
        smallest=float(np.nanmin(sizes)), largest=float(np.nanmax(sizes)), parts=worst.partition,
    )  # fmt: skip


def _channel_worse(one: Examined) -> Refusal | None:
    """Where a channel that it touches does not gain, or one that its equation has loses."""
    gains, added = one.evidence.channel_gains(one.number), one.evidence.added_power(one.number)
    motion = one.evidence.fit.blocks.motion
    columns = (column for term in one.group.terms for column in columns_of(term, motion))
    of_equation = np.isin(EVERY, list({channel for column in columns for channel in column}))
    gains = np.where(of_equation, gains, 0.0)
    tolerated = max(TOLERATED, MIN_TOUCHED * float(gains.max()))
    touched = of_equation & (added > TOUCHED) & (added > MIN_TOUCHED * added.sum())
    worse = np.flatnonzero((touched & (gains <= 0.0)) | (gains < -tolerated))
    if not len(worse):
        return None
    channel = int(worse[gains[worse].argmin()])
    value = float(gains[channel])
    return Refusal("channel_worse", one.group.name, value=value, unit="nat", channel=channel)


def _undetermined(one: Examined) -> Refusal | None:
    """The clearest parameter, if none exceeds its U, nor do all mutually compensating ones
    together.
    """
    evidence, u = one.evidence, one.u
    off = one.values - np.array([0.0 if p is SIZE else p.nominal for p in one.parameters])
    joint = float(off @ inverse(evidence.correlation(one.number) * u[:, None] * u) @ off)
    clear = np.abs(off) / np.maximum(COVERAGE * u, 1e-300)
    k = int(clear.argmax())
    if clear[k] > 1.0 or joint > COVERAGE**2 * len(u):
        return None
    return one.refused("undetermined", k, float(one.values[k]), COVERAGE * float(u[k]))
