"""Angular acceleration of a tracked body from its own gyros, where these are less noisy.

The second derivative of an attitude shares its noise with the specific force that the same poses
predict; as a regressor it invents lever arms. The first derivative of a gyro does not.
"""

from dataclasses import replace

import numpy as np

from tasks.motion.band import band_edge, derivatives
from tasks.motion.pose import derivative_gain
from tasks.motion.samples import noise_by_differences
from tasks.motion.whole import Motion

GAP = 1.5  # intervals between two rows that belong together
FEWEST = 50  # rows
EXPLAINED = 0.9  # of the gyros' power by the poses' rates, at least: else they are not the same
INDEPENDENT = 1e-2  # least ratio of two principal gains of the triad
WIDER = 3.0  # times the band of the poses, at most: beyond, nothing is compared
ORDER = 6  # of the differences that the gyros' noise is read off


def with_gyro_acceleration(motion: Motion, readings: np.ndarray) -> Motion:
    """The motion with the gyros' acceleration where it has less noise than the poses'.

    readings: (n, 6) rad/s and m/s². The gyros are first fitted to the poses' rates, so that scale
    factors and turned axes do not matter, nor does their bias.
    """
    tracking, gyro = motion.tracking, readings[:, :3]
    if tracking is None:
        return motion
    known = motion.felt[:, 0] & np.isfinite(gyro).all(axis=1)
    if known.sum() < FEWEST:
        return motion
    columns, fitted, _ = by_rates(motion, gyro, known)
    left = gyro[known] - columns @ fitted
    gains = np.linalg.svd(fitted[:3], compute_uv=False)
    power = ((gyro[known] - gyro[known].mean(axis=0)) ** 2).sum()
    if (left**2).sum() > (1.0 - EXPLAINED) * power or gains[-1] < INDEPENDENT * gains[0]:
        return motion
    inverse, spans = np.linalg.inv(fitted[:3]), _spans(motion, known)
    angles = [np.cumsum(gyro[rows], axis=0) * motion.interval for rows in spans]
    if not spans:
        return motion
    edge = min(band_edge(angles, motion.interval), WIDER * tracking.attitude)
    noise = noise_by_differences(gyro[known], ORDER, 0.5) * np.linalg.norm(inverse, 2)
    own = noise**2 * derivative_gain(1, edge, motion.interval)
    if own >= tracking.acceleration_variance:
        return motion
    acceleration = motion.acceleration.copy()
    for rows in spans:
        _, slope, _ = derivatives(gyro[rows], motion.interval, edge)
        acceleration[rows] = slope @ inverse
    return replace(motion, acceleration=acceleration)


def by_rates(
    motion: Motion, gyro: np.ndarray, known: np.ndarray
) -> tuple[np.ndarray, np.ndarray, int]:
    """Gyros (n, 3) fitted by the poses' rates and a bias, in the known rows (n,) bool: the columns
    (k, 4), their coefficients (4, 3), and how many of the columns are independent.
    """
    columns = np.column_stack([motion.rate, np.ones(len(gyro))])[known]
    fitted, _, rank, _ = np.linalg.lstsq(columns, gyro[known], rcond=None)
    return columns, fitted, int(rank)


def _spans(motion: Motion, known: np.ndarray) -> list[np.ndarray]:
    """Rows without a gap between them that are known."""
    breaks = (np.diff(motion.t) > GAP * motion.interval) | (known[1:] != known[:-1])
    parts = np.split(np.arange(len(known)), np.flatnonzero(breaks) + 1)
    return [rows for rows in parts if known[rows[0]] and len(rows) >= FEWEST]
