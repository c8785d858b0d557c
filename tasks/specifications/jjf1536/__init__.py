"""JJF 1536-2015, clause 7: scale factor, zero offset and misalignment of an AHRS."""

from collections.abc import Iterator

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Calibration, Remark
from schemas.recording import ANGLE, GYRO, Recording
from tasks.segments.conditions import Conditions
from tasks.segments.units import wrong_rate_unit
from tasks.specifications.assemble import assemble
from tasks.specifications.evaluation import Evaluation, evaluation_for
from tasks.specifications.jjf1536.evidence import AhrsEvidence, gather_ahrs, is_zero_position
from tasks.specifications.jjf1536.misalignment import misalignment_items
from tasks.specifications.jjf1536.scale import scale_items
from tasks.specifications.jjf1536.zero import zero_items
from tasks.specifications.parts import Part, joined

PROCEDURE = "JJF 1536-2015, 7"
CONDITIONS = Conditions(
    dwell_s=20.0,
    dwell_clause="7.1.1 d)",
    steadiness=5e-4,
    steadiness_clause="7.1.1 d)",
    temperature_degc=(17.0, 23.0),
    humidity_percent=(30.0, 85.0),
    room_clause="6.2.1",
)
ORDER = ("ahrs_scale_factor", "ahrs_zero_offset", "ahrs_misalignment")
SLOWEST_SAMPLING = 10.0  # Hz, 7.2.1 and 7.3.1
FEWEST_WRAPS = 3
LOST = 0.5  # Hz: fewer were lost, not sampled more slowly


def calibrate(
    recording: Recording, *, run: str, code_version: str, evaluation: Evaluation | None = None
) -> Calibration:
    """Estimate scale factor (1), zero offset (deg/s) and misalignment (deg) of JJF 1536-2015.

    Of the accumulated angles angle_* where they were recorded, else of the rates gyro_*.
    evaluation: of the uncertainties; by the law of propagation with the limits of the recording's
    specification where it is not given.
    Raises Unusable where the recording holds neither, or in another unit.
    """
    columns = recording.imu.columns
    if not all(name in columns for name in ANGLE) and not all(name in columns for name in GYRO):
        raise Unusable(
            f"{recording.manifest.recording_id}: there are no angle_x, angle_y, angle_z columns "
            "and no gyro_* columns in their place, which JJF 1536 calibrates; record the angles "
            "that the AHRS accumulates"
        )
    _check_wrapping(recording)
    evaluation = evaluation or evaluation_for(recording)
    evidence = gather_ahrs(recording)
    wrong = wrong_rate_unit(evidence.segments)
    if wrong is not None:
        told = wrong.replace("gyro columns in rad/s", "angle columns in rad")
        told = told.replace("gyro columns", "angle columns") if evidence.by_angle else wrong
        raise Unusable(f"{recording.manifest.recording_id}: {told}")
    scale = scale_items(evidence, evaluation)
    zero, offset = zero_items(evidence, evaluation)
    turns = misalignment_items(evidence, offset, evaluation)
    sampling = Part(remarks=tuple(_sampling(evidence)))
    calibration = assemble(
        evidence.recording,
        evidence,
        joined((scale, zero, turns, sampling)),
        method="jjf1536",
        procedure=PROCEDURE,
        order=ORDER,
        conditions=CONDITIONS,
        evaluation=evaluation,
        run=run,
        code_version=code_version,
    )
    if not evidence.by_angle:
        return calibration
    return calibration.model_copy(
        update={"remarks": tuple(_of_angles(evidence, calibration.remarks))}
    )


def _check_wrapping(recording: Recording) -> None:
    """Raises Unusable where an angle starts anew each turn: it is not accumulated.

    A jump back of about a whole turn, between rows that move by less than a quarter, is one; a
    single one may be a disturbance, and is treated as that.
    """
    for name in ANGLE:
        if name not in recording.imu.columns:
            continue
        step = np.diff(recording.imu.columns[name])
        quiet = np.abs(step) < 0.5 * np.pi
        jumps = np.flatnonzero(
            (np.abs(np.abs(step[1:-1]) - 2.0 * np.pi) < 0.5 * np.pi) & quiet[:-2] & quiet[2:]
        )
        inside = np.abs(recording.imu.columns[name]).max() <= 2.0 * np.pi
        if inside and len(jumps) >= FEWEST_WRAPS:
            row = int(jumps[0]) + 3
            raise Unusable(
                f"{recording.manifest.recording_id}: column {name}, row {row}: the angle jumps by "
                f"{np.degrees(step[row - 2]):+.0f}°, and {len(jumps) - 1} times more: it starts "
                "anew each turn; JJF 1536 takes the accumulated angle, so unwrap it first"
            )


def _sampling(evidence: AhrsEvidence) -> Iterator[Remark]:
    """7.2.1 and 7.3.1 ask for ten readings a second or more."""
    slow = {
        segment.segment.name: segment.rows / segment.seconds
        for i, segment in enumerate(evidence.segments)
        if (is_zero_position(segment) or any(i in turns for turns in evidence.turns.values()))
        and segment.rows / segment.seconds < SLOWEST_SAMPLING - LOST
    }
    if slow:
        least = min(slow.values())
        yield Remark(
            code="slow_sampling",
            en=f"{len(slow)} segments were sampled at {least:.3g} Hz; 7.2.1 and 7.3.1 ask for "
            f"{SLOWEST_SAMPLING:.0f} Hz or more.",
            zh=f"{len(slow)} 段的采样率为 {least:.3g} Hz；7.2.1 和 7.3.1 要求不少于 "
            f"{SLOWEST_SAMPLING:.0f} Hz。",
            segments=tuple(slow),
            blocks_pass=True,
        )


def _of_angles(evidence: AhrsEvidence, remarks: tuple[Remark, ...]) -> Iterator[Remark]:
    """Remarks on the increments, said of the angle columns that were recorded.

    An angle that moves by less than its resolution in the time that a channel may stand still
    is not stuck.
    """
    for remark in remarks:
        if remark.code == "stuck" and evidence.coarse:
            continue
        yield remark.model_copy(
            update={
                "en": remark.en.replace("gyro_", "angle_"),
                "zh": remark.zh.replace("gyro_", "angle_"),
            }
        )
