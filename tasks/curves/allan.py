"""The Allan deviation of each channel over the longest rests of a run."""

from collections.abc import Iterator

import numpy as np

from schemas.calibration import Calibration
from schemas.curve import Curve
from schemas.recording import AXES
from tasks.calibrate.information.allan import MIN_LEVELS
from tasks.calibrate.information.noise import HOUR, allan_of_rests
from tasks.curves.points import thinned
from tasks.segments.summarise import ACCEL_COLUMNS, GYRO_COLUMNS
from tasks.specifications.estimate import DEG
from tasks.specifications.evidence import ClauseEvidence
from tasks.words.rounding import USUAL_K

LONG_ENOUGH_S = 30.0  # of a rest: as long as the specification's dwell


def allan_curves(
    evidence: ClauseEvidence, calibration: Calibration, rate_sensor: str
) -> Iterator[Curve]:
    """Overlapping Allan deviation over the averaging time in s: gyro in °/h, accelerometer in m/s².

    U: of the degrees of freedom of white noise. Nothing for a channel whose steps hide its noise,
    and nothing of readings from which a result with terms took something off.
    """
    if calibration.terms:
        return
    triads = ((rate_sensor, GYRO_COLUMNS, "deg/h", DEG * HOUR), ("accel", ACCEL_COLUMNS, "m/s2", 1))
    for quantity, columns, unit, factor in triads[: 1 if rate_sensor == "ahrs" else 2]:
        allan = allan_of_rests(evidence, columns)
        if allan is None or allan.seconds < LONG_ENOUGH_S or len(allan.curve.tau) < MIN_LEVELS:
            continue
        for channel, axis in enumerate(AXES):
            deviation = factor * np.sqrt(allan.curve.variance[:, channel])
            if allan.hidden[channel] or not deviation.all():
                continue
            U = USUAL_K * deviation / np.sqrt(2.0 * allan.curve.white_dof)
            x, y, expanded = thinned(allan.curve.tau, deviation, U)
            yield Curve(
                figure="allan", quantity=quantity, axis=axis, x_unit="s", y_unit=unit,
                x=x, y=y, U=expanded, k=USUAL_K,
            )  # fmt: skip
