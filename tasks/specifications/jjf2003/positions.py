"""The positions of 7.2.2.1: axes up, headings, averages U_i; their fit by eq. (7) and (10)."""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from schemas.recording import AXES, UPS
from schemas.text import Remark
from tasks.segments.summarise import SegmentMean
from tasks.specifications.error_sources import EquipmentErrors
from tasks.specifications.estimate import MATRIX, Estimate, Estimates, fit_means, u_of_means
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import message, remark

Positions = dict[str, tuple[int, ...]]  # rests by axis up

SERVES: dict[str, Callable[[SegmentMean], bool]] = {
    "gyro": lambda segment: segment.has_gyro,
    "accel": lambda segment: segment.has_accel,
}
BIAS = 3  # column of eq. (7), (10) after the three inputs
ROUNDING = 1e-9  # weights that are none


def input_matrix(average: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Transposed Ā of 7.2.2.2: a row (aₓ, a_y, a_z, 1) in local g for each position.

    average: (positions, n) of the segments; up: (n, 3) verticals in the unit's axes.
    """
    return np.column_stack([average @ np.nan_to_num(up), np.ones(len(average))])


def usable_positions(evidence: ClauseEvidence, triad: Literal["gyro", "accel"]) -> Positions:
    """The positions with at least one rest of the triad, by axis up, in the clause's order."""
    serves = SERVES[triad]
    usable = {
        up: tuple(i for i in evidence.positions[up] if serves(evidence.segments[i])) for up in UPS
    }
    return {up: indices for up, indices in usable.items() if indices}


def _averages(evidence: ClauseEvidence, positions: Positions) -> np.ndarray:
    """Operator (positions, segments) that gives U_i, the mean over headings (7.2.2.1 a).

    Every heading counts once. Where some are 180° apart, only those pairs count: a third
    heading would bring back what the pair cancels.
    """
    operator = np.zeros((len(positions), len(evidence.segments)))
    for row, indices in enumerate(positions.values()):
        headings = _headings(evidence, indices)
        counted = [h for h in headings if _opposite(h, headings)] or list(headings)
        for heading in counted:
            same = headings[heading]
            operator[row, same] = 1.0 / len(counted) / len(same)
    return operator


def _headings(evidence: ClauseEvidence, indices: tuple[int, ...]) -> dict[float | None, list[int]]:
    """The rests of a position by heading, degrees modulo 360 to the nearest one."""
    by_heading: dict[float | None, list[int]] = {}
    for i in indices:
        turn = evidence.segments[i].segment.turn_deg
        heading = None if turn is None else float(round(turn) % 360)
        by_heading.setdefault(heading, []).append(i)
    return by_heading


def _opposite(heading: float | None, headings: Collection[float | None]) -> bool:
    """Whether another heading lies 180° from this one, within 1°."""
    if heading is None:
        return False
    known = [other for other in headings if other is not None]
    return any(abs((heading - other) % 360 - 180) <= 1 for other in known)


def is_paired(evidence: ClauseEvidence, indices: tuple[int, ...]) -> bool:
    """Whether a position was held at two headings 180° apart, as 7.2.2.1 a) asks."""
    headings = _headings(evidence, indices)
    return any(_opposite(heading, headings) for heading in headings)


def position_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Conditions of 7.2.2.1 a): six axes up, each at two headings, for each triad recorded."""
    absent: dict[tuple[str, ...], list[str]] = {}
    single: dict[tuple[str, ...], list[str]] = {}
    for triad in _recorded(evidence):
        positions = usable_positions(evidence, triad)
        absent.setdefault(tuple(up for up in UPS if up not in positions), []).append(triad)
        alone = (up for up, rests in positions.items() if not is_paired(evidence, rests))
        single.setdefault(tuple(alone), []).append(triad)
    for code, by_ups in (("positions_missing", absent), ("one_heading", single)):
        for ups, triads in by_ups.items():
            if ups:
                which = message(f"jjf2003-triad-{'-and-'.join(triads)}")
                name = f"jjf2003-{code.replace('_', '-')}"
                text = message(name, ups=", ".join(ups), triads=which)
                yield remark(code, text, blocks_pass=True)


def _recorded(evidence: ClauseEvidence) -> tuple[Literal["gyro", "accel"], ...]:
    """The triads present in any segment; both if there is none."""
    known: tuple[Literal["gyro", "accel"], ...] = ("gyro", "accel")
    return tuple(t for t in known if any(map(SERVES[t], evidence.segments))) or known


@dataclass(frozen=True)
class PositionFit:
    """The positions of one triad, solved.

    estimates: (3, 4), the matrix and the bias column of the three channels, unit of the channel.
    factors: (3,) by how much each channel scatters more than noise and equipment.
    """

    estimates: tuple[tuple[Estimate, ...], ...]
    factors: np.ndarray

    @property
    def by_element(self) -> tuple[Estimates, Estimates]:
        """Matrix and bias."""
        matrix = {AXES[i] + AXES[j]: self.estimates[i][j] for i, j in MATRIX}
        return matrix, {axis: self.estimates[i][BIAS] for i, axis in enumerate(AXES)}


def fit_positions(
    evidence: ClauseEvidence,
    up: np.ndarray,
    positions: Positions,
    first: int,
    errors: EquipmentErrors,
) -> PositionFit:
    """Eq. (7), (10) for channels first, first+1, first+2; up: (n, 3) verticals."""
    average = _averages(evidence, positions)
    design = input_matrix(average, up)
    rows, factors = [], np.ones(3)
    for i in range(3):
        fit = fit_means(evidence, first + i, design, average, errors)
        factors[i] = fit.excess.factor
        u = fit.excess.factor * u_of_means(evidence, first + i, average)
        counted = np.abs(fit.solution.operator) > ROUNDING
        rows.append(
            tuple(
                replace(estimate, repeated=tuple(map(float, u[c])))
                for estimate, c in zip(fit.estimates, counted, strict=True)
            )
        )
    return PositionFit(tuple(rows), factors)
