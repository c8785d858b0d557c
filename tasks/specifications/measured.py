"""One element of an item before its budget: a value, and what the data alone say of it."""

import math
from dataclasses import dataclass, replace

import numpy as np

from tasks.specifications.evidence import Evidence
from tasks.specifications.parts import Excess
from tasks.uncertainty.budget import Contribution, observed
from tasks.uncertainty.degrees_of_freedom import type_a_dof
from tasks.uncertainty.type_b import resolution

NO_EXCESS = Excess()


@dataclass(frozen=True)
class Measured:
    """A value, the lines of its budget found so far, and what Appendix A adds up to its u₃.

    lines: of the data first (type A, the unit's resolution), then those of the equipment, with
    sensitivities in the unit of the value per their own; no unit: that of the value.
    repeated: standard uncertainties, each as if its position alone gave the result; empty: the
    type A line itself is the repeatability. NaN: not determined.
    """

    value: float
    lines: tuple[Contribution, ...] = ()
    repeated: tuple[float, ...] = ()

    @property
    def has_uncertainty(self) -> bool:
        """Whether there is a value, and every line of its budget is known."""
        sizes = (line.quantity.u * line.sensitivity for line in self.lines)
        return math.isfinite(self.value) and all(map(math.isfinite, sizes))

    def scaled(self, factor: float) -> "Measured":
        """The same in another unit."""
        return Measured(
            self.value * factor,
            tuple(line.scaled(factor) for line in self.lines),
            tuple(abs(factor) * u for u in self.repeated),
        )

    def with_lines(self, *more: Contribution) -> "Measured":
        """With further lines in its budget."""
        return replace(self, lines=(*self.lines, *more))

    def lines_in(self, unit: str) -> tuple[Contribution, ...]:
        """The lines, those of the data in the value's unit with sensitivity 1."""
        return tuple(line if line.quantity.unit else _own(line, unit) for line in self.lines)


def _own(line: Contribution, unit: str) -> Contribution:
    u = line.quantity.u * abs(line.sensitivity)
    return Contribution(replace(line.quantity, u=u, unit=unit), 1.0)


UNDETERMINED = Measured(float("nan"))


def measured(
    evidence: Evidence, channel: int, weights: np.ndarray, excess: Excess = NO_EXCESS
) -> Measured:
    """o·U for one channel: its value, its type A line and, where the step is coarse, that too.

    weights: o (n,) of all segment means, in the unit of the result per that of the channel. Where
    the points scatter more than noise and rounding together, both are one line with the scatter
    seen, and the degrees of freedom of the residuals.
    """
    used = np.flatnonzero(weights)
    o, block = weights[used], np.ix_(used, used)
    value = float(o @ evidence.means[used, channel])
    if not math.isfinite(value):
        return UNDETERMINED
    noise = float(o @ evidence.noise_covariance(channel)[block] @ o)
    rounding = float(o @ evidence.rounding_covariance(channel)[block] @ o)
    if excess.factor > 1.0:
        u = excess.factor * np.sqrt(max(noise + rounding, 0.0))
        return Measured(value, (observed(float(u), "", excess.dof),))
    dof = type_a_dof(weights, evidence.segments, evidence.noise, channel, noise)
    lines: tuple[Contribution, ...] = (observed(float(np.sqrt(max(noise, 0.0))), "", dof),)
    if rounding > 0.0:
        lines = (*lines, resolution(float(np.sqrt(3.0 * rounding)), "", 1.0))
    return Measured(value, lines)


def u_of_means(evidence: Evidence, channel: int, weights: np.ndarray) -> np.ndarray:
    """Standard uncertainties (m,) of m combinations (m, n) of one channel's means, data only."""
    variance = np.einsum("mi,ij,mj->m", weights, evidence.covariance(channel), weights)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))
