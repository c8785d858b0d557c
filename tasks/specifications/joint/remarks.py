"""Remarks on a joint calibration: procedure, Earth's rotation, the reference."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from schemas.recording import AXES, UPS, Axis
from schemas.text import Remark
from tasks.specifications.estimate import (
    DEG,
    Estimates,
    ItemEstimate,
    diagonal,
    off_diagonal,
    scaled,
    undetermined,
)
from tasks.specifications.evidence import ClauseEvidence, earth_rotation_message
from tasks.specifications.joint.moves import FEWEST_RESTS, GravityFit, MovesFit
from tasks.specifications.joint.solution import Joint, SegmentMotion
from tasks.words import Message, Sayable, clauses, message, remark

CLAUSES = {"gyro": "JJF 2003-2022, 5.1 eq. (1)", "accel": "JJF 2003-2022, 5.2 eq. (2)"}
NO_GRAVITY = message("specifications-no-gravity")
NOT_DISTINGUISHED = message("joint-not-distinguished")
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


def level_unknown(motion: SegmentMotion, evidence: ClauseEvidence, up: str) -> bool:
    """Whether a rest with this axis up feels an unknown horizontal part of Earth's rotation."""
    of_face = [i for i, shown in enumerate(evidence.up) if shown == up]
    return bool((motion.zero & motion.level_unknown)[of_face].any())


def table_reasons(
    items: Mapping[str, ItemEstimate], motion: SegmentMotion, evidence: ClauseEvidence
) -> dict[str, Sayable]:
    """The reasons by item, with attitudes and rates known."""
    absent, no_rest = _not_rested(evidence, motion.zero), _not_rested(evidence, motion.accel)
    unturned = [axis for axis, turned in zip(AXES, motion.turned, strict=True) if not turned]
    unread, unfelt = _not_held(evidence, motion.gyro), _not_held(evidence, motion.accel)
    matrix = _lacking("joint-not-turned-gyro", axes=unturned)
    zero = _lacking("joint-no-rest-gyro", ups=absent)
    accel = _lacking("joint-no-rest-accel", ups=no_rest)
    coupled = accel if evidence.gravity is not None else NO_GRAVITY
    level = ", ".join(up for up in UPS if level_unknown(motion, evidence, up))
    sensitivity: Sayable = zero
    if level:
        horizontal = message("joint-horizontal-unknown", ups=level)
        sensitivity = horizontal if zero == NOT_DISTINGUISHED else clauses([zero, horizontal])
    return _of_elements(items, {
        "gyro_scale_factor": matrix,
        "gyro_cross_coupling": matrix,
        "gyro_fit_offset": _lacking("joint-not-turned-gyro", axes=unread),
        "gyro_bias": zero,
        "gyro_g_sensitivity": sensitivity,
        "accel_scale_factor": coupled,
        "accel_cross_coupling": coupled,
        "accel_bias": accel,
        "accel_rate_sensitivity": _lacking("joint-not-turned-accel", axes=unfelt),
    })  # fmt: skip


def gravity_reasons(
    evidence: ClauseEvidence, items: Mapping[str, ItemEstimate], fitted: bool, rests: int
) -> dict[str, Sayable]:
    """The reasons by item, with gravity alone; fitted: whether the rests were enough."""
    causes: dict[str, Sayable] = dict.fromkeys(items, message("joint-no-moves"))
    causes["accel_cross_coupling"] = message("joint-coupling-by-definition")
    held = message("joint-no-rate-held")
    causes["gyro_fit_offset"] = causes["accel_rate_sensitivity"] = held
    if not fitted:
        few = message("joint-few-rests", rests=rests, fewest=FEWEST_RESTS)
        causes = dict.fromkeys(items, NO_GRAVITY if evidence.gravity is None else few)
    return _of_elements(items, causes)


def _of_elements(
    items: Mapping[str, ItemEstimate], causes: Mapping[str, Sayable]
) -> dict[str, Sayable]:
    return {
        key: message("joint-of-elements", elements=", ".join(item.undetermined), reason=causes[key])
        for key, item in items.items()
        if item.undetermined
    }


def _lacking(text: str, **listed: Sequence[str]) -> Message:
    """What is missing; if nothing is, the segments do not separate the parameter from others."""
    if not any(listed.values()):
        return NOT_DISTINGUISHED
    return message(text, **{name: ", ".join(values) for name, values in listed.items()})


def _not_rested(evidence: ClauseEvidence, used: np.ndarray) -> list[str]:
    """The axes up of which no rest may be used; used: (n,) bool."""
    return [up for up, rests in evidence.rests.items() if not used[list(rests)].any()]


def _not_held(evidence: ClauseEvidence, used: np.ndarray) -> list[str]:
    return [axis for axis in AXES if not any(used[i] for i in evidence.points[axis])]


def joint_items(
    evidence: ClauseEvidence,
    parameters: Mapping[str, Estimates],
    method: str,
    readings: Mapping[str, tuple[str, ...]],
) -> dict[str, ItemEstimate]:
    """The nine items, in the units of their results.

    parameters: by term, in SI units, with the fit offset beside them; method: as the clauses name
    it; readings: of each item.
    """
    gyro, accel = parameters["gyro_matrix"], parameters["accel_matrix"]
    elements = {
        "gyro_scale_factor": diagonal(gyro),
        "gyro_cross_coupling": off_diagonal(gyro),
        "gyro_fit_offset": scaled(parameters["gyro_fit_offset"], DEG),
        "gyro_bias": scaled(parameters["gyro_bias"], DEG),
        "gyro_g_sensitivity": scaled(parameters["gyro_g_sensitivity"], DEG),
        "accel_scale_factor": diagonal(accel),
        "accel_cross_coupling": off_diagonal(accel),
        "accel_bias": parameters["accel_bias"],
        "accel_rate_sensitivity": scaled(parameters["accel_rate_sensitivity"], -1.0),
    }
    without_earth = elements["gyro_g_sensitivity"]
    if evidence.latitude_deg is None:
        without_earth = undetermined(without_earth)
    return {
        key: ItemEstimate(
            of_item,
            f"{CLAUSES[key.partition('_')[0]]}, {method}",
            readings[key],
            without_earth if key == "gyro_g_sensitivity" else None,
        )
        for key, of_item in elements.items()
    }
