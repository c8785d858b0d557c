"""The site in the manifest: gravity, latitude and heading, checked for consistency."""

from collections.abc import Iterator

import numpy as np

from schemas.text import Remark
from tasks.run_validity.covered import readings
from tasks.run_validity.earth_rate import EarthRate, earth_rate
from tasks.run_validity.remark import run_remark
from tasks.specifications.evidence import ClauseEvidence

EQUATOR, RISE, FLATTENING = 9.7803253359, 0.00193185265241, 0.00669437999014  # WGS 84
PER_METRE = 3.086e-6  # 1/s²: free-air gradient
ANOMALY = 0.003  # m/s²: what the ground does to it, 300 mGal, but for a few places at sea
INHABITED = (-430.0, 5500.0)  # m, where a laboratory may stand
BY_PRESSURE = 500.0  # m that the weather shifts a height read off the air's pressure
CONTRADICTED = 16.0  # χ² of two degrees of freedom: once in 3,000 good runs
SIGN = 3.0  # standard deviations of what the unit's own g-sensitivities have in common


def site_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Gravity that no place of that latitude and height has, and an Earth that turns otherwise."""
    yield from _gravity(evidence)
    if evidence.latitude_deg is None:
        yield run_remark("latitude_not_given")
        return
    shown = earth_rate(evidence)
    if shown is not None:
        yield from _level(shown, evidence.latitude_deg)
        yield from _vertical(shown, evidence.latitude_deg)


def _gravity(evidence: ClauseEvidence) -> Iterator[Remark]:
    """The local gravity against the normal one."""
    if evidence.gravity is None:
        yield run_remark("gravity_not_given")
        return
    latitude = evidence.latitude_deg
    heights = _heights(evidence)
    at = [normal_gravity(phi) for phi in ((0.0, 90.0) if latitude is None else (latitude,))]
    low = min(at) - PER_METRE * heights[1] - ANOMALY
    high = max(at) - PER_METRE * heights[0] + ANOMALY
    if not low <= evidence.gravity <= high:
        yield run_remark(
            "gravity_contradicted", run="invalid", gravity=f"{evidence.gravity:.5f}",
            latitude="–" if latitude is None else f"{latitude:g}", low=f"{low:.4f}",
            high=f"{high:.4f}", lowest=f"{heights[0]:.0f}", highest=f"{heights[1]:.0f}",
        )  # fmt: skip


def normal_gravity(latitude_deg: float) -> float:
    """Gravity at sea level, m/s² (Somigliana's formula, WGS 84)."""
    square = float(np.sin(np.radians(latitude_deg))) ** 2
    return EQUATOR * (1.0 + RISE * square) / float(np.sqrt(1.0 - FLATTENING * square))


def _heights(evidence: ClauseEvidence) -> tuple[float, float]:
    """Lowest and highest height (m) by the manifest, by the air's pressure, else of any place."""
    height = evidence.recording.manifest.station.height_m
    if height is not None:
        return height, height
    _, pressure = readings(evidence.recording.environment, "pressure")
    if not len(pressure):
        return INHABITED
    by_air = 44_330.0 * (1.0 - (float(np.median(pressure)) / 1013.25) ** 0.1903)
    return by_air - BY_PRESSURE, by_air + BY_PRESSURE


def _level(shown: EarthRate, latitude_deg: float) -> Iterator[Remark]:
    """The level part points north and is as long as the latitude has it."""
    expected = np.array([np.cos(np.radians(latitude_deg)), 0.0])
    if not np.isfinite(shown.level).all() or shown.chi2(expected) < CONTRADICTED:
        return
    north, east = shown.level
    absent = shown.chi2(np.zeros(2)) < CONTRADICTED
    yield run_remark(
        "earth_not_shown" if absent else "earth_contradicted",
        run="remarks" if absent else "invalid",
        north=f"{north:.2f}", east=f"{east:.2f}", expected=f"{expected[0]:.2f}",
        u=f"{np.sqrt(np.diag(shown.covariance)).max():.2f}", latitude=f"{latitude_deg:g}",
    )  # fmt: skip


def _vertical(shown: EarthRate, latitude_deg: float) -> Iterator[Remark]:
    """The vertical part has the sign of the latitude.

    A sensitivity to gravity common to all three gyros cannot be separated from it: their common
    part is expected to be no larger than their differences.
    """
    expected = float(np.sin(np.radians(latitude_deg)))
    as_given, otherwise = abs(shown.vertical - expected), abs(shown.vertical + expected)
    if as_given > SIGN * shown.u_vertical and otherwise < as_given:
        yield run_remark(
            "latitude_sign", run="invalid", latitude=f"{latitude_deg:g}",
            shown=f"{shown.vertical:+.2f}", expected=f"{expected:+.2f}",
            u=f"{shown.u_vertical:.2f}",
        )  # fmt: skip
