"""How much of Earth's rotation the rests of a recording show."""

import numpy as np

from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import unit_vector
from tasks.specifications.earth_gain import EarthRotationGain
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.linear import birge_ratio, solve


def earth_rotation_gain(evidence: ClauseEvidence) -> EarthRotationGain | None:
    """λ by least squares over the rests; None without a latitude, or where no rest determines it.

    Where north is known in the rests: for each gyro, bias, three g-sensitivities and λ times the
    north component of Earth's rate; the vertical part cannot be separated from the g-sensitivity
    and does not count. Else: (up − down)/2 over ωe·sin φ, as if the g-sensitivity were none. The
    gyros together by their weights; where they disagree u is enlarged. A scale factor of 1 is
    taken.
    """
    rests = [
        i
        for i in evidence.of_kind("static")
        if evidence.segments[i].has_gyro and evidence.up[i] is not None
    ]
    if evidence.latitude_deg is None or not rests:
        return None
    phi = np.radians(evidence.latitude_deg)
    up = np.array([unit_vector(evidence.up[i]) for i in rests])
    north = evidence.north[rests]
    level = bool(np.isfinite(north).all())
    earth = np.cos(phi) * north if level else np.sin(phi) * up
    by_gyro = [_of_gyro(evidence, rests, up, EARTH_RATE * earth, c, level) for c in range(3)]
    gains = np.array([gain for gain in by_gyro if gain is not None])
    if not len(gains):
        return None
    weights = 1.0 / gains[:, 1] ** 2
    mean = float(weights @ gains[:, 0] / weights.sum())
    square = float(weights @ (gains[:, 0] - mean) ** 2) / max(len(gains) - 1, 1)
    return EarthRotationGain(mean, float(np.sqrt(max(square, 1.0) / weights.sum())), level)


def _of_gyro(
    evidence: ClauseEvidence,
    rests: list[int],
    up: np.ndarray,
    earth: np.ndarray,
    gyro: int,
    level: bool,
) -> tuple[float, float] | None:
    """λ and u of one gyro; None where its rests do not determine it."""
    bias, rate = np.ones(len(rests)), earth[:, gyro]
    columns = (bias, *up.T, rate) if level else (bias, rate)
    if not level:
        rests = [i for i, on in zip(rests, rate, strict=True) if on]
        columns = (bias[rate != 0.0], rate[rate != 0.0])
    design = np.column_stack(columns)
    if not len(design):
        return None
    solution = solve(design)
    readings = evidence.means[rests, gyro]
    covariance = evidence.covariance(gyro)[np.ix_(rests, rests)]
    u = float(solution.uncertainty(covariance)[-1])
    u *= birge_ratio(solution, design, readings, covariance).factor
    value = float(solution.of(readings)[-1])
    return (value, u) if np.isfinite(value) and u > 0.0 else None
