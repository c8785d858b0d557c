"""How uncertain what findings add to the readings is, by each parameter that was taken off."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.determined import DeterminedModel, DeterminedParameter
from tasks.explain.evidence.si_units import unit_of
from tasks.explain.explanation import Finding


@dataclass(frozen=True)
class UncertainInput:
    """A parameter of a finding; place: its row of the determined model's covariance, if any.

    whole: (n, 6) the change of the readings of a finding that no term makes; None by the model.
    """

    finding: Finding
    parameter: FoundParameter
    place: int | None = None
    whole: np.ndarray | None = None

    def change(self, determined: DeterminedModel | None) -> np.ndarray:
        """(n, 6) by which the readings grow with it, by its standard uncertainty."""
        if self.whole is not None:
            return self.whole
        assert determined is not None
        assert self.place is not None
        return determined.change(self.place)


def uncertain_inputs(
    findings: Sequence[Finding], determined: DeterminedModel | None
) -> list[UncertainInput]:
    """What of some findings is uncertain: the fitted parameters of those that terms make.

    Physics that is known beforehand has none: its parameters are a check, and were not used. What
    no term makes is as uncertain as its parameters are as a whole.
    """
    every = list[UncertainInput]()
    for finding in findings:
        if determined is None or not finding.terms:
            every += _as_a_whole(finding)
            continue
        every += [
            UncertainInput(finding, in_si(one), one.place)
            for one in determined.parameters(finding.terms)
            if one.place is not None and one.u > 0.0
        ]
    return every


def correlation_of(
    inputs: Sequence[UncertainInput], determined: DeterminedModel | None
) -> np.ndarray:
    """(m, m) of some inputs; what no term makes goes with nothing."""
    correlation = np.eye(len(inputs))
    placed = [(n, one.place) for n, one in enumerate(inputs) if one.place is not None]
    if determined is not None and placed:
        rows, places = np.array(placed).T
        correlation[np.ix_(rows, rows)] = determined.correlation[np.ix_(places, places)]
    return correlation


def in_si(one: DeterminedParameter) -> FoundParameter:
    """A parameter that was taken off, as it is told."""
    return FoundParameter(
        name=one.parameter.name, value=one.value, unit=unit_of(one.parameter), u=one.u
    )


def _as_a_whole(finding: Finding) -> Iterator[UncertainInput]:
    """The contribution times the largest relative uncertainty of parameters of one unit."""
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
