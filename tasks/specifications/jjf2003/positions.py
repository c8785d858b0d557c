"""The positions of 7.2.2.1: axes up, headings, averages U_i; their fit by eq. (7) and (10)."""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from schemas.recording import AXES, UPS
from schemas.text import Remark
from tasks.motion.table import EARTH_RATE
from tasks.segments.summarise import SegmentMean
from tasks.specifications.equipment_errors import EquipmentErrors
from tasks.specifications.estimate import (
    DEG,
    MATRIX,
    MATRIX_ELEMENTS,
    UNDETERMINED,
    ClauseResult,
    Estimate,
    Estimates,
    ItemEstimate,
    diagonal,
    excess_remarks,
    fit_means,
    merged,
    off_diagonal,
    scaled,
    u_of_means,
    undetermined,
)
from tasks.specifications.evidence import ClauseEvidence, earth_rotation_message
from tasks.words import Message, Sayable, clauses, message, remark

Positions = dict[str, tuple[int, ...]]  # rests by axis up

SERVES: dict[str, Callable[[SegmentMean], bool]] = {
    "gyro": lambda segment: segment.has_gyro,
    "accel": lambda segment: segment.has_accel,
}
BIAS = 3  # column of eq. (7), (10) after the three inputs
NO_WEIGHT = 1e-9  # weights that are none


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
        counted = np.abs(fit.solution.operator) > NO_WEIGHT
        rows.append(
            tuple(
                replace(estimate, repeated=tuple(map(float, u[c])))
                for estimate, c in zip(fit.estimates, counted, strict=True)
            )
        )
    return PositionFit(tuple(rows), factors)


# 7.2.2 and 7.2.4: biases, g-sensitivity, accelerometer scale factor and cross coupling.

CLAUSE_GYRO = "JJF 2003-2022, 7.2.2.2 eq. (6)-(8)"
CLAUSE_ACCEL = "JJF 2003-2022, 7.2.4.2 eq. (9)-(11)"
READINGS = ("jjf2003.positions", "jjf2003.input_matrix")


def tumble_items(
    evidence: ClauseEvidence, up: np.ndarray, gyro_k: np.ndarray, errors: EquipmentErrors
) -> ClauseResult:
    """All items of the twelve positions.

    up: (n, 3) vertical of each segment in the unit's axes. gyro_k: (3, 3) scales Earth's rotation,
    NaN where it is not known.
    """
    gyro, accel = usable_positions(evidence, "gyro"), usable_positions(evidence, "accel")
    return merged(
        (
            ClauseResult(remarks=tuple(position_remarks(evidence))),
            _gyro_items(evidence, up, gyro, gyro_k, errors),
            _accel_items(evidence, up, accel, errors),
        )
    )


def _gyro_items(
    evidence: ClauseEvidence,
    up: np.ndarray,
    positions: Positions,
    gyro_k: np.ndarray,
    errors: EquipmentErrors,
) -> ClauseResult:
    """g-sensitivity in (deg/s)/g and bias in deg/s from eq. (8)."""
    evidence = replace(evidence, means=evidence.means - _horizontal(evidence, positions, gyro_k))
    fit = fit_positions(evidence, up, positions, 0, errors)
    matrix, bias = fit.by_element
    corrected, why_not = without_earth(evidence, positions, matrix, gyro_k)
    items = {
        "gyro_bias": ItemEstimate(scaled(bias, DEG), CLAUSE_GYRO, READINGS),
        "gyro_g_sensitivity": ItemEstimate(
            scaled(matrix, DEG), CLAUSE_GYRO, (*READINGS, "jjf2003.g_earth"), scaled(corrected, DEG)
        ),
    }
    if not positions:
        return ClauseResult(items, dict.fromkeys(items, message("jjf2003-no-rest-gyro")))
    reasons = _reasons(items, positions, {"gyro_g_sensitivity": why_not} if why_not else {})
    excess = excess_remarks("jjf2003-positions-scatter", fit.factors.tolist())
    return ClauseResult(items, reasons, (*earth_remarks(evidence, gyro_k), *excess))


def _horizontal(evidence: ClauseEvidence, positions: Positions, gyro_k: np.ndarray) -> np.ndarray:
    """What Earth's horizontal rate gives the means (n, 6) of rests that no other heading frees of
    it, where latitude and heading are known; 0 elsewhere.
    """
    felt = np.zeros_like(evidence.means)
    if evidence.latitude_deg is None or (evidence.earth and evidence.earth.refuted):
        return felt
    level = EARTH_RATE * float(np.cos(np.radians(evidence.latitude_deg)))
    k = np.where(np.isfinite(gyro_k), gyro_k, np.eye(3))
    for indices in positions.values():
        if not is_paired(evidence, indices):
            felt[list(indices), :3] = level * np.nan_to_num(evidence.north[list(indices)]) @ k.T
    return felt


