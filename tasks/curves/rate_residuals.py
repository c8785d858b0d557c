"""Residuals of the rate points from the line of the certificate's scale factor."""

from collections.abc import Iterator

import numpy as np

from schemas.calibration import Calibration
from schemas.curve import Curve
from schemas.recording import AXES
from tasks.curves.points import thinned
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.items import ITEMS

FEWEST = 3  # points that can be off a line
OFFSETS = {"gyro": "gyro_fit_offset", "ahrs": "ahrs_zero_offset"}


def rate_residuals(
    evidence: ClauseEvidence, calibration: Calibration, rate_sensor: str
) -> Iterator[Curve]:
    """Reading − K·rate about each axis, less its mean, over the rate of the table; °/s.

    U: of the line at that rate, of the uncertainties of its scale factor and of its offset.
    """
    scale = calibration.items.get(f"{rate_sensor}_scale_factor")
    offset = calibration.items.get(OFFSETS[rate_sensor])
    if scale is None:
        return
    for channel, axis in enumerate(AXES):
        name, K, of_scale = f"gyro_{axis}", scale.value.get(axis), scale.u.get(axis)
        points = [i for i in evidence.points[axis] if name in calibration.segments[i].mean]
        if K is None or of_scale is None or len(points) < FEWEST:
            continue
        rate = np.degrees(evidence.rate[points])
        read = np.degrees([calibration.segments[i].mean[name] for i in points])
        off = read - K * rate
        u = np.hypot(of_scale * rate, (offset.u.get(axis) if offset else None) or 0.0)
        order = np.argsort(rate, kind="stable")
        x, y, expanded = thinned(rate[order], (off - off.mean())[order], scale.k * u[order])
        yield Curve(
            figure="rate-residuals", quantity=f"{rate_sensor}_scale_factor", axis=AXES[channel],
            x_unit=ITEMS[OFFSETS[rate_sensor]].unit, y_unit=ITEMS[OFFSETS[rate_sensor]].unit,
            x=x, y=y, U=expanded, k=scale.k,
        )  # fmt: skip
