"""The solution of eq. (7) and (10) for the positions of one triad."""

import math
from dataclasses import dataclass, replace

import numpy as np

from schemas.recording import AXES
from tasks.specifications.estimate import Estimate, fit_means, u_of_means
from tasks.specifications.evidence import Evidence
from tasks.specifications.jjf2003.positions import averages, input_matrix
from tasks.specifications.linear import Solution, solve
from tasks.uncertainty.type_b import Weights

BIAS = 3  # column of eq. (7), (10) after the three inputs
ROUNDING = 1e-9  # weights that are none


@dataclass(frozen=True)
class PositionFit:
    """The positions of one triad, solved.

    estimates: (3, 4), the matrix and the bias column of the three channels, unit of the channel.
    factors: (3,) by how much each channel scatters more than its noise.
    solution: of the positions; average: (positions, segments), U_i of the segment means.
    ups: the axis up of each position. mounted_once: whether the fixture held them all alike.
    """

    estimates: tuple[tuple[Estimate, ...], ...]
    factors: np.ndarray
    solution: Solution
    average: np.ndarray
    ups: tuple[str, ...]
    mounted_once: bool

    def weights(self, column: int, lying: str | None = None) -> Weights:
        """Weights of rests, faces and mountings in a column; lying: where that axis is level."""
        row = self.solution.operator[column]
        level = np.array([lying is None or up[1] != lying for up in self.ups])
        faces = np.where(level, row, 0.0)
        mountings = faces
        if self.mounted_once:
            mountings = faces @ input_matrix(self.ups)[:, :BIAS]
        return Weights(faces @ self.average, faces, mountings)

    def across(self, i: int, j: int) -> float:
        """√Σ of the squared elements of row i for the other inputs k ≠ j, where known."""
        others = [self.estimates[i][k].value for k in range(3) if k != j]
        return math.hypot(*(value for value in others if math.isfinite(value)))


def fit_positions(
    evidence: Evidence, positions: dict[str, tuple[int, ...]], first: int, tilts: float = 0.0
) -> PositionFit:
    """Eq. (7), (10) for channels first, first+1, first+2.

    tilts: variance, unit of the channel squared, that errors of table and fixture give the
    reading of a position in which the channel's axis lies level; they are no excess of scatter.
    """
    design, average = input_matrix(tuple(positions)), averages(evidence, positions)
    rows, factors = [], np.ones(3)
    for i in range(3):
        level = np.diag([up[1] != AXES[i] for up in positions])
        fit = fit_means(evidence, first + i, design, average, tilts * level)
        factors[i] = fit.excess.factor
        u = fit.excess.factor * u_of_means(evidence, first + i, average)
        counted = np.abs(fit.solution.operator) > ROUNDING
        rows.append(
            tuple(
                replace(estimate, repeated=tuple(map(float, u[c])))
                for estimate, c in zip(fit.estimates, counted, strict=True)
            )
        )
    solution = solve(design)
    ups = tuple(positions)
    return PositionFit(tuple(rows), factors, solution, average, ups, evidence.mounted_once)
