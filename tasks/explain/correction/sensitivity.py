"""Uncertainty of the findings' contribution to the readings, by each corrected parameter."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.determined import DeterminedModel
from tasks.explain.events.faults import RANGE_SETTING
from tasks.explain.explanation import UNNAMED, Finding
from tasks.model.term import Column

MANY = 12  # parameters of a finding, from which on the clauses are not asked for each of them
NEGLIGIBLE = 1e-5  # of the square of what they all move
ROUNDING = 1e-12  # of the largest variance


@dataclass(frozen=True)
class UncertainInput:
    """A parameter of a finding, or a direction of several of them.

    step: (q,) of the determined model's covariance, by one standard uncertainty; form: (q,) what
    of the parameters it is, of unit variance. Neither where `whole`: (n, 6) is the change of the
    readings of a finding that no term makes.
    """

    finding: Finding
    parameter: FoundParameter
    step: np.ndarray | None = None
    form: np.ndarray | None = None
    whole: np.ndarray | None = None

    def change(self, determined: DeterminedModel | None) -> np.ndarray:
        """(n, 6) by which the readings grow with it, by its standard uncertainty."""
        if self.whole is not None:
            return self.whole
        assert determined is not None
        assert self.step is not None
        return determined.change(self.step)


def uncertain_inputs(
    findings: Sequence[Finding], determined: DeterminedModel | None, segments: Sequence[slice] = ()
) -> list[UncertainInput]:
    """What of some findings is uncertain: the fitted parameters of those that terms make; of many
    parameters the directions in which they move the means of the segments (rows of them).

    Physics that is known beforehand has none: its parameters are a check, and were not used. What
    no term makes is as uncertain as its parameters are as a whole. Whether what has no name is to
    be corrected for at all is not known, however well its pattern is.
    """
    every = list[UncertainInput]()
    for finding in findings:
        if finding.effect == UNNAMED and not finding.remainder:
            every.append(_of_unknown_cause(finding))
        if determined is None or not finding.terms:
            every += _as_a_whole(finding)
            continue
        placed = [
            (one, one.place)
            for one in determined.parameters(finding.terms)
            if one.place is not None and one.u > 0.0
        ]
        if len(placed) > MANY and segments:
            places = np.array([place for _, place in placed])
            every += principal_directions(finding, determined, places, segments)
            continue
        for one, place in placed:
            unit = np.eye(1, len(determined.u), place)[0]
            every.append(UncertainInput(finding, one.found, one.u * unit, unit / one.u))
    return every


def principal_directions(
    finding: Finding, determined: DeterminedModel, places: np.ndarray, segments: Sequence[slice]
) -> Iterator[UncertainInput]:
    """Independent combinations of a finding's parameters, by how far they move the readings' means
    over the segments; what moves them next to nothing is left out.

    places: (k,) rows of the covariance, shapes left out. segments: rows of the readings.
    """
    places = places[places < int(determined.model.free.sum())]
    covariance = determined.covariance[np.ix_(places, places)]
    values, vectors = np.linalg.eigh(covariance)
    known = values > ROUNDING * values.max()
    root = vectors[:, known] * np.sqrt(values[known])
    means = _segment_means(determined.columns(places), determined.axes, segments)
    moved = np.tensordot(root.T, means, 1)
    moved /= np.maximum(np.linalg.norm(moved, axis=(0, 1), keepdims=True), 1e-300)
    left, sizes, _ = np.linalg.svd(moved.reshape(len(moved), -1), full_matrices=False)
    kept = sizes**2 > NEGLIGIBLE * float((sizes**2).sum())
    inverse_root = vectors[:, known] / np.sqrt(values[known])
    for number, direction in enumerate(left.T[kept], start=1):
        step, form = np.zeros(len(determined.u)), np.zeros(len(determined.u))
        step[places], form[places] = root @ direction, inverse_root @ direction
        named = FoundParameter(name=f"direction {number}", value=0.0, unit="1", u=1.0)
        yield UncertainInput(finding, named, step, form)


def _segment_means(
    columns: Sequence[Column], axes: np.ndarray, segments: Sequence[slice]
) -> np.ndarray:
    """(k, segments·3, 2) means of columns over each segment, by triad."""
    means = np.zeros((len(columns), len(segments), len(axes)))
    for k, column in enumerate(columns):
        for channel, values in column.items():
            filled = np.nan_to_num(values)
            means[k, :, channel] = [filled[rows].mean() for rows in segments]
    by_triad = (means @ axes.T).reshape(len(columns), len(segments), 2, 3)
    return by_triad.transpose(0, 1, 3, 2).reshape(len(columns), -1, 2)


def correlation_of(
    inputs: Sequence[UncertainInput], determined: DeterminedModel | None
) -> np.ndarray:
    """(m, m) of some inputs; what no term makes goes with nothing."""
    correlation = np.eye(len(inputs))
    formed = [(n, one.form) for n, one in enumerate(inputs) if one.form is not None]
    if determined is not None and formed:
        rows, forms = np.array([n for n, _ in formed]), np.array([form for _, form in formed])
        own = forms @ determined.covariance @ forms.T
        np.fill_diagonal(own, 1.0)
        correlation[np.ix_(rows, rows)] = own
    return correlation


def _of_unknown_cause(finding: Finding) -> UncertainInput:
    """Half of its contribution: ± U (k = 2) about the corrected value reaches the uncorrected."""
    share = FoundParameter(name="share", value=1.0, unit="1", u=0.5)
    return UncertainInput(finding, share, whole=0.5 * np.nan_to_num(finding.contribution))


def _as_a_whole(finding: Finding) -> Iterator[UncertainInput]:
    """The contribution times the largest relative uncertainty of parameters of one unit.

    A factor changes what it multiplies, not what it adds: its relative uncertainty is that of the
    whole reading y, of which (c − 1)/c·y is the contribution.
    """
    if finding.effect == RANGE_SETTING:
        (factor,) = finding.parameters
        share = factor.u / (factor.value * (factor.value - 1.0))
        yield UncertainInput(finding, factor, whole=share * finding.contribution)
        return
    by_unit: dict[str, list[FoundParameter]] = {}
    for p in finding.parameters:
        if p.u > 0.0:
            by_unit.setdefault(p.unit, []).append(p)
    relative = [
        (math.hypot(*(p.u for p in some)) / max(math.hypot(*(p.value for p in some)), 1e-300), some)
        for some in by_unit.values()
    ]
    if relative:
        share, some = max(relative, key=lambda pair: pair[0])
        largest = max(some, key=lambda p: abs(p.value))
        whole = largest.model_copy(update={"u": share * abs(largest.value)})
        yield UncertainInput(finding, whole, whole=share * finding.contribution)
