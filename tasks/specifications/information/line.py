"""How far the rate points are from one straight line: non-linearity and asymmetry.

Source: GJB 7952-2012 and IEEE Std 1431: non-linearity is the largest residual from the line
through all points over the largest output; asymmetry is the slope of the positive rates less that
of the negative ones, over the mean of both. Residuals are those of the clauses' own line, eq. (4)
of JJF 2003 and eq. (13) of JJF 1536.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, chdtri

from schemas.calibration import Information
from schemas.recording import AXES
from tasks.specifications.evidence import Evidence
from tasks.specifications.information.shown import Said, shown
from tasks.specifications.linear import solve
from tasks.specifications.parts import EXCESS_LEVEL

PPM = 1e6


@dataclass(frozen=True)
class Found:
    """A ratio, its standard uncertainty, and whether it is more than noise; NaN: not known."""

    value: float = float("nan")
    u: float = float("nan")
    significant: bool = False


def line_information(evidence: Evidence, *, item: str) -> dict[str, Information]:
    """Non-linearity and asymmetry of the scale factor about each axis, ppm.

    item: the scale factor that they stand beside.
    """
    points = [_points(evidence, channel) for channel in range(3)]
    crooked = [nonlinearity(*each) for each in points]
    lopsided = [asymmetry(*each) for each in points]
    if not any(np.isfinite(found.value) for found in crooked + lopsided):
        return {}
    short = item.removesuffix("_scale_factor")
    return {
        f"{short}_scale_nonlinearity": _shown(
            ("Scale factor non-linearity", "标度因数非线性度"), item, crooked,
            ("Largest residual from the line through the rate points, over the largest output; "
             "unit and table together.",
             "各速率点对拟合直线的最大偏差与最大输出之比；含转台的影响。"),
        ),
        f"{short}_scale_asymmetry": _shown(
            ("Scale factor asymmetry", "标度因数不对称性"), item, lopsided,
            ("Slope of the positive rates less that of the negative ones, over their mean.",
             "正、反转标度因数之差与其均值之比。"),
        ),
    }  # fmt: skip


def nonlinearity(rate: np.ndarray, output: np.ndarray, covariance: np.ndarray) -> Found:
    """Largest residual (absolute) from the line of outputs (n,) over rates (n,), per full scale.

    It is significant where noise alone would give the residuals in fewer than one case of a
    hundred. Takes three different rates.
    """
    scale = float(np.abs(output).max(initial=0.0))
    if len(set(np.round(rate, 6))) < 3 or not scale:
        return Found()
    design = np.column_stack([rate, np.ones(len(rate))])
    maker = np.eye(len(rate)) - design @ solve(design).operator
    residual, spread = maker @ output, maker @ covariance @ maker.T
    most = int(np.abs(residual).argmax())
    inverse = np.linalg.pinv(spread, rcond=1e-6, hermitian=True)
    chance = float(chdtrc(len(rate) - 2, float(residual @ inverse @ residual)))
    u = float(np.sqrt(max(spread[most, most], 0.0)))
    return Found(float(abs(residual[most])) / scale, u / scale, chance < EXCESS_LEVEL)


def asymmetry(rate: np.ndarray, output: np.ndarray, covariance: np.ndarray) -> Found:
    """Slope over the positive rates less that over the negative ones, over the mean slope.

    Takes two different rates each way.
    """
    slopes = []
    for side in (rate > 0, rate < 0):
        if len(set(np.round(rate[side], 6))) < 2:
            return Found()
        operator = np.zeros(len(rate))
        design = np.column_stack([rate[side], np.ones(side.sum())])
        operator[side] = solve(design).operator[0]
        slopes.append(operator)
    apart, mean = slopes[0] - slopes[1], float(0.5 * (slopes[0] + slopes[1]) @ output)
    if not mean:
        return Found()
    value, u = float(apart @ output / mean), float(np.sqrt(apart @ covariance @ apart) / abs(mean))
    return Found(value, u, value**2 > float(chdtri(1, EXCESS_LEVEL)) * u**2)


def _points(evidence: Evidence, channel: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rates (n,), means (n,) and their covariance of the rate points about a gyro's own axis."""
    points = [i for i in evidence.points[AXES[channel]] if evidence.segments[i].has_gyro]
    covariance = evidence.covariance(channel)[np.ix_(points, points)]
    return evidence.rate[points], evidence.means[points, channel], covariance


def _shown(title: Said, item: str, found: list[Found], what: Said) -> Information:
    sure = [axis for axis, each in zip(AXES, found, strict=True) if each.significant]
    listed = ", ".join(sure)
    said = (
        (f"More than noise: {listed}.", f"超出噪声：{listed}。")
        if sure
        else ("No more than noise on any axis.", "各轴均未超出噪声。")
    )
    value, u = (PPM * np.array([getattr(each, name) for each in found]) for name in ("value", "u"))
    return shown(title, "ppm", value, u, what, said, about=item)
