"""A unit under test that accumulates angles: it adds up what its gyros feel."""

import numpy as np

from tasks.station.virtual.config import STEP_S
from tasks.station.virtual.sensors import UnitUnderTest, to_counts
from tasks.station.virtual.unit import UnitTruth


class Ahrs(UnitUnderTest):
    """Angles about its own axes since power-on, and accelerations. It has no gyro low-pass."""

    def __init__(self, unit: UnitTruth, air_degc: float) -> None:
        super().__init__(unit, air_degc)
        self._begin_angles()

    def switch_on(self, air_degc: float) -> None:
        """The angles begin anew."""
        super().switch_on(air_degc)
        self._begin_angles()

    def _begin_angles(self) -> None:
        self._angle = np.zeros((3, 1))  # of the steps that were told
        self._drift = np.zeros(3)  # of noise and bias, up to the last sample

    def _moving(self, rate: np.ndarray, angular: np.ndarray, gravity: np.ndarray) -> np.ndarray:
        angle = self._angle + np.cumsum(self._turn(rate, gravity), axis=1) * STEP_S
        self._angle = angle[:, -1:]
        return np.vstack([angle, self._accel(self._force(rate, angular, gravity))])

    def _resting(
        self, t: np.ndarray, steps: int, rate: np.ndarray, gravity: np.ndarray
    ) -> np.ndarray:
        turn = self._turn(rate, gravity)
        angles = self._angle + turn * (t - (self._step - 1) * STEP_S)
        self._angle = self._angle + turn * (steps * STEP_S)
        force = self._force(rate, 0.0 * rate, gravity)
        self._last = np.vstack([self._angle, force])
        return np.vstack([angles, np.tile(force, len(t))]).T

    def _counts(self, values: np.ndarray, errors: np.ndarray) -> np.ndarray:
        """errors: of the rates, which add up to errors of the angle."""
        assert self._unit.angle_lsb is not None
        drift = self._drift + np.cumsum(errors[:, :3], axis=0) / self._unit.rate_hz
        self._drift = drift[-1]
        angle = np.rint((values[:, :3] + drift) / self._unit.angle_lsb).astype(np.int64)
        return np.hstack([angle, to_counts(self._unit.accel, values[:, 3:] + errors[:, 3:])])
