"""Whether a run with a fault ended as it should, held against the same run without one.

Values of a run that is not invalid stand, and must be those of the run without a fault.
"""

import numpy as np

from schemas.recording import ACCEL, GYRO, MEASURED, Recording, Segment
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.evaluation import evaluation_for
from tasks.specifications.register import specification_for
from tests.proof.faults.outcome import Outcome

LONGEST_SENTENCE = 600
GYRO_TOLERANCE, ACCEL_TOLERANCE = np.radians(0.05), 0.01  # rad/s, m/s²: ten times the noise
TABLE_TOLERANCE = np.radians(0.05)  # rad/s
LEAST_ROWS = 0.985  # of those that the sound run has; a unit's clock that is 1 % fast is no loss
OUT_OF_LIMITS = ("chamber_hot", "chamber_cold", "chamber_humid", "supply_low")


def violations(name: str, outcome: Outcome, sound: Recording) -> list[str]:
    """What must not be; sound: the run without the fault."""
    found = [] if outcome.is_at_rest is not False else ["the table still turns"]
    if outcome.recording is None:
        if not outcome.sentence or "\n" in outcome.sentence:
            found.append("it did not end with one sentence")
        elif len(outcome.sentence) > LONGEST_SENTENCE:
            found.append(f"its sentence has {len(outcome.sentence)} characters")
        return found
    judged = verdict(outcome.recording)
    if judged == "invalid":
        return found
    found += _wrong_values(outcome.recording, sound)
    if name in OUT_OF_LIMITS and judged == "valid":
        found.append("it is valid, out of its limits")
    return found


def verdict(recording: Recording) -> str:
    """The verdict on the run, as `acquire` gives it."""
    calibration = calibrate(
        specification_for(recording.manifest.standard), recording, run="", code_version="",
        evaluation=evaluation_for(recording),
    )  # fmt: skip
    return calibration.validity.verdict


def kind(outcome: Outcome) -> str:
    """stopped, repeated, invalid, remarks or recovered."""
    if outcome.recording is None or outcome.acquired is None:
        return "stopped"
    judged = verdict(outcome.recording)
    if judged != "valid":
        return judged
    codes = {remark.code for remark in outcome.acquired.warnings}
    return "repeated" if "segment_repeated" in codes else "recovered"


def _wrong_values(recording: Recording, sound: Recording) -> list[str]:
    """Segments of a valid run whose means are not those of the sound one, or that are not whole."""
    wanted = {segment.name: segment for segment in _measured(sound)}
    found = [
        f"{segment.name} is wrong"
        for segment in _measured(recording)
        if not _agree(recording, segment, sound, wanted[segment.name])
    ]
    missing = wanted.keys() - {segment.name for segment in _measured(recording)}
    return found + [f"{name} is missing" for name in sorted(missing)]


def _measured(recording: Recording) -> list[Segment]:
    return [s for s in recording.manifest.segments or () if s.kind in MEASURED]


def _agree(recording: Recording, segment: Segment, sound: Recording, other: Segment) -> bool:
    (gyro, accel, table, rows), wanted = _figures(recording, segment), _figures(sound, other)
    return bool(
        np.abs(gyro - wanted[0]).max() < GYRO_TOLERANCE
        and np.abs(accel - wanted[1]).max() < ACCEL_TOLERANCE
        and np.abs(table - wanted[2]).max() < TABLE_TOLERANCE
        and rows > LEAST_ROWS * wanted[3] * _length(segment) / _length(other)
    )


def _length(segment: Segment) -> float:
    return segment.t_end - segment.t_start


def _figures(
    recording: Recording, segment: Segment
) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Medians of gyro and accelerometer, mean rates of the table's axes, samples of the unit.

    Medians, because the estimation leaves far samples out, too.
    """
    imu, table = recording.imu, recording.table
    assert table is not None
    rows, turned = (stream.rows(segment.t_start, segment.t_end) for stream in (imu, table))
    angles = np.array([values[turned] for values in table.columns.values()])
    t = table.t[turned]
    rates = (angles[:, -1] - angles[:, 0]) / (t[-1] - t[0])
    return (
        np.median(imu.channels(GYRO, rows), axis=1),
        np.median(imu.channels(ACCEL, rows), axis=1),
        rates,
        rows.stop - rows.start,
    )
