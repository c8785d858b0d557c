"""The attitude of the unit during a rest: by the table, else by the label.

An attitude vector is (3, 15): for each axis of the unit its components along East, North, Up, and
twelve more for labels of the axis up with a turn about the vertical. From where such a turn is
counted is not recorded, so the level directions of each axis up are a plane of their own.
"""

import numpy as np

from schemas.recording import AXES, UPS, Recording, Segment, Up
from tasks.motion.table import labelled_direction, mount_of, payload_attitude, table_angles

VERTICAL = 2
COMPONENTS = 3 + 2 * len(UPS)
POINTS = {
    "E": (1.0, 0.0, 0.0), "W": (-1.0, 0.0, 0.0), "N": (0.0, 1.0, 0.0), "S": (0.0, -1.0, 0.0),
    "U": (0.0, 0.0, 1.0), "D": (0.0, 0.0, -1.0),
}  # fmt: skip
UPRIGHT = np.cos(np.radians(10.0))


def attitude_vector(recording: Recording, segment: Segment) -> np.ndarray | None:
    """Attitude vector (3, 15) of a rest; None where neither table nor label gives it.

    By the table's encoders and the mount; where the station has no table, by the segment's own
    mount; else by the label, `points` or `up` with `turn_deg`, and by how crooked the mount is to
    it. An unknown heading of the station is taken as zero, which turns every attitude of the run
    about the vertical alike.
    """
    known = _mounted(recording, segment)
    if known is not None:
        return _by_axes(known)
    pointed = _pointed(segment)
    labelled = _turned(segment) if pointed is None else _by_axes(pointed)
    if labelled is None:
        return None
    lie = [labelled_direction(recording.manifest, segment, axis) for axis in np.eye(3)]
    return np.array(lie).T @ labelled


def _by_axes(attitude: np.ndarray) -> np.ndarray:
    """The attitude vector of R_n_body (3, 3)."""
    return np.hstack([attitude.T, np.zeros((3, COMPONENTS - 3))])


def _mounted(recording: Recording, segment: Segment) -> np.ndarray | None:
    """R_n_body (3, 3) by table and mount, or by the mount alone where there is no table."""
    axes = recording.manifest.station.table_axes
    if axes and recording.table is not None:
        angles = table_angles(recording, segment)
        if len(angles):
            payload = payload_attitude(recording.manifest.station, angles.mean(axis=0))
            return payload @ mount_of(recording.manifest, segment)
    if not axes and segment.mount is not None:
        return mount_of(recording.manifest, segment)
    return None


def _pointed(segment: Segment) -> np.ndarray | None:
    """R_n_body (3, 3) by a label such as {"x": "E", "y": "N", "z": "U"}."""
    points = (segment.model_extra or {}).get("points")
    if isinstance(points, dict) and all(points.get(axis) in POINTS for axis in AXES):
        return np.array([POINTS[points[axis]] for axis in AXES]).T
    return None


def attitude_contradicted(recording: Recording, segment: Segment) -> bool:
    """Whether table and mount say that the axes point elsewhere than `points` says, by over 10°."""
    known, label = _mounted(recording, segment), _pointed(segment)
    if known is None or label is None or recording.manifest.station.heading_deg is None:
        return False
    return bool((known * label).sum(axis=0).min() < UPRIGHT)


def _turned(segment: Segment) -> np.ndarray | None:
    """Attitude vector by the axis up and the turn about the vertical."""
    if segment.up is None or segment.turn_deg is None:
        return None
    sign, axis = (1.0 if segment.up[0] == "+" else -1.0), AXES.index(segment.up[1])
    cos, sin = np.cos(np.radians(segment.turn_deg)), np.sin(np.radians(segment.turn_deg))
    plane = 3 + 2 * UPS.index(segment.up)
    points = np.zeros((3, COMPONENTS))
    points[axis, VERTICAL] = sign
    points[(axis + 1) % 3, plane : plane + 2] = cos, sin
    points[(axis + 2) % 3, plane : plane + 2] = -sign * sin, sign * cos
    return points


def with_attitude(segment: Segment, vector: np.ndarray | None) -> Segment:
    """The segment with `up` and `turn_deg` as its attitude has them, where an axis is upright."""
    if vector is None or (segment.up and segment.turn_deg is not None):
        return segment
    axis = int(np.abs(vector[:, VERTICAL]).argmax())
    if abs(vector[axis, VERTICAL]) < UPRIGHT:
        return segment
    up: Up = f"{'+' if vector[axis, VERTICAL] > 0 else '-'}{AXES[axis]}"  # type: ignore[assignment]
    east, north = vector[(axis + 1) % 3, :2]
    turn = float(np.degrees(np.arctan2(north, east)))
    return segment.model_copy(update={"up": up, "turn_deg": round(turn, 3)})
