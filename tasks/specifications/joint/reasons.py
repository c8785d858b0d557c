"""Why elements of a joint calibration are null, and what would determine them."""

from collections.abc import Mapping, Sequence

import numpy as np

from schemas.recording import AXES, UPS
from tasks.specifications.estimate import (
    DEG,
    Estimates,
    ItemEstimate,
    diagonal,
    off_diagonal,
    scaled,
    undetermined,
)
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.joint.gravity_fit import FEWEST_RESTS
from tasks.specifications.joint.segment_motion import SegmentMotion
from tasks.words import Message, Sayable, clauses, message

CLAUSES = {"gyro": "JJF 2003-2022, 5.1 eq. (1)", "accel": "JJF 2003-2022, 5.2 eq. (2)"}
NO_GRAVITY = message("specifications-no-gravity")
NOT_DISTINGUISHED = message("joint-not-distinguished")


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
