"""What the horizontal part of Earth's rotation may do to rests in which north is not told."""

import numpy as np

from tasks.motion.table import EARTH_RATE
from tasks.specifications.evidence import Evidence
from tasks.specifications.joint.stretches import Stretches


def level_covariance(
    evidence: Evidence, taken: Stretches, gyro: int, latitude_deg: float | None
) -> np.ndarray:
    """Covariance (n, n), (rad/s)², of one gyro's rests by a horizontal rate of unknown direction.

    A gyro that lies level reads ωe·cos φ·cos(ψ + heading) with ψ unknown: half the square of the
    amplitude, times the cosine of the turn between two headings of one face. The mean of two
    headings 180° apart is free of it, and its scatter is not the unit's. Without a latitude the
    whole of ωe is taken; without a heading a rest shares nothing with another.
    """
    n = len(evidence.segments)
    amplitude = EARTH_RATE * (1.0 if latitude_deg is None else np.cos(np.radians(latitude_deg)))
    still = np.array([segment.segment.kind == "static" for segment in evidence.segments], bool)
    blind = still & taken.gyro & ~np.isfinite(taken.motion.north).all(axis=1)
    level = blind * np.sqrt(np.clip(1.0 - np.nan_to_num(taken.motion.up[:, gyro]) ** 2, 0.0, 1.0))
    turn = [segment.segment.turn_deg for segment in evidence.segments]
    heading = np.radians([np.nan if degrees is None else degrees for degrees in turn])
    same = np.array([[one == other for other in evidence.up] for one in evidence.up]).reshape(n, n)
    shared = np.nan_to_num(np.cos(heading[:, None] - heading)) * same
    np.fill_diagonal(shared, 1.0)
    return np.asarray(0.5 * amplitude**2 * np.outer(level, level) * shared)
