"""The conditions under which the patent's claims 2 to 4 have the samples taken."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from schemas.calibration import Remark
from schemas.recording import AXES, Axis
from tasks.specifications.evidence import UPS, Evidence

FEWEST_RATES = 4  # claim 4, in each direction


def claim_remarks(evidence: Evidence) -> Iterator[Remark]:
    """Turns forward and back at four or more rising rates, in six orientations, then a rest."""
    few = [name for axis in AXES for name in _few(evidence, axis)]
    if few:
        yield Remark(
            code="number_of_rates",
            en=f"Fewer than {FEWEST_RATES} rates: {', '.join(few)}; the joint method asks for "
            f"{FEWEST_RATES} or more forward and back about each axis, the largest included.",
            zh=f"角速率点少于 {FEWEST_RATES} 个：{'，'.join(few)}；联合法要求各轴正、反转各不少于 "
            f"{FEWEST_RATES} 个角速率点，并包括最大角速率。",
            blocks_pass=True,
        )
    turned = {evidence.up[i] for axis in AXES for i in _recorded(evidence, axis)}
    absent = [up for up in UPS if up not in turned]
    if absent and len(absent) < len(UPS):
        yield Remark(
            code="orientations_not_turned",
            en=f"Not turned with {', '.join(absent)} up; claim 3 turns in all six orientations.",
            zh=f"未在 {', '.join(absent)} 朝天时转动；专利权利要求 3 为六个方向均转动。",
        )
    falling = [axis for axis in AXES if not _rising(evidence, axis)]
    if falling:
        listed = ", ".join(falling)
        yield Remark(
            code="rates_not_rising",
            en=f"{listed}: the rates were not taken in rising order, as claim 4 has it.",
            zh=f"{listed} 轴：角速率未按权利要求 4 由小到大的顺序。",
        )


def _recorded(evidence: Evidence, axis: Axis) -> tuple[int, ...]:
    """The points about an axis at which the gyro was recorded; all where the unit has no gyro."""
    gyro = [segment.has_gyro for segment in evidence.segments]
    return tuple(i for i in evidence.points[axis] if gyro[i] or not any(gyro))


def _few(evidence: Evidence, axis: Axis) -> Iterator[str]:
    """Directions of turning about an axis with too few rates, and how many they have."""
    rates = np.round(np.degrees(evidence.rate[list(_recorded(evidence, axis))]), 1)
    for sign, mark in ((1, "+"), (-1, "-")):
        count = len({rate for rate in rates if rate * sign > 0})
        if count < FEWEST_RATES:
            yield f"{mark}{axis} {count}"


def _rising(evidence: Evidence, axis: Axis) -> bool:
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
