"""Curves for the figures of a certificate, computed from a run beside its results."""

from collections.abc import Sequence

from schemas.calibration import Calibration
from schemas.curve import Curve
from schemas.recording import Recording
from tasks.curves.allan import allan_curves
from tasks.curves.rate_residuals import rate_residuals
from tasks.curves.tumble import tumble
from tasks.specifications.register import SPECIFICATIONS


def curves_of_run(recording: Recording, calibration: Calibration) -> tuple[Curve, ...]:
    """Residuals over the rate, of the tumble, and the Allan deviation of the rests.

    Each only if the run has the data for it. Nothing for a result with other segments than the
    recording has now, whose means cannot be assigned.
    """
    specification = SPECIFICATIONS[calibration.method]
    evidence = specification.gather(recording)
    now = [segment.segment.name for segment in evidence.segments]
    if now != [segment.name for segment in calibration.segments]:
        return ()
    sensor = specification.rate_sensor
    made: Sequence[Curve] = (
        *rate_residuals(evidence, calibration, sensor),
        *tumble(evidence, calibration),
        *allan_curves(evidence, calibration, sensor),
    )
    return tuple(made)
