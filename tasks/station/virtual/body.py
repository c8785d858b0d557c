"""Rate and specific force of the body on the table: rigid rotation on a rotating Earth."""

import numpy as np
from scipy.spatial.transform import Rotation

from tasks.station.virtual import quaternions
from tasks.station.virtual.config import EARTH_RATE_RAD_S, STEP_S, VirtualStation

UP = np.array([0.0, 0.0, 1.0])


class Body:
    """Follows the table's angles; what it gives is one step behind what it got."""

    def __init__(self, config: VirtualStation) -> None:
        directions = [np.array(axis.direction) for axis in config.table.axes]
        self._directions = [direction / np.linalg.norm(direction) for direction in directions]
        self._base = quaternions.about(-UP, np.radians([config.heading_deg]))
        mount = Rotation.from_quat(config.mount.quaternion_wxyz, scalar_first=True)
        self._mount = mount.as_quat(scalar_first=True)[:, None]
        latitude = np.radians(config.latitude_deg)
        north_up = np.array([0.0, np.cos(latitude), np.sin(latitude)])
        # rotation of East-North-Up in inertial space during one step, (4, 1)
        self._earth = quaternions.about(north_up, np.array([EARTH_RATE_RAD_S * STEP_S]))
        self._gravity = config.gravity_m_s2
        start = self.attitude(np.zeros((1, len(directions))), self._mount)
        self._attitude = start
        self._rate = self._rates(np.hstack([start, start]))

    def attitude(self, angles: np.ndarray, mount: np.ndarray) -> np.ndarray:
        """R_n_body at the axes' angles (n, axes) and mounts (4, n or 1), as quaternions (4, n)."""
        q = self._base
        for direction, angle in zip(self._directions, angles.T, strict=True):
            q = quaternions.product(q, quaternions.about(direction, angle))
        return quaternions.product(q, mount)

    def _rates(self, attitudes: np.ndarray) -> np.ndarray:
        """Inertial rate (3, n−1) between attitudes (4, n): the exact mean over each step."""
        back = quaternions.conjugate(attitudes[:, :-1])
        turn = quaternions.product(quaternions.product(back, self._earth), attitudes[:, 1:])
        return quaternions.rotation_vector(turn) / STEP_S

    def still(self) -> tuple[np.ndarray, np.ndarray]:
        """Inertial body rate and specific force (3, 1), as long as nothing moves."""
        return self._rate, quaternions.up_in_body(self._attitude) * self._gravity

    def move(
        self, angles: np.ndarray, mount: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Takes the angles (n, axes) after the next n steps; gives the motion one step before each.

        mount: attitude of the unit on the payload, (4, n) or (4, 1); else that of the station.

        Returns inertial body rate (rad/s), angular acceleration (rad/s²) and the specific force
        of a point at rest at the axes' intersection (m/s²), each (3, n) in the body frame. Rate
        and acceleration are those of the middle of two steps, so they are where the time is.
        """
        seat = self._mount if mount is None else mount
        attitudes = np.hstack([self._attitude, self.attitude(angles, seat)])
        rates = np.hstack([self._rate, self._rates(attitudes)])
        self._attitude, self._rate = attitudes[:, -1:], rates[:, -1:]
        up = quaternions.up_in_body(attitudes[:, :-1])
        middle = 0.5 * (rates[:, 1:] + rates[:, :-1])
        return middle, np.diff(rates, axis=1) / STEP_S, up * self._gravity
