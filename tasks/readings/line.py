"""What a channel should read of what the unit felt, for readings of which a part is lost."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from schemas.recording import Recording
from tasks.motion.whole import Motion, whole_motion

# Standard deviations of how a working unit differs from an ideal one.
SCALE = 0.03  # of scale factors, and of cross coupling, rad
GYRO = {"bias": 0.05, "gravity": 1e-3}  # rad/s, (rad/s)/(m/s²)
ACCEL = {"bias": 0.5, "rate": 1e-2, "arm": 0.3}  # m/s², (m/s²)/(rad/s), m


@dataclass(frozen=True)
class Line:
    """Readings as a straight line in columns (n, k), NaN where they are not known.

    ideal, spread: (k,) coefficients of an ideal unit, and by how much those of a unit differ. In
    units of the readings.
    """

    columns: np.ndarray
    ideal: np.ndarray
    spread: np.ndarray

    @cached_property
    def known(self) -> np.ndarray:
        """(n,) bool: the columns are."""
        return np.asarray(np.isfinite(self.columns).all(axis=1))

    def through(
        self, readings: np.ndarray, used: np.ndarray, scatter: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """What the line (n,) through some readings gives, and how uncertain (n,) that is.

        used: (n,) bool. scatter: of one of them about the line.
        """
        columns = np.where(self.known[:, None], self.columns, 0.0)
        rows = columns[used] * self.spread / scatter
        covariance = np.linalg.inv(rows.T @ rows + np.eye(len(self.ideal)))
        off = (readings[used] - columns[used] @ self.ideal) / scatter
        coefficients = self.ideal + self.spread * (covariance @ (rows.T @ off))
        scaled = columns * self.spread
        variance = np.einsum("nk,nk->n", scaled @ covariance, scaled)
        return columns @ coefficients, np.sqrt(np.maximum(variance, 0.0))


class Course:
    """What the unit of a recording felt, found when it is first asked for."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording

    @cached_property
    def _motion(self) -> Motion:
        return whole_motion(self._recording)

    def line(self, channel: int, step: float) -> Line:
        """What one of the six channels reads, in steps (rad/s or m/s²) of its output.

        A gyro follows rate and gravity; an accelerometer force, rate, and, off the axis, the
        squares of the rate.
        """
        rate, force = self._motion.rate, self._motion.force
        if not np.isfinite(force).any():  # labels that tell no axis up
            force = np.zeros_like(rate)
        one, own = np.ones((len(rate), 1)), np.eye(3)[channel % 3]
        if channel < 3:
            columns = np.hstack([one, rate, force])
            ideal = np.concatenate([[0.0], own, np.zeros(3)])
            spread = [GYRO["bias"], *[SCALE] * 3, *[GYRO["gravity"]] * 3]
        else:
            squares = rate[:, [0, 1, 2, 0, 1, 2]] * rate[:, [0, 1, 2, 1, 2, 0]]
            columns = np.hstack([one, force, rate, squares])
            ideal = np.concatenate([[0.0], own, np.zeros(9)])
            spread = [ACCEL["bias"], *[SCALE] * 3, *[ACCEL["rate"]] * 3, *[ACCEL["arm"]] * 6]
        return Line(columns, ideal / step, np.array(spread) / step)
