"""The gyro's matrix from manual moves between rests.

The gyro's readings over a move, less those of the rests beside it, integrated to a rotation, must
turn the vertical as the accelerometers saw it before into the vertical after.
Source: as `gravity_fit`, eq. (12), with the bias taken from both neighbouring rests.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from schemas.recording import GYRO, Stream
from tasks.segments.summarise import GYRO_COLUMNS, SegmentMean
from tasks.specifications.evidence import BirgeRatio, Solution, birge_ratio

# Accelerometers calibrated by gravity alone: |K⁻¹·(a − B)| = g in every rest, at any attitude.
#
# Source: Tedaldi, Pretto and Menegatti, “A robust and easy to implement method for IMU
# calibration without external equipments”, ICRA 2014, eq. (10); the body axes as in
# `joint.gravity_alone`.

UPPER = tuple((i, j) for i in range(3) for j in range(i, 3))
FEWEST_RESTS = 12  # nine parameters, and some rests to contradict them
TIGHT = 1e-15  # of cost, step and gradient: to the last digit
CONDITION = 1e4  # of the scaled equations: beyond it the attitudes do not tell the parameters apart


@dataclass(frozen=True)
class GravityFit:
    """Nine accelerometer parameters from rests.

    matrix: K (3, 3), upper triangular; bias: (3,) m/s².
    felt: (n, 3) specific force K⁻¹(a − B) of each rest; misses: (n,) its size less gravity, m/s².
    operator: (9, n, 3), how the parameters (K in the order of UPPER, then the bias) follow each
    mean reading; by_gravity: (9,) how they follow gravity.
    excess: how much more the misses scatter than the noise of the means explains.
    """

    matrix: np.ndarray
    bias: np.ndarray
    felt: np.ndarray
    misses: np.ndarray
    operator: np.ndarray
    by_gravity: np.ndarray
    excess: BirgeRatio


def fit_gravity(means: np.ndarray, gravity: float, noise: np.ndarray) -> GravityFit | None:
    """Fit K and B to the mean readings (n, 3) m/s² of rests; None where they do not determine them.

    noise: (3, n, n) covariance of the means of each channel. Levenberg and Marquardt from an
    ideal unit.
    """
    from scipy.optimize import least_squares  # late: most rests have a label

    if len(means) < FEWEST_RESTS:
        return None
    start = np.append([float(i == j) for i, j in UPPER], np.zeros(3))
    solved = least_squares(
        lambda values: _equations(values, means, gravity)[1],
        start,
        jac=lambda values: _equations(values, means, gravity)[2],
        method="lm", x_scale="jac", ftol=TIGHT, xtol=TIGHT, gtol=TIGHT,
    )  # fmt: skip
    felt, misses, slopes = _equations(solved.x, means, gravity)
    scale = np.linalg.norm(slopes, axis=0)
    if not solved.success or not np.linalg.cond(slopes / np.where(scale, scale, 1.0)) < CONDITION:
        return None
    follow = np.linalg.pinv(slopes)
    readout = -slopes[:, 6:]  # d miss/d reading: what it does to the bias, the other way
    spread = sum(readout[:, c, None] * noise[c] * readout[None, :, c] for c in range(3))
    solution = Solution(follow, np.ones(9, bool))
    return GravityFit(
        matrix=_matrix(solved.x),
        bias=solved.x[6:],
        felt=felt,
        misses=misses,
        operator=-follow[:, :, None] * readout[None],
        by_gravity=follow.sum(axis=1),
        excess=birge_ratio(solution, slopes, misses, np.asarray(spread)),
    )


def _matrix(values: np.ndarray) -> np.ndarray:
    matrix = np.zeros((3, 3))
    matrix[tuple(zip(*UPPER, strict=True))] = values[:6]
    return matrix


def _equations(
    values: np.ndarray, means: np.ndarray, gravity: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Specific force (n, 3), misses (n,) and their derivatives (n, 9) by the parameters (9,)."""
    inverse = np.linalg.inv(_matrix(values))
    felt = (means - values[6:]) @ inverse.T
    size = np.linalg.norm(felt, axis=1)
    back = felt / size[:, None] @ inverse  # (K⁻ᵀ·f/|f|) of each rest
    slopes = np.column_stack([*(-back[:, i] * felt[:, j] for i, j in UPPER), -back])
    return felt, size - gravity, slopes


FEWEST_MOVES = 9  # two equations each, nine parameters, and as many to contradict them
LONGEST_MOVE = 60.0  # s: a longer way between two rests drifts


@dataclass(frozen=True)
class Moves:
    """Gyro increments of all moves, padded with zeros to equal length.

    turns: (moves, rows, 3) rad as read by the gyro, bias subtracted; before, after: (moves, 3) unit
    verticals in the body.
    """

    turns: np.ndarray
    before: np.ndarray
    after: np.ndarray


