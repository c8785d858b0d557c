"""7.2.2 and 7.2.4: biases, g-sensitivity, accelerometer scale factor and cross coupling."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from schemas.recording import AXES, UPS
from schemas.text import Remark
from tasks.motion.table import EARTH_RATE
from tasks.specifications.earth_gain import earth_rotation_message
from tasks.specifications.error_sources import EquipmentErrors
from tasks.specifications.estimate import (
    DEG,
    MATRIX,
    UNDETERMINED,
    ClauseResult,
    Estimates,
    ItemEstimate,
    diagonal,
    excess_remarks,
    merged,
    off_diagonal,
    scaled,
    undetermined,
)
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.items import MATRIX_ELEMENTS
from tasks.specifications.jjf2003.positions import (
    Positions,
    fit_positions,
    is_paired,
    position_remarks,
    usable_positions,
)  # fmt: skip
from tasks.words import Message, Sayable, clauses, message, remark

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
