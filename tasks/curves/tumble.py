"""Residuals of the readings in the tumble positions from the certificate's model."""

from collections.abc import Iterator

import numpy as np

from schemas.calibration import Calibration, Item
from schemas.curve import Curve
from schemas.recording import AXES, UPS, Up
from tasks.curves.points import chosen, short
from tasks.specifications.evidence import ClauseEvidence

TRIAD = ("accel_scale_factor", "accel_cross_coupling", "accel_bias")


def tumble(evidence: ClauseEvidence, calibration: Calibration) -> Iterator[Curve]:
    """Reading − (K·g + B) of each accelerometer in every position, m/s²; x: their number.

    U: of the model in that position, by the coefficient along the axis up and the bias.
    """
    held = [(up, i) for up in UPS for i in evidence.positions[up]]
    if not held or evidence.gravity is None or not all(name in calibration.items for name in TRIAD):
        return
    held = [held[k] for k in chosen(len(held))]
    labels = tuple(up for up, _ in held)
    for axis in AXES:
        points = [_point(calibration, axis, up, i, evidence.gravity) for up, i in held]
        known = [point for point in points if point is not None]
        if len(known) == len(points):
            y, U = zip(*known, strict=True)
            x = range(1, len(known) + 1)
            yield Curve(
                figure="tumble", quantity="accel_bias", axis=axis, x_unit="1", y_unit="m/s2",
                x=short(x), y=short(y), U=short(U), labels=labels,
                k=calibration.items["accel_bias"].k,
            )  # fmt: skip


def _point(
    calibration: Calibration, axis: str, up: Up, segment: int, gravity: float
) -> tuple[float, float] | None:
    """Residual and U of one accelerometer in one position; None where a number is missing."""
    scale, cross, bias = (calibration.items[name] for name in TRIAD)
    along: Item = scale if up[1] == axis else cross
    element = axis if along is scale else axis + up[1]
    read = calibration.segments[segment].mean.get(f"accel_{axis}")
    K, of_scale = along.value.get(element), along.u.get(element)
    B, of_bias = bias.value.get(axis), bias.u.get(axis)
    if read is None or K is None or B is None or of_scale is None or of_bias is None:
        return None
    felt = gravity if up[0] == "+" else -gravity
    return read - K * felt - B, bias.k * float(np.hypot(of_scale * felt, of_bias))
