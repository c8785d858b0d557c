"""Remarks on a joint calibration: procedure, Earth's rotation, the reference."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from schemas.recording import AXES, UPS, Axis
from schemas.text import Remark
from tasks.specifications.earth_gain import earth_rotation_message
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.joint.gravity_fit import GravityFit
from tasks.specifications.joint.moves import MovesFit
from tasks.specifications.joint.segment_motion import SegmentMotion
from tasks.specifications.joint.solution import Joint
from tasks.words import message, remark

FEWEST_RATES = 4  # claim 4 of the patent, in each direction


def procedure_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Claims 2 to 4: turns forward and back at four or more rising rates, in six orientations."""
    few = tuple(name for axis in AXES for name in _few(evidence, axis))
    if few:
        phrase = message("joint-number-of-rates", fewest=FEWEST_RATES, rates=few)
        yield remark("number_of_rates", phrase, blocks_pass=True)
    turned = {evidence.up[i] for axis in AXES for i in _recorded(evidence, axis)}
    absent = [up for up in UPS if up not in turned]
    if absent and len(absent) < len(UPS):
        phrase = message("joint-orientations-not-turned", ups=", ".join(absent))
        yield remark("orientations_not_turned", phrase)
    falling = [axis for axis in AXES if not _rising(evidence, axis)]
    if falling:
        phrase = message("joint-rates-not-rising", axes=", ".join(falling))
        yield remark("rates_not_rising", phrase)


def earth_remarks(
    evidence: ClauseEvidence, joint: Joint, motion: SegmentMotion
) -> Iterator[Remark]:
    """What was done with Earth's rotation."""
    latitude = evidence.latitude_deg
    if not motion.gyro.any():
        return
    if latitude is None:
        yield remark("earth_not_removed", message("joint-earth-not-removed"))
        return
    shown = earth_rotation_message(joint.earth)
    if joint.earth and joint.earth.refuted:
        yield remark("earth_rotation_not_shown", message("joint-earth-not-shown", shown=shown))
        return
    removed = message("joint-earth-removed", shown=shown, latitude=f"{latitude:g}")
    yield remark("earth_removed", removed)
    if (motion.zero & ~np.isfinite(motion.mean.north).all(axis=1)).any():
        yield remark("north_unknown", message("joint-north-unknown"))
    if not all(joint.estimates["gyro_matrix"][axis * 2].determined for axis in AXES):
        yield remark("scale_factor_assumed", message("earth-rotation-scale-factor-assumed"))


def gravity_remarks(
    evidence: ClauseEvidence, fitted: GravityFit | None, moved: MovesFit | None
) -> Iterator[Remark]:
    """The reference, how well rests and moves follow the model, and Earth's rotation."""
    yield remark("gravity_alone", message("joint-gravity-alone"), blocks_pass=True)
    if fitted is not None:
        rests, rms = len(fitted.misses), f"{np.sqrt(np.mean(fitted.misses**2)):.2g}"
        phrase = message("joint-gravity-residual", rests=rests, rms=rms)
        if fitted.excess.factor > 1.0:
            factor = f"{fitted.excess.factor:.1f}"
            phrase = message("joint-gravity-residual-excess", rests=rests, rms=rms, factor=factor)
        yield remark("gravity_residual", phrase)
    if moved is not None:
        angle = f"{np.degrees(moved.miss):.2g}"
        phrase = message("joint-moves-residual", moves=moved.moves, angle=angle)
        yield remark("moves_residual", phrase)
    if evidence.latitude_deg is None:
        yield remark("earth_not_removed", message("joint-earth-not-removed"))
    else:
        yield remark("north_unknown", message("joint-vertical-removed"))


def _recorded(evidence: ClauseEvidence, axis: Axis) -> tuple[int, ...]:
    """The points about an axis at which the gyro was recorded; all where the unit has no gyro."""
    gyro = [segment.has_gyro for segment in evidence.segments]
    return tuple(i for i in evidence.points[axis] if gyro[i] or not any(gyro))


def _few(evidence: ClauseEvidence, axis: Axis) -> Iterator[str]:
    """Directions of turning about an axis with too few rates, and how many they have."""
    rates = np.round(np.degrees(evidence.rate[list(_recorded(evidence, axis))]), 1)
    for sign, mark in ((1, "+"), (-1, "-")):
        count = len({rate for rate in rates if rate * sign > 0})
        if count < FEWEST_RATES:
            yield f"{mark}{axis} {count}"


def _rising(evidence: ClauseEvidence, axis: Axis) -> bool:
    """Whether the rates of each direction and orientation rise in time."""
    points = sorted(_recorded(evidence, axis), key=lambda i: evidence.segments[i].t_start)
    for sign in (1, -1):
        for up in {evidence.up[i] for i in points}:
            sizes = [
                abs(evidence.rate[i])
                for i in points
                if evidence.up[i] == up and evidence.rate[i] * sign > 0
            ]
            if any(b < 0.99 * a for a, b in pairwise(sizes)):
                return False
    return True
