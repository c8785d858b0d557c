"""How the axes of a table stood in each segment, by its encoders."""

import math
from dataclasses import dataclass

import numpy as np

from tasks.motion.table import axis_directions, mount_of, rotation, table_angles
from tasks.specifications.evidence import ClauseEvidence

SAME_ANGLE = 0.01  # degrees: a table set twice within this was set to the same angle
TURNED = math.radians(1.0)  # of an axis within a segment: less is its servo


@dataclass(frozen=True)
class AxesOfTable:
    """How the axes of a table stood, by its encoders.

    angles: (n, k) rad, mean of each segment; turns: (n, k) whether the axis turned in it.
    """

    angles: np.ndarray
    turns: np.ndarray

    @property
    def count(self) -> int:
        return self.angles.shape[1]

    def angles_set(self, axis: int) -> list[int | None]:
        """The angle at which the axis stood, as a number; None where it turned."""
        steps = np.round(np.degrees(self.angles[:, axis]) / SAME_ANGLE).astype(int)
        whole = round(360.0 / SAME_ANGLE)
        return [
            None if turns else int(step % whole)
            for step, turns in zip(steps, self.turns[:, axis], strict=True)
        ]

    def times_set(self, axis: int) -> list[int | None]:
        """How often the axis was set before; None where it turned."""
        numbers: list[int | None] = []
        last, number = None, 0
        for angle in self.angles_set(axis):
            number += angle != last
            last = angle
            numbers.append(None if angle is None else number)
        return numbers

    def axis_in_body(self, evidence: ClauseEvidence, axis: int) -> np.ndarray:
        """Direction (n, 3) of an axis in the body."""
        return self._in_body(
            evidence, axis_directions(evidence.recording.manifest.station)[axis], axis
        )

    def joint_in_body(self, evidence: ClauseEvidence, axis: int) -> np.ndarray:
        """Across an axis and the next inside it, (n, 3) in the body: about it they are not square.

        Zero where the two are parallel.
        """
        directions = axis_directions(evidence.recording.manifest.station)
        return self._in_body(evidence, np.cross(directions[axis], directions[axis + 1]), axis)

    def _in_body(self, evidence: ClauseEvidence, vector: np.ndarray, outside: int) -> np.ndarray:
        """A vector fixed to what axis `outside` carries, (n, 3) as the body sees it."""
        manifest = evidence.recording.manifest
        inside = list(enumerate(axis_directions(manifest.station)))[outside + 1 :]
        seen = []
        for label, angles in zip(evidence.labels, self.angles, strict=True):
            turned = vector
            for k, direction in inside:
                turned = rotation(direction, -float(angles[k])) @ turned
            seen.append(mount_of(manifest, label).T @ turned)
        return np.array(seen).reshape(-1, 3)


def axes_of_table(evidence: ClauseEvidence) -> AxesOfTable | None:
    """None where encoders do not show how the table stood in every segment."""
    angles = [table_angles(evidence.recording, label) for label in evidence.labels]
    if not angles or not all(len(each) and np.isfinite(each).all() for each in angles):
        return None
    turns = np.array([np.ptp(each, axis=0) > TURNED for each in angles])
    return AxesOfTable(np.array([each.mean(axis=0) for each in angles]), turns)
