"""How the axes of a table stood in each segment, by its encoders or by the labels."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from schemas.text import Remark
from tasks.motion.table import (
    axis_directions,
    labelled_direction,
    mount_of,
    rotation,
    table_angles,
)
from tasks.motion.whole import unit_vector
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import message, remark

SAME_ANGLE = 0.01  # degrees: a table set twice within this was set to the same angle
VERTICAL = np.array([0.0, 0.0, 1.0])
PARALLEL = math.cos(math.radians(1.0))
TURNED = math.radians(1.0)  # of an axis within a segment: less is its servo


@dataclass(frozen=True)
class AxesOfTable:
    """How the axes of a table stood.

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
    """By the encoders, else as the labels say; None where neither shows it in every segment."""
    angles = [table_angles(evidence.recording, label) for label in evidence.labels]
    if not angles or not all(len(each) and np.isfinite(each).all() for each in angles):
        return _by_labels(evidence)
    turns = np.array([np.ptp(each, axis=0) > TURNED for each in angles])
    return AxesOfTable(np.array([each.mean(axis=0) for each in angles]), turns)


def _by_labels(evidence: ClauseEvidence) -> AxesOfTable | None:
    """Of a table that is described, with a vertical outermost axis, which alone turns.

    The outermost axis stands at the label's heading, those inside it at right angles that bring the
    labelled axis up: of several those nearest to zero, the innermost alone to either side.
    """
    directions = axis_directions(evidence.recording.manifest.station)
    if not len(directions) or abs(directions[0] @ VERTICAL) < PARALLEL or not evidence.labels:
        return None
    polar, azimuth = (0.0, 90.0, 180.0), (0.0, 90.0, -90.0, 180.0)
    inside = [polar] * (len(directions) - 2) + [azimuth] * (len(directions) > 1)
    rows = []
    for up, label in zip(evidence.up, evidence.labels, strict=True):
        if up is None or (label.axis or up[1]) != up[1]:
            return None
        manifest = evidence.recording.manifest
        shown = mount_of(manifest, label) @ labelled_direction(manifest, label, unit_vector(up))
        bring = [d for d in product(*inside) if shown @ _vertical(directions, d) > PARALLEL]
        if not bring:
            return None
        nearest = min(bring, key=lambda degrees: sum(map(abs, degrees)))
        rows.append([math.radians(angle) for angle in (label.turn_deg or 0.0, *nearest)])
    turns = np.zeros((len(rows), len(directions)), bool)
    turns[:, 0] = [label.kind != "static" for label in evidence.labels]
    return AxesOfTable(np.array(rows), turns)


def _vertical(directions: list[np.ndarray], degrees: tuple[float, ...]) -> np.ndarray:
    """The vertical (3,) as the payload sees it, with the axes inside the outermost one set so."""
    seen = VERTICAL
    for direction, angle in zip(directions[1:], degrees, strict=True):
        seen = rotation(direction, -math.radians(angle)) @ seen
    return seen


def stand_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Says how it is known how the table stood, where encoders do not show it."""
    if not evidence.has_table:
        known = "labelled" if axes_of_table(evidence) is not None else "unknown"
        yield remark("table_by_labels", message(f"specifications-stand-{known}"))