@dataclass(frozen=True)
class MovesFit:
    """K (3, 3) of the gyro, its standard uncertainties, their degrees of freedom.

    miss: rms angle (rad) between the verticals after the moves.
    """

    matrix: np.ndarray
    u: np.ndarray
    dof: float
    miss: float
    moves: int


def gather_moves(imu: Stream, rests: list[SegmentMean], verticals: np.ndarray) -> Moves:
    """The moves between rests that follow each other; verticals: (n, 3) of the rests."""
    turns, before, after = [], [], []
    for k, (first, second) in enumerate(pairwise(rests)):
        if second.t_start - first.t_end > LONGEST_MOVE:
            continue
        rows = imu.rows(first.t_end, second.t_start)
        rate = imu.stack(GYRO, rows)
        if len(rate) < 2 or not np.isfinite(rate).all():
            continue
        t = imu.t[rows]
        share = ((t - t[0]) / (t[-1] - t[0]))[:, None]
        bias = first.mean[GYRO_COLUMNS] * (1 - share) + second.mean[GYRO_COLUMNS] * share
        turns.append(_increments(t, rate - bias))
        before.append(verticals[k])
        after.append(verticals[k + 1])
    longest = max(map(len, turns), default=0)
    padded = np.zeros((len(turns), longest, 3))
    for k, each in enumerate(turns):
        padded[k, : len(each)] = each
    return Moves(padded, np.array(before).reshape(-1, 3), np.array(after).reshape(-1, 3))


def fit_moves(moves: Moves) -> MovesFit | None:
    """Fit K⁻¹ so that the verticals meet; None where the moves do not determine it.

    The uncertainty is that of the scatter of the misses: what shakes and slips during a move by
    hand is more than the gyro's noise.
    """
    from scipy.optimize import least_squares  # late: few recordings are moved by hand

    count = len(moves.turns)
    if count < FEWEST_MOVES:
        return None
    solved = least_squares(
        lambda values: _misses(moves, values.reshape(3, 3)), np.eye(3).ravel(), jac="3-point",
        ftol=TIGHT, xtol=TIGHT, gtol=TIGHT,
    )  # fmt: skip
    if not solved.success or not np.linalg.cond(solved.jac) < CONDITION:
        return None
    inverse, misses, slopes, dof = solved.x.reshape(3, 3), solved.fun, solved.jac, 2.0 * count - 9.0
    matrix = np.linalg.inv(inverse)
    covariance = np.linalg.inv(slopes.T @ slopes) * (misses @ misses / dof)
    # dK = −K·dK⁻¹·K
    change = -np.einsum("ia,bj->ijab", matrix, matrix).reshape(9, 9)
    u = np.sqrt(np.diag(change @ covariance @ change.T)).reshape(3, 3)
    return MovesFit(matrix, u, dof, float(np.sqrt(misses @ misses / count)), count)


def _increments(t: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Rotation increments (n − 1, 3): the trapezium, with coning to the second order."""
    step = np.diff(t)[:, None]
    straight = 0.5 * step * (rate[:-1] + rate[1:])
    return straight + step**2 / 12.0 * np.cross(rate[:-1], rate[1:])


def _misses(moves: Moves, inverse: np.ndarray) -> np.ndarray:
    """(3·moves,) difference of the verticals: turned by the gyro, and seen."""
    quaternions = _quaternions(moves.turns @ inverse.T)
    while quaternions.shape[1] > 1:
        if quaternions.shape[1] % 2:
            still = np.zeros((len(quaternions), 1, 4))
            still[..., 0] = 1.0
            quaternions = np.concatenate([quaternions, still], axis=1)
        quaternions = _product(quaternions[:, ::2], quaternions[:, 1::2])
    turned = _turned_back(quaternions[:, 0], moves.before)
    return (turned - moves.after).ravel()


def _quaternions(vectors: np.ndarray) -> np.ndarray:
    """Unit quaternions (…, 4), w first, of rotation vectors (…, 3) rad."""
    half = 0.5 * np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * vectors], axis=-1)


def _product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Quaternion products (…, 4), w first: p, then q in the turned frame."""
    w = p[..., :1] * q[..., :1] - (p[..., 1:] * q[..., 1:]).sum(axis=-1, keepdims=True)
    v = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate([w, v], axis=-1)


def _turned_back(q: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) that stand still in n, as the body sees them after turning by q (n, 4)."""
    w, v = q[:, :1], -q[:, 1:]
    across = 2.0 * np.cross(v, vectors)
    return vectors + w * across + np.cross(v, across)
