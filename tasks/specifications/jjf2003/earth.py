"""Earth's rotation in the g-sensitivity of eq. (7), and the value without it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from schemas.recording import AXES
from schemas.text import Remark
from tasks.motion.table import EARTH_RATE
from tasks.specifications.earth_gain import earth_rotation_message
from tasks.specifications.estimate import DEG, MATRIX, UNDETERMINED, Estimates
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.jjf2003.positions import is_paired
from tasks.uncertainty.equipment import Equipment
from tasks.uncertainty.type_b import earth_removed
from tasks.words import Message, message, remark


def without_earth(
    evidence: ClauseEvidence,
    positions: dict[str, tuple[int, ...]],
    sensitivity: Estimates,
    gyro_k: np.ndarray,
    equipment: Equipment,
) -> tuple[Estimates, Message | None]:
    """G with the vertical part of Earth's rotation removed, and why elements are undetermined.

    The vertical part reads K·ωe·sin φ along the axis up; its budget has the latitude's line
    beside those of the clause's value. The horizontal part cancels in positions held at two
    headings 180° apart; in others it is not known, and reaches the gyros that are not vertical.
    """
    if evidence.latitude_deg is None:
        unknown_latitude = message("jjf2003-latitude-unknown")
        return dict.fromkeys(sensitivity, UNDETERMINED), unknown_latitude
    k = np.where(np.isfinite(gyro_k), gyro_k, np.eye(3))
    phi = float(np.radians(evidence.latitude_deg))
    single = [up for up, indices in positions.items() if not is_paired(evidence, indices)]
    unknown = {AXES.index(up[1]) for up in single}
    corrected = {}
    for i, j in MATRIX:
        element = AXES[i] + AXES[j]
        by_clause = sensitivity[element]
        lines = earth_removed(equipment, float(k[i, j]), phi)
        value = by_clause.value - float(k[i, j]) * EARTH_RATE * float(np.sin(phi))
        less = replace(by_clause, value=value).with_lines(*lines)
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
