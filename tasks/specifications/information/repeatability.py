"""How well a channel repeats where the run holds one input several times.

An axis that points up reads the same gravity and the same part of Earth's rotation at every
heading, so all rests with it up are one measurement repeated; those with it down another.
"""

from collections.abc import Mapping

import numpy as np

from schemas.calibration import Information
from schemas.recording import AXES
from tasks.segments.summarise import ACCEL_COLUMNS
from tasks.specifications.evidence import Evidence
from tasks.specifications.information.shown import Said, shown
from tasks.specifications.parts import DEG

ALIKE = np.radians(0.1)  # rad/s: rates closer than this are one rate held twice
PPM = 1e6


def repeatability_information(
    evidence: Evidence, gravity: float | None, *, ahrs: bool
) -> dict[str, Information]:
    """Standard deviations of one repetition: bias at rest, and scale factor, of each channel.

    gravity: m/s², None where it is not told.
    """
    gyro, who = ("ahrs", ("of the axes", "各轴")) if ahrs else ("gyro", ("of the gyros", "陀螺"))
    bias = {i: _repeated_rests(evidence, i, i) for i in range(3)}
    scale = {i: _repeated_rates(evidence, i) for i in range(3)}
    made = {
        f"{gyro}_bias_repeatability": _shown(_bias(*who), "deg/s", DEG, bias),
        f"{gyro}_scale_repeatability": _shown(_scale(*who), "ppm", PPM, scale),
    }
    if not ahrs:
        who = ("of the accelerometers", "加速度计")
        first = ACCEL_COLUMNS.start
        felt = {i: _repeated_rests(evidence, i, first + i) for i in range(3)}
        name = (f"Bias repeatability {who[0]}", f"{who[1]}偏值重复性")
        made["accel_bias_repeatability"] = _shown(name, "m/s2", 1.0, felt)
        ratio = {i: _repeated_scale(evidence, i, first + i, gravity) for i in range(3)}
        made["accel_scale_repeatability"] = _shown(_scale(*who), "ppm", PPM, ratio)
    return {
        name: each for name, each in made.items() if any(v is not None for v in each.value.values())
    }


def pooled_deviation(groups: list[np.ndarray]) -> tuple[float, int]:
    """Standard deviation of one repetition pooled over groups (n,), and its degrees of freedom.

    NaN where no group has two.
    """
    dof = sum(len(group) - 1 for group in groups if len(group) > 1)
    if not dof:
        return float("nan"), 0
    square = sum(float(((group - group.mean()) ** 2).sum()) for group in groups if len(group) > 1)
    return float(np.sqrt(square / dof)), dof


def _repeated_rests(evidence: Evidence, axis: int, channel: int) -> tuple[float, int]:
    rests = (evidence.rests[f"{sign}{AXES[axis]}"] for sign in "+-")
    return pooled_deviation([_known(evidence.means[list(held), channel]) for held in rests])


def _repeated_rates(evidence: Evidence, channel: int) -> tuple[float, int]:
    """Outputs over rate where one rate was held several times."""
    points = list(evidence.points[AXES[channel]])
    points = [i for i in points if abs(evidence.rate[i]) > ALIKE]
    groups: dict[int, list[float]] = {}
    for i in points:
        output = evidence.means[i, channel] / evidence.rate[i]
        groups.setdefault(round(evidence.rate[i] / ALIKE), []).append(output)
    return pooled_deviation([_known(np.array(group)) for group in groups.values()])


def _repeated_scale(
    evidence: Evidence, axis: int, channel: int, gravity: float | None
) -> tuple[float, int]:
    """(Up less down)/2g at each heading at which both were held."""
    if gravity is None:
        return float("nan"), 0
    up, down = (_by_heading(evidence, f"{sign}{AXES[axis]}", channel) for sign in "+-")
    ratios = [(up[turn] - down[turn]) / (2.0 * gravity) for turn in up if turn in down]
    return pooled_deviation([_known(np.array(ratios))])


def _by_heading(evidence: Evidence, up: str, channel: int) -> dict[int, float]:
    """Mean reading at each heading, whole degrees."""
    groups: dict[int, list[float]] = {}
    for i in evidence.positions[up]:
        turn = evidence.segments[i].segment.turn_deg
        if turn is not None:
            groups.setdefault(round(turn) % 360, []).append(evidence.means[i, channel])
    return {turn: float(np.mean(held)) for turn, held in groups.items()}


def _known(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]


def _bias(en: str, zh: str) -> Said:
    return f"Bias repeatability {en}", f"{zh}零偏重复性"


def _scale(en: str, zh: str) -> Said:
    return f"Scale factor repeatability {en}", f"{zh}标度因数重复性"


def _shown(
    title: Said, unit: str, factor: float, found: Mapping[int, tuple[float, int]]
) -> Information:
    """Deviations with u = s/√(2·dof)."""
    s, dof = (np.array([found[i][place] for i in range(3)], float) for place in (0, 1))
    u = s / np.sqrt(2.0 * np.maximum(dof, 1.0))
    listed = ", ".join(f"{AXES[i]} {int(dof[i])}" for i in range(3) if dof[i])
    said = (
        "Standard deviation of one repetition within this run; degrees of freedom: "
        f"{listed or 'none'}.",
        f"本次运行内单次重复的标准差；自由度：{listed or '无'}。",
    )
    return shown(title, unit, factor * s, factor * u, said)
