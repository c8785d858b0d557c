"""What one clause contributes to a calibration."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from scipy.special import chdtrc

from schemas.calibration import Elements, Item, Remark
from schemas.recording import AXES
from tasks.specifications.linear import Solution

DEG = float(np.degrees(1.0))  # degrees in a radian, where something is printed
K_FACTOR = 2.0  # both specifications expand with k = 2
NOMINAL_GRAVITY = 9.8  # m/s², for what a tilt does where no gravity is told
EXCESS_LEVEL = 0.01  # scatter that noise alone would give in one case of a hundred
BLOCKING_EXCESS = 10.0  # beyond it no larger uncertainty makes up for what is wrong

OFF_DIAGONAL = tuple((i, j) for i in range(3) for j in range(3) if i != j)
MATRIX = tuple((i, j) for i in range(3) for j in range(3))


@dataclass(frozen=True)
class Part:
    """Items of a clause, reasons for what is missing (English, Chinese), and remarks."""

    items: dict[str, Item] = field(default_factory=dict)
    unavailable: dict[str, tuple[str, str]] = field(default_factory=dict)
    remarks: tuple[Remark, ...] = ()


def joined(parts: Iterable[Part]) -> Part:
    """Several clauses as one: their items, their reasons, their remarks in the same order."""
    every = tuple(parts)
    return Part(
        {name: item for part in every for name, item in part.items.items()},
        {name: reason for part in every for name, reason in part.unavailable.items()},
        tuple(remark for part in every for remark in part.remarks),
    )


def elements(values: np.ndarray, which: tuple[tuple[int, int], ...] | None = None) -> Elements:
    """Named elements of a (3,) vector (x, y, z) or a (3, 3) matrix (xy: x reads, y is input).

    Not a number becomes null.
    """
    named: dict[str, float]
    if values.ndim == 1:
        named = dict(zip(AXES, values, strict=True))
    else:
        named = {AXES[i] + AXES[j]: values[i, j] for i, j in which or MATRIX}
    return {name: float(value) if np.isfinite(value) else None for name, value in named.items()}


@dataclass(frozen=True)
class Excess:
    """How much more than their noise points scatter, 1 if they do not, and their dof."""

    factor: float = 1.0
    dof: float = math.inf


def excess_scatter(
    solution: Solution, design: np.ndarray, readings: np.ndarray, covariance: np.ndarray
) -> Excess:
    """Factor by which residuals exceed what the noise explains (Birge ratio), 1 if they do not.

    The residuals' own covariance follows from the readings' covariance; a ratio counts only
    when noise alone would reach it in fewer than one case of a hundred. Its degrees of freedom
    are then those of the residuals, n − p.
    """
    maker = np.eye(len(readings)) - design @ solution.operator
    degrees = len(readings) - np.linalg.matrix_rank(design)
    if degrees < 1 or not np.isfinite(readings).all():
        return Excess()
    residuals = maker @ readings
    spread = maker @ covariance @ maker.T
    square = float(residuals @ np.linalg.pinv(spread, rcond=1e-6, hermitian=True) @ residuals)
    if chdtrc(degrees, square) < EXCESS_LEVEL:
        return Excess(float(np.sqrt(square / degrees)), float(degrees))
    return Excess()
