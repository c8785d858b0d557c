"""JJF 1536-2015, clause 7: scale factor, zero offset and misalignment of an AHRS."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from schemas.base import Unusable
from schemas.recording import ANGLE, AXES, GYRO, Recording
from schemas.text import Remark
from tasks.segments.find import Conditions
from tasks.specifications.course import course_remarks, with_course
from tasks.specifications.estimate import (
    AHRS_ITEMS,
    DEG,
    ClauseResult,
    Section,
    Specification,
    merged,
    scaled,
    with_equipment,
)
from tasks.specifications.jjf1536.evidence import AhrsEvidence, gather_ahrs, is_zero_position
from tasks.specifications.jjf1536.misalignment import MISALIGNMENT, misalignment_items
from tasks.specifications.jjf1536.zero import SCALE_FACTOR, ZERO_OFFSET, scale_items, zero_items
from tasks.specifications.unit_model import doubled, errors_of_unit, mean_motion, mean_rates
from tasks.uncertainty.equipment import JJF1536 as EQUIPMENT
from tasks.uncertainty.equipment import Equipment
from tasks.words import message, remark

CONDITIONS = Conditions(
    dwell_s=20.0,
    dwell_clause="7.1.1 d)",
    steadiness=5e-4,
    steadiness_clause="7.1.1 d)",
    temperature_degc=(17.0, 23.0),
    humidity_percent=(30.0, 85.0),
    environment_clause="6.2.1",
)
FEWEST_WRAPS = 3
SLOWEST_SAMPLING = 10.0  # Hz
LOST = 0.5  # Hz: fewer were lost, not sampled more slowly


def check(recording: Recording) -> None:
    """Raises Unusable where neither angles nor rates were recorded, or angles that wrap around."""
    columns = recording.imu.columns
    if not all(name in columns for name in ANGLE) and not all(name in columns for name in GYRO):
        raise Unusable(
            f"{recording.manifest.recording_id} has neither angle_x, angle_y, angle_z nor gyro_* "
            "columns, which JJF 1536 calibrates; record the angles that the AHRS accumulates"
        )
    for name in ANGLE:
        if name in columns:
            _check_wrapping(recording.manifest.recording_id, name, columns[name])


def _check_wrapping(recording_id: str, name: str, angle: np.ndarray) -> None:
    """Raises Unusable if an angle wraps once a turn instead of being accumulated.

    A jump back of about a whole turn, between rows that move by less than a quarter, is a wrap; a
    single one may be a disturbance, and is treated as such.
    """
    step = np.diff(angle)
    quiet = np.abs(step) < 0.5 * np.pi
    jumps = np.flatnonzero(
        (np.abs(np.abs(step[1:-1]) - 2.0 * np.pi) < 0.5 * np.pi) & quiet[:-2] & quiet[2:]
    )
    inside = np.abs(angle).max() <= 2.0 * np.pi
    if inside and len(jumps) >= FEWEST_WRAPS:
        row = int(jumps[0]) + 3
        raise Unusable(
            f"{recording_id}: column {name}, row {row}: the angle jumps by "
            f"{np.degrees(step[row - 2]):+.0f}°, and {len(jumps) - 1} times more: it wraps "
            "once a turn, but JJF 1536 needs the accumulated angle; unwrap it first"
        )


def estimate(evidence: AhrsEvidence, equipment: Equipment) -> ClauseResult:
    """Scale factor (1), zero offset (deg/s) and misalignment (deg).

    Of the accumulated angles angle_* where they were recorded, else of the rates gyro_*.
    """
    motion, _ = mean_motion(evidence)
    rate = mean_rates(evidence)
    ideal = errors_of_unit(evidence, motion, equipment)
    if not (evidence.hidden_by_steps or evidence.loses_steady_rates):
        pointed = replace(motion, up=np.where(np.isfinite(evidence.north), motion.up, np.nan))
        evidence = with_course(evidence, pointed, ideal, len(AXES))
    scale, zero = scale_items(evidence, rate, ideal), zero_items(evidence, ideal)
    offset = zero.items[ZERO_OFFSET].elements
    misalignment = misalignment_items(evidence, rate, scale.items[SCALE_FACTOR].elements, offset)
    result = merged(
        (
            scale,
            zero,
            misalignment,
            ClauseResult(remarks=(*course_remarks(evidence), *_sampling_remarks(evidence))),
        )
    )
    found = {
        "gyro_matrix": doubled(scale.items[SCALE_FACTOR].elements)
        | scaled(misalignment.items[MISALIGNMENT].elements, 1.0 / DEG),
        "gyro_bias": scaled(offset, 1.0 / DEG),
    }
    return with_equipment(result, errors_of_unit(evidence, motion, equipment, found))


def _sampling_remarks(evidence: AhrsEvidence) -> Iterator[Remark]:
    """Rests and turns (7.2.1, 7.3.1) that were sampled more slowly."""
    slow = {
        segment.segment.name: segment.rows / segment.seconds
        for i, segment in enumerate(evidence.segments)
        if (is_zero_position(segment) or any(i in turns for turns in evidence.turns.values()))
        and segment.rows / segment.seconds < SLOWEST_SAMPLING - LOST
    }
    if slow:
        text = message(
            "jjf1536-slow-sampling", count=len(slow), rate=f"{min(slow.values()):.3g}",
            asked=f"{SLOWEST_SAMPLING:.0f}",
        )  # fmt: skip
        yield remark("slow_sampling", text, tuple(slow), blocks_pass=True)


JJF1536 = Specification(
    method="jjf1536",
    standard="JJF 1536-2015",
    procedure="JJF 1536-2015, 7",
    items=AHRS_ITEMS,
    required=tuple(item.key for item in AHRS_ITEMS),
    conditions=CONDITIONS,
    interval_months=24,  # clause 9
    layout=(  # Appendix C
        Section("ahrs-scale-factors", ("ahrs_scale_factor",)),
        Section("ahrs-zero-offsets", ("ahrs_zero_offset",)),
        Section("ahrs-misalignment", ("ahrs_misalignment",)),
    ),
    equipment=EQUIPMENT,
    equipment_source="JJF 1536-2015, Table 1",
    check=check,
    gather=gather_ahrs,
    estimate=estimate,
    reported_conditions=(
        "dwell", "positions", "zero-positions", "turns", "attitudes", "mounting",
    ),
    rate_sensor="ahrs",
)  # fmt: skip
