"""An independent least-squares solution of the joint method, for comparison: QR on plain means.

The model, the means, the motion and the solution are made here from the labels and the table's
angles alone. Only the weights are the method's own: the covariance of the means.
"""

import numpy as np
from scipy.linalg import cholesky, qr, solve_triangular
from scipy.spatial.transform import Rotation

from schemas.recording import ACCEL, AXES, GYRO, Recording
from tasks.calibrate.evaluation import evaluation_for
from tasks.specifications.gather import gather
from tasks.specifications.joint.segment_motion import segment_motion
from tasks.specifications.joint.solution import solve_jointly
from tasks.validation.run2003 import printed_items

EARTH = 7.292115e-5  # rad/s
ROUNDS = 12
DEGREE = np.pi / 180.0
Values = dict[str, dict[str, float]]


def plain_joint(recording: Recording) -> Values:
    """Every item of JJF 2003 by the joint method, in printed units.

    recording: a run of `run2003`, whose table turns about z, x, z from the outside in.
    """
    station, segments = recording.manifest.station, recording.manifest.segments or ()
    gravity = float(station.gravity_m_s2 or np.nan)
    means, rows = segment_means(recording)
    up, earth = _vertical_and_earth_rate(recording, rows, np.radians(station.latitude_deg or 0.0))
    rate = np.array([[(s.axis == a) * (s.rate_deg_s or 0.0) * DEGREE for a in AXES]
                     for s in segments])  # fmt: skip
    at_rest = np.array([s.kind == "static" for s in segments])
    covariance = _weights(recording)
    one = np.ones((len(segments), 1))
    K, bias, g = np.eye(3), np.zeros(3), np.zeros((3, 3))
    for _ in range(ROUNDS):
        still = means[:, :3] - earth @ K.T
        new = [_gyro(rate, up, at_rest, still[:, i], covariance[i], one) for i in range(3)]
        K, bias, g = (np.array(part) for part in zip(*new, strict=True))
    design = np.hstack([gravity * up, one, (rate + earth) ** 2])
    accel = np.array([_gls(design, means[:, 3 + i], covariance[3 + i]) for i in range(3)])
    read = means[:, :3] - rate @ K.T
    offset = [read[[s.kind == "rate" and s.axis == a for s in segments], i].mean()
              for i, a in enumerate(AXES)]  # fmt: skip
    return printed_items(K, np.array(offset), bias, g, accel[:, :3], accel[:, 3], -accel[:, 4:])


def segment_means(recording: Recording) -> tuple[np.ndarray, list[np.ndarray]]:
    """Plain means (n, 6) of gyros and accelerometers, and which rows (bool) each segment has."""
    t = recording.imu.t
    rows = [(t >= s.t_start) & (t < s.t_end) for s in recording.manifest.segments or ()]
    columns = np.array([recording.imu.columns[name] for name in GYRO + ACCEL])
    return np.array([columns[:, which].mean(axis=1) for which in rows]), rows


def _gyro(
    rate: np.ndarray,
    up: np.ndarray,
    at_rest: np.ndarray,
    read: np.ndarray,
    covariance: np.ndarray,
    one: np.ndarray,
) -> tuple[np.ndarray, float, np.ndarray]:
    """K (3,), bias and g-sensitivity (3,) per g: the rests first, then all with those
    subtracted.
    """
    both = np.hstack([one, up])
    block = covariance[np.ix_(at_rest, at_rest)]
    zero = _gls(both[at_rest], read[at_rest], block)
    pick = np.zeros((4, len(read)))
    unit = np.eye(int(at_rest.sum()))
    pick[:, at_rest] = np.column_stack([_gls(both[at_rest], e, block) for e in unit])
    left = np.eye(len(read)) - up @ pick[1:]
    line = _gls(np.hstack([rate, one]), left @ read, left @ covariance @ left.T)
    return line[:3], float(zero[0]), zero[1:]


def _gls(design: np.ndarray, read: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Generalised least squares: the smallest (y − Hθ)ᵀ·C⁻¹·(y − Hθ), by a QR decomposition.

    No variance counts as less than a tenth of the median one, as the method has it.
    """
    variance = np.diag(covariance)
    floor = 0.1 * np.median(variance)
    raised = np.maximum(variance, floor)
    root = cholesky(covariance + np.diag(raised - variance + 1e-9 * raised), lower=True)
    scale = np.abs(design).max(axis=0)
    white = solve_triangular(root, np.column_stack([design / scale, read]), lower=True)
    q, r = qr(white[:, :-1], mode="economic")
    return np.asarray(solve_triangular(r, q.T @ white[:, -1]) / scale)


def _vertical_and_earth_rate(
    recording: Recording, rows: list[np.ndarray], latitude: float
) -> tuple[np.ndarray, np.ndarray]:
    """Mean vertical and mean Earth rotation (n, 3), rad/s, in the body, by the table's angles."""
    assert recording.table is not None
    angles = np.array(list(recording.table.columns.values())).T
    body = Rotation.from_euler("ZXZ", angles).inv()
    up = body.apply([0.0, 0.0, 1.0])
    earth = body.apply(EARTH * np.array([0.0, np.cos(latitude), np.sin(latitude)]))
    return (
        np.array([up[which].mean(axis=0) for which in rows]),
        np.array([earth[which].mean(axis=0) for which in rows]),
    )


def _weights(recording: Recording) -> np.ndarray:
    evidence = gather(recording)
    equipment = evaluation_for(recording).equipment
    return solve_jointly(evidence, segment_motion(evidence), equipment).covariance
