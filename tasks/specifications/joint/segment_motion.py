"""The motion of the unit in each segment, for the joint method.

A segment held at one attitude or rate has one mean reading and one mean motion: fitting the means
by their covariance is fitting all samples at once.
"""

from dataclasses import dataclass

import numpy as np

from schemas.recording import AXES
from tasks.motion.whole import Motion
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.jjf2003.positions import is_paired
from tasks.specifications.mean_motion import mean_motion


@dataclass(frozen=True)
class SegmentMotion:
    """The mean motion of the segments, and what each may be used for.

    mean: (n segments); a turn about the vertical has no mean north, which averages out.
    gyro, accel: (n,) bool, what may be fitted to each triad.
    alive: (6,) bool, channels that do not read one and the same number throughout.
    turned: (3,) bool, axes about which the gyro was recorded at two or more rates, or in a turn.
    zero: (n,) bool, the rests that correct gyro bias and g-sensitivity.
    level_unknown: (n,) bool, rests in which the horizontal part of Earth's rotation is not known.
    """

    mean: Motion
    gyro: np.ndarray
    accel: np.ndarray
    alive: np.ndarray
    turned: np.ndarray
    zero: np.ndarray
    level_unknown: np.ndarray

    def used(self, channel: int) -> np.ndarray:
        """(n,) bool: the segments that step 1 fits to a channel, 0 to 5."""
        triad = self.gyro if channel < len(AXES) else self.accel
        return triad & self.alive[channel]

    def zero_corrects(self, channel: int) -> np.ndarray:
        """(n,) bool: the rests that correct a channel's zero; none for an accelerometer."""
        return self.zero & (channel < len(AXES)) & self.alive[channel]


def segment_motion(evidence: ClauseEvidence) -> SegmentMotion:
    """The segments of a recording as the joint method takes them.

    Rests and rates that labels and witnesses contradict are taken as `gather` took them: the axis
    up by gravity, the rate by the encoders, or left out.
    """
    segments = evidence.segments
    motion, vertical = mean_motion(evidence)
    kind = np.array([label.kind for label in evidence.labels], str)
    still, turning = kind == "static", kind == "rate"
    steps = np.array([segment.step for segment in segments]).reshape(-1, 6)
    moved = np.isfinite(motion.rate).all(axis=1)
    gyro = np.array([segment.has_gyro for segment in segments], bool)
    accel = np.array([segment.has_accel for segment in segments], bool)
    turned, alone = _turned_by_gyro(evidence, motion, gyro & moved)
    unknown = still & vertical & ~np.isfinite(motion.north).all(axis=1)
    return SegmentMotion(
        mean=motion,
        gyro=gyro & moved & (vertical | ~still) & ~alone,
        accel=accel & moved & vertical & (still | turning),
        alive=np.asarray((steps > 0.0).any(axis=0)),
        turned=turned,
        zero=gyro & still & vertical & ~_beside_pairs(evidence, unknown),
        level_unknown=unknown & ~_paired(evidence),
    )


def _turned_by_gyro(
    evidence: ClauseEvidence, motion: Motion, read: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(3,) bool, axes that the gyro read turning, and (n,) bool, the runs about the others.

    A turn by a known angle will do, or runs at two rates: one rate is no line, and what it reads
    must not be laid upon the other axes. read: (n,) bool.
    """
    turned, alone = np.zeros(3, bool), np.zeros(len(read), bool)
    for j, axis in enumerate(AXES):
        runs = [i for i in (*evidence.points[axis], *evidence.turns[axis]) if read[i]]
        rates = set(np.round(np.degrees(motion.rate[runs, j]), 1))
        turned[j] = len(rates) > 1 or any(i in runs for i in evidence.turns[axis])
        alone[runs] = not turned[j]
    return turned, alone


def _paired(evidence: ClauseEvidence) -> np.ndarray:
    """(n,) bool: rests of a position that was held at two headings 180° apart."""
    paired = [indices for indices in evidence.positions.values() if is_paired(evidence, indices)]
    return np.isin(np.arange(len(evidence.segments)), np.concatenate([np.zeros(0), *paired]))


def _beside_pairs(evidence: ClauseEvidence, unknown: np.ndarray) -> np.ndarray:
    """(n,) bool: rests of unknown heading with an axis up that was also held as a pair.

    The pair cancels the horizontal part of Earth's rotation; such a rest would bring it back.
    """
    faces = [up for up, indices in evidence.positions.items() if is_paired(evidence, indices)]
    of_such = np.array([up in faces for up in evidence.up], bool)
    return unknown & of_such & ~_paired(evidence)