def _accel_items(
    evidence: ClauseEvidence, up: np.ndarray, positions: Positions, errors: EquipmentErrors
) -> ClauseResult:
    """Scale factor and cross coupling (ratio to local gravity) and bias (m/s²), eq. (11)."""
    gravity = evidence.gravity
    fit = fit_positions(evidence, up, positions, 3, errors)
    by_gravity, bias = fit.by_element
    matrix = undetermined(MATRIX_ELEMENTS)
    if gravity is not None:  # A.1 and A.4 add nothing up for a ratio
        ratios = scaled(by_gravity, 1.0 / gravity)
        matrix = {element: replace(ratio, repeated=()) for element, ratio in ratios.items()}
    azx = (*READINGS, "jjf2003.k_azx")
    items = {
        "accel_scale_factor": ItemEstimate(diagonal(matrix), CLAUSE_ACCEL, READINGS),
        "accel_cross_coupling": ItemEstimate(off_diagonal(matrix), CLAUSE_ACCEL, azx),
        "accel_bias": ItemEstimate(bias, CLAUSE_ACCEL, READINGS),
    }
    if not positions:
        return ClauseResult(items, dict.fromkeys(items, message("jjf2003-no-rest-accel")))
    ratios_of = ("accel_scale_factor", "accel_cross_coupling") if gravity is None else ()
    unknown = dict.fromkeys(ratios_of, message("specifications-no-gravity"))
    excess = excess_remarks("jjf2003-positions-scatter", fit.factors.tolist(), first_channel=3)
    return ClauseResult(items, _reasons(items, positions, unknown), excess)


def _reasons(
    items: Mapping[str, ItemEstimate], positions: Positions, further: Mapping[str, Message]
) -> dict[str, Sayable]:
    """Why elements of these items are null: positions that would determine them, and further."""
    absent = ", ".join(up for up in UPS if up not in positions)
    missing = {
        key: message("jjf2003-position-missing", elements=", ".join(item.undetermined), ups=absent)
        for key, item in items.items()
        if item.undetermined and absent
    }
    reasons = {key: [by[key] for by in (missing, further) if key in by] for key in items}
    return {key: clauses(parts) for key, parts in reasons.items() if parts}


def without_earth(
    evidence: ClauseEvidence,
    positions: dict[str, tuple[int, ...]],
    sensitivity: Estimates,
    gyro_k: np.ndarray,
) -> tuple[Estimates, Message | None]:
    """G with the vertical part of Earth's rotation removed, and why elements are undetermined.

    The vertical part reads K·ωe·sin φ along the axis up. The horizontal part cancels in positions
    held at two headings 180° apart; in others it is not known, and reaches the gyros that are not
    vertical. Where the heading is known it was taken off the readings.
    """
    if evidence.latitude_deg is None:
        unknown_latitude = message("jjf2003-latitude-unknown")
        return dict.fromkeys(sensitivity, UNDETERMINED), unknown_latitude
    k = np.where(np.isfinite(gyro_k), gyro_k, np.eye(3))
    phi = float(np.radians(evidence.latitude_deg))
    single = [
        up
        for up, indices in positions.items()
        if not is_paired(evidence, indices) and not np.isfinite(evidence.north[list(indices)]).all()
    ]
    unknown = {AXES.index(up[1]) for up in single}
    corrected = {}
    for i, j in MATRIX:
        element = AXES[i] + AXES[j]
        by_clause = sensitivity[element]
        value = by_clause.value - float(k[i, j]) * EARTH_RATE * float(np.sin(phi))
        less = replace(by_clause, value=value, without_earth=True)
        corrected[element] = UNDETERMINED if i != j and j in unknown else less
    if not single:
        return corrected, None
    return corrected, message("jjf2003-horizontal-unknown", ups=", ".join(single))


def earth_remarks(evidence: ClauseEvidence, gyro_k: np.ndarray) -> Iterator[Remark]:
    """Says what Earth's rotation does to the diagonal by eq. (7), as far as the data show it."""
    latitude, earth = evidence.latitude_deg, evidence.earth
    if latitude is None:
        return
    state = earth.state if earth else "not_visible"
    text = message(
        f"jjf2003-earth-rotation-{state.replace('_', '-')}", shown=earth_rotation_message(earth),
        rate=f"{DEG * EARTH_RATE * np.sin(np.radians(latitude)):.5f}", latitude=f"{latitude:g}",
    )  # fmt: skip
    yield remark("earth_rotation" if state == "present" else f"earth_rotation_{state}", text)
    if not np.isfinite(gyro_k).all():
        yield remark("scale_factor_assumed", message("earth-rotation-scale-factor-assumed"))
