"""Deviation of the rate points from a straight line: non-linearity and asymmetry.

Source: GJB 7952-2012 and IEEE Std 1431: non-linearity is the largest residual from the line
through all points over the largest output; asymmetry is the slope of the positive rates less that
of the negative ones, over the mean of both. Residuals are those of the clauses' own line, eq. (4)
of JJF 2003 and eq. (13) of JJF 1536.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from schemas.calibration import Information, Item
from schemas.recording import AXES
from tasks.calibrate.information.entry import entry, of_axes, or_why_not, type_b
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.linear import EXCESS_LEVEL, residuals_of, solve
from tasks.words import message

PPM = 1e6


@dataclass(frozen=True)
class Ratio:
    """A ratio, its standard uncertainty, and whether it is more than noise; NaN: not known."""

    value: float = float("nan")
    u: float = float("nan")
    significant: bool = False


def line_information(
    evidence: ClauseEvidence, items: Mapping[str, Item], rate_sensor: str
) -> dict[str, Information]:
    """Non-linearity and asymmetry of the scale factor about each axis, ppm.

    Type B is that of the scale factor, relative to it; twice in the asymmetry, because the table
    may be off otherwise in either direction.
    """
    points = [_points(evidence, channel) for channel in range(3)]
    ratios = {
        "nonlinearity": [nonlinearity(*about_axis) for about_axis in points],
        "asymmetry": [asymmetry(*about_axis) for about_axis in points],
    }
    if not any(np.isfinite(ratio.value) for three in ratios.values() for ratio in three):
        return {}
    item = f"{rate_sensor}_scale_factor"
    scale = np.array(
        [(items[item].value.get(axis) if item in items else None) for axis in AXES], float
    )
    equipment = type_b(items.get(item), AXES) / np.abs(scale)
    of_ratio = {"nonlinearity": equipment, "asymmetry": np.sqrt(2.0) * equipment}
    return {
        f"{rate_sensor}_scale_{name}": _entry(name, item, three, of_ratio[name])
        for name, three in ratios.items()
    }


def nonlinearity(rate: np.ndarray, output: np.ndarray, covariance: np.ndarray) -> Ratio:
    """Largest residual (absolute) from the line of outputs (n,) over rates (n,), per full scale.

    It is significant where noise alone would give the residuals in fewer than one case of a
    hundred. Takes three different rates.
    """
    from scipy.special import chdtrc  # late: a tenth of a start

    scale = float(np.abs(output).max(initial=0.0))
    if len(set(np.round(rate, 6))) < 3 or not scale:
        return Ratio()
    design = np.column_stack([rate, np.ones(len(rate))])
    residuals = residuals_of(solve(design), design, output, covariance)
    largest = int(np.abs(residuals.values).argmax())
    chance = float(chdtrc(len(rate) - 2, residuals.chi2))
    u = float(np.sqrt(max(residuals.covariance[largest, largest], 0.0)))
    return Ratio(float(abs(residuals.values[largest])) / scale, u / scale, chance < EXCESS_LEVEL)


def asymmetry(rate: np.ndarray, output: np.ndarray, covariance: np.ndarray) -> Ratio:
    """Slope over the positive rates less that over the negative ones, over the mean slope.

    Takes two different rates each way.
    """
    from scipy.special import chdtri  # late: a tenth of a start

    slopes = []
    for side in (rate > 0, rate < 0):
        if len(set(np.round(rate[side], 6))) < 2:
            return Ratio()
        operator = np.zeros(len(rate))
        design = np.column_stack([rate[side], np.ones(side.sum())])
        operator[side] = solve(design).operator[0]
        slopes.append(operator)
    apart, mean = slopes[0] - slopes[1], float(0.5 * (slopes[0] + slopes[1]) @ output)
    if not mean:
        return Ratio()
    value, u = float(apart @ output / mean), float(np.sqrt(apart @ covariance @ apart) / abs(mean))
    return Ratio(value, u, value**2 > float(chdtri(1, EXCESS_LEVEL)) * u**2)


def _points(evidence: ClauseEvidence, channel: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rates (n,), means (n,) and their covariance of the rate points about a gyro's own axis."""
    points = [i for i in evidence.points[AXES[channel]] if evidence.segments[i].has_gyro]
    covariance = evidence.covariance(channel)[np.ix_(points, points)]
    return evidence.rate[points], evidence.means[points, channel], covariance


def _entry(name: str, item: str, ratios: list[Ratio], equipment: np.ndarray) -> Information:
    u = np.hypot([ratio.u for ratio in ratios], equipment)
    significant = [a for a, ratio in zip(AXES, ratios, strict=True) if ratio.significant]
    beyond = of_axes("information-more-than-noise", significant)
    return entry(
        name,
        "ppm",
        [ratio.value for ratio in ratios],
        u,
        message(f"information-{name}.text"),
        *(beyond or [message("information-no-more-than-noise")]),
        *or_why_not(u),
        factor=PPM,
        about=item,
    )
