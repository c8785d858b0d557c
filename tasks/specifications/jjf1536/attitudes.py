"""Where the axes of the unit point during a rest: by the table, else by the label.

A pointing is (3, 15): for each axis of the unit its components along East, North, Up, and twelve
more for labels of the axis up with a turn about the vertical. Nobody says from where such a turn
is counted, so the level directions of each axis up are a plane of their own.
"""

import numpy as np

from schemas.recording import AXES, Recording, Segment, Up
from tasks.motion.table import mount_of, rotation
from tasks.specifications.evidence import UPS

VERTICAL = 2
COMPONENTS = 3 + 2 * len(UPS)
POINTS = {
    "E": (1.0, 0.0, 0.0), "W": (-1.0, 0.0, 0.0), "N": (0.0, 1.0, 0.0), "S": (0.0, -1.0, 0.0),
    "U": (0.0, 0.0, 1.0), "D": (0.0, 0.0, -1.0),
}  # fmt: skip
UPRIGHT = np.cos(np.radians(10.0))


def pointing(recording: Recording, segment: Segment) -> np.ndarray | None:
    """Pointing (3, 15) of a rest; None where neither a table nor the label tells.

    By the table's encoders and the mount; where the station has no table, by the segment's own
    mount; else by the label: `points`, or `up` with `turn_deg`. An unknown heading of the station
    is taken as zero, which turns every attitude of the run about the vertical alike.
    """
    known = _attitude(recording, segment)
    if known is None:
        return _turned(segment)
    return np.hstack([known.T, np.zeros((3, COMPONENTS - 3))])


def _attitude(recording: Recording, segment: Segment) -> np.ndarray | None:
    """R_n_body (3, 3), or None."""
    known = _mounted(recording, segment)
    return _pointed(segment) if known is None else known


def _mounted(recording: Recording, segment: Segment) -> np.ndarray | None:
    """R_n_body (3, 3) by table and mount, or by the mount alone where there is no table."""
    axes = recording.manifest.station.table_axes
    if axes and recording.table is not None:
        rows = recording.table.rows(segment.t_start, segment.t_end)
        if rows.stop > rows.start:
            names = tuple(f"{axis.name}_angle" for axis in axes)
            angles = np.unwrap(recording.table.stack_rows(names, rows), axis=0).mean(axis=0)
            return _payload(recording, angles) @ mount_of(recording.manifest, segment)
    if not axes and segment.mount is not None:
        return mount_of(recording.manifest, segment)
    return None


def _pointed(segment: Segment) -> np.ndarray | None:
    """R_n_body (3, 3) by a label such as {"x": "E", "y": "N", "z": "U"}."""
    points = (segment.model_extra or {}).get("points")
    if isinstance(points, dict) and all(points.get(axis) in POINTS for axis in AXES):
        return np.array([POINTS[points[axis]] for axis in AXES]).T
    return None


def points_contradicted(recording: Recording, segment: Segment) -> bool:
    """Whether table and mount say that the axes point elsewhere than `points` says, by over 10°."""
    known, said = _mounted(recording, segment), _pointed(segment)
    if known is None or said is None or recording.manifest.station.heading_deg is None:
        return False
    return bool((known * said).sum(axis=0).min() < UPRIGHT)


def _payload(recording: Recording, angles: np.ndarray) -> np.ndarray:
    """R_n_payload (3, 3) at the table's angles (rad)."""
    station = recording.manifest.station
    turned = rotation(np.array([0.0, 0.0, 1.0]), -np.radians(station.heading_deg or 0.0))
    for axis, angle in zip(station.table_axes or (), angles, strict=True):
        direction = np.array(axis.direction)
        turned = turned @ rotation(direction / np.linalg.norm(direction), float(angle))
    return turned


def _turned(segment: Segment) -> np.ndarray | None:
    """Pointing by the axis up and the turn about the vertical."""
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


def placed(segment: Segment, points: np.ndarray | None) -> Segment:
    """The segment with `up` and `turn_deg` as its attitude has them, where an axis is upright."""
    if points is None or (segment.up and segment.turn_deg is not None):
        return segment
    axis = int(np.abs(points[:, VERTICAL]).argmax())
    if abs(points[axis, VERTICAL]) < UPRIGHT:
        return segment
    up: Up = f"{'+' if points[axis, VERTICAL] > 0 else '-'}{AXES[axis]}"  # type: ignore[assignment]
    east, north = points[(axis + 1) % 3, :2]
    turn = float(np.degrees(np.arctan2(north, east)))
    return segment.model_copy(update={"up": up, "turn_deg": round(turn, 3)})
