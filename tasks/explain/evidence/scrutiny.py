"""Whether a finding may be named: plausible, the same everywhere, and seen in every channel.

A name stands where each parameter with its U reaches its plausible range and one of them at
least is larger than its U; where they are the same in all parts of the recording; and where every
channel that its equation touches is predicted better on cells that the fit did not use, and none
worse.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.stats import f as fisher

from tasks.explain.evidence.cells import CellEquations, cell_influence, scatter_cells
from tasks.explain.evidence.evidence import Evidence, FindingGroup
from tasks.explain.explanation import (
    COVERAGE,
    EVERY,
    TRIADS,
    UNNAMED,
    Partition,
    Refusal,
    RefusalKind,
)
from tasks.explain.inputs.blocks import Blocks
from tasks.explain.search.candidates import columns_of
from tasks.model.fit import inverse
from tasks.model.term import Parameter

# Whether a finding's parameters agree in every part of a recording, as a law requires.
#
# The parameters are estimated apart in each part, all else in common, and compared (Wald's test)
# by a covariance that holds in a wrong model: the model's correlations, and the variance that the
# cells of each part show by their scatter where that is larger.

DETERMINED = 0.05  # of the whole recording's information on a parameter: less determines nothing
MIN_DEGREES = 2.0  # of the scatter of the cells


@dataclass(frozen=True)
class PartwiseEstimate:
    """Parameters estimated apart in the parts of one partition.

    values: (parts, k), NaN where a part does not determine them. p: that they are the same.
    spread: (k,) standard deviation between the parts beyond what noise makes. differing: the share
    of the finding's amplitude in the recording by which the parts differ beyond noise.
    """

    partition: Partition
    values: np.ndarray
    p: float
    spread: np.ndarray
    differing: float

    def among(self, places: np.ndarray, count: int) -> "PartwiseEstimate":
        """The same where the parameters stand at some places (k,) among `count`."""
        values, spread = np.full((len(self.values), count), np.nan), np.zeros(count)
        values[:, places], spread[places] = self.values, self.spread
        return replace(self, values=values, spread=spread)


def partwise(
    equations: CellEquations,
    own: np.ndarray,
    prior: np.ndarray,
    values: np.ndarray,
    partition: Partition,
    parts: np.ndarray,
) -> PartwiseEstimate | None:
    """The estimate of the columns `own` (k,) in each part; None where fewer than two have any.

    prior, values: (q,) of all columns. parts: (parts, cells, 6) bool.
    """
    count, k = len(prior), len(own)
    others = np.setdiff1d(np.arange(count), own)
    rest, size = len(others), len(others) + k * len(parts)
    normal, right = np.zeros((equations.cells, size, size)), np.zeros((equations.cells, size))
    for number, part in enumerate(parts):
        place = np.empty(count, int)
        place[others] = np.arange(rest)
        place[own] = rest + k * number + np.arange(k)
        of_part, of_right = equations.normal(part)
        normal[:, place[:, None], place] += of_part
        right[:, place] += of_right
    apart = np.arange(rest, size)
    everywhere = np.concatenate([others, *[own] * len(parts)])
    influence, change = cell_influence(normal, right, apart, prior[everywhere], values[everywhere])
    model = np.diag(influence.covariance)
    information = np.divide(1.0, model, out=np.zeros(len(model)), where=model > 0)
    information = information.reshape(len(parts), k)
    known = information > DETERMINED * information.sum(axis=0)
    known &= known.sum(axis=0) > 1
    if not known.any():
        return None
    variance = np.maximum(model, np.diag(influence.robust_covariance))
    estimates = values[own] + change.reshape(len(parts), k)
    root = np.sqrt(np.divide(variance, model, out=np.ones(len(model)), where=model > 0))
    covariance = influence.covariance * root[:, None] * root
    contrasts = _contrasts(known)
    differences = contrasts @ estimates.ravel()
    distance = differences @ inverse(contrasts @ covariance @ contrasts.T) @ differences
    degrees = max(MIN_DEGREES, float(influence.effective_cells[known.ravel()].mean()) - 1.0)
    return PartwiseEstimate(
        partition,
        np.where(known, estimates, np.nan),
        float(fisher.sf(distance / len(differences), len(differences), degrees)),
        *_beyond_noise(estimates, known, variance.reshape(known.shape), information),
    )


def _contrasts(known: np.ndarray) -> np.ndarray:
    """(m, parts·k) differences of each parameter between parts that determine it."""
    rows = []
    for q in range(known.shape[1]):
        first, *more = np.flatnonzero(known[:, q]).tolist() or [0]
        for part in more:
            row = np.zeros(known.shape)
            row[first, q], row[part, q] = 1.0, -1.0
            rows.append(row.ravel())
    return np.array(rows)


def _beyond_noise(
    estimates: np.ndarray, known: np.ndarray, variance: np.ndarray, information: np.ndarray
) -> tuple[np.ndarray, float]:
    """Standard deviation (k,) between the parts beyond noise, and the share of the amplitude."""
    weight = np.where(known, information, 0.0)
    total = np.maximum(weight.sum(axis=0), 1e-300)
    mean = (weight * estimates).sum(axis=0) / total
    off = np.where(known, (estimates - mean) ** 2, 0.0)
    noise = np.where(known, variance, 0.0)
    parts = np.maximum(known.sum(axis=0), 2)
    expected = noise.sum(axis=0) * (parts - 1) / parts
    spread = np.sqrt(np.maximum(off.sum(axis=0) - expected, 0.0) / (parts - 1))
    left = float((weight * (off - noise)).sum())
    amplitude = float((total * mean**2)[known.any(axis=0)].sum())
    return spread, float(np.sqrt(max(left, 0.0) / max(amplitude, 1e-300)))


def partitions(
    blocks: Blocks, cells: np.ndarray, information: np.ndarray
) -> Iterator[tuple[Partition, np.ndarray]]:
    """What divides the recording, and its parts (parts, cells, 6) bool.

    cells: (n,) number of each row's cell. information: (cells,) that each has on the parameters,
    by which time and rate are halved.
    """
    count = len(information)
    edges = np.searchsorted(cells, np.arange(count + 1))
    rate = np.linalg.norm(np.nan_to_num(blocks.motion.rate), axis=1)
    used = np.asarray((blocks.weight > 0).any(axis=1))
    speed, upward = np.zeros(count), np.zeros((count, 3))
    for n, (start, stop) in enumerate(pairwise(edges)):
        rows = slice(start, stop)
        turns = rate[rows] ** 2 * used[rows]
        speed[n] = np.sqrt(turns.sum() / max(1, int(used[rows].sum())))
        upward[n] = np.abs(np.nan_to_num(blocks.motion.up[rows])).sum(axis=0)
    first = _first_half(np.arange(count), information)
    yield "time", _of_cells(first, ~first)
    slow = _first_half(np.argsort(speed, kind="stable"), information)
    yield "rate", _of_cells(slow, ~slow)
    known = upward.any(axis=1)
    yield "up", _of_cells(*(known & (upward.argmax(axis=1) == axis) for axis in range(3)))
    channels = np.array(EVERY)
    every = np.ones((count, 1), bool)
    yield "triad", np.stack([every & np.isin(channels, triad) for triad in TRIADS])
    yield "axis", np.stack([every & (channels % 3 == axis) for axis in range(3)])


def _first_half(order: np.ndarray, information: np.ndarray) -> np.ndarray:
    """(cells,) bool: those that come first in an order and have half of the information."""
    share = np.empty(len(order))
    share[order] = np.cumsum(information[order]) - 0.5 * information[order]
    return np.asarray(share <= 0.5 * information.sum())


def _of_cells(*parts: np.ndarray) -> np.ndarray:
    return np.stack([np.repeat(part[:, None], len(EVERY), axis=1) for part in parts])


UNLIKE = 1e-3  # p value, corrected, from which on the parts of a recording are not alike
MATERIAL = 0.25  # of a finding's amplitude: parts that differ by less are one law, and u covers it
TOUCHED = 25.0  # chi-squared that a finding adds to a channel it materially touches
MIN_TOUCHED = 0.02  # of what it adds to all channels
TOLERATED = 4.5  # nats that a channel may lose by chance: 3·√a − a/2 at its largest, a added
KNOWN_SIZE = 0.3  # by which physics that is known beforehand may differ from what is known
SIZE = Parameter("size", "size", "1", "1", (1.0 - KNOWN_SIZE, 1.0 + KNOWN_SIZE))
STANDARD_AT_REST = 12  # accelerometers' matrix and bias
RESTING = np.radians(0.1)  # rad/s


@dataclass(frozen=True)
class Examined:
    """A finding by its number in some evidence, with the values and the standard uncertainties
    (k,) of its own columns.
    """

    evidence: Evidence
    number: int
    values: np.ndarray
    u: np.ndarray

    @property
    def group(self) -> FindingGroup:
        return self.evidence.groups[self.number]

    @cached_property
    def parameters(self) -> list[Parameter]:
        """Of each own column; known physics has a size, which is one."""
        return [parameter or SIZE for parameter in self.evidence.parameters(self.number)]

    def refused(self, kind: RefusalKind, k: int, value: float, limit: float) -> Refusal:
        """For the value of its parameter k."""
        parameter = self.parameters[k]
        name, unit = parameter.name, parameter.si
        return Refusal(kind, self.group.name, name, unit, value, limit)


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
        own, u = evidence.own[number], evidence.u(number)
        if group.random or group.absorbed_by or not len(own):
            return cls(None, u, None)
        apart = list(_estimated_apart(evidence, number))
        p = min((1.0, *(len(apart) * one.p for one in apart))) if apart else None
        unlike = [one for one in apart if len(apart) * one.p < UNLIKE]
        spread = np.max([np.zeros(len(own)), *(one.spread for one in unlike)], axis=0)
        u = np.hypot(u, spread)
        if group.name == UNNAMED:
            return cls(p, u, None)
        one = Examined(evidence, number, evidence.values[own], u)
        refusal = (
            _implausible(one)
            or _inhomogeneous(one, unlike)
            or _channel_worse(one)
            or _undetermined(one)
            or _made_by_placing(one)
        )
        return cls(p, u, refusal)


def _estimated_apart(evidence: Evidence, number: int) -> Iterator[PartwiseEstimate]:
    """The finding's parameters in the parts of every partition that determines them."""
    blocks, cells = evidence.fit.blocks, evidence.cells
    places, own = evidence.determined(number), evidence.own[number]
    if not len(places):
        return
    information = evidence.information_by_cell(number)
    for partition, parts in partitions(blocks, scatter_cells(blocks), information):
        one = partwise(cells, own[places], evidence.prior, evidence.values, partition, parts)
        if one is not None:
            yield one.among(places, len(own))


def _implausible(one: Examined) -> Refusal | None:
    """Where a parameter lies beyond its plausible range by more than its U, the furthest."""
    furthest: tuple[float, Refusal] | None = None
    for k, (parameter, value, u) in enumerate(zip(one.parameters, one.values, one.u, strict=True)):
        value = float(value)
        if parameter is SIZE:
            value += float(one.evidence.by_cells(one.number)[1][0])
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


def _made_by_placing(one: Examined) -> Refusal | None:
    """Where a finding that turns the body has no fewer parameters than the rests leave values."""
    group, blocks, motion = one.group, one.evidence.fit.blocks, one.evidence.fit.blocks.motion
    if motion.axes is not None or motion.tracking is not None:
        return None
    if not any(term.stage == "motion" for term in group.terms):
        return None
    rests = np.linalg.norm(np.nan_to_num(motion.rate, nan=np.inf), axis=1) < RESTING
    placed = len(np.unique(blocks.segment[rests & (blocks.segment >= 0)]))  # each by itself
    if 3 * placed - STANDARD_AT_REST > len(one.evidence.own[one.number]):
        return None
    return Refusal("placed", group.name, value=float(placed))
