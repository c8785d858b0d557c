"""How well a channel repeats where the run holds one input several times.

An axis that points up reads the same gravity and the same part of Earth's rotation at every
heading, so all rests with it up are one measurement repeated; those with it down another.
"""

import numpy as np

from schemas.calibration import Information
from schemas.recording import AXES
from tasks.calibrate.information.entry import by_axis, entry
from tasks.segments.summarise import ACCEL_COLUMNS
from tasks.specifications.estimate import DEG
from tasks.specifications.evidence import Evidence
from tasks.words import message

SAME_RATE = np.radians(0.1)  # rad/s: rates closer than this are one rate held twice
PPM = 1e6

Deviation = tuple[float, int]  # standard deviation of one repetition, degrees of freedom


def repeatability_information(evidence: Evidence, rate_sensor: str) -> dict[str, Information]:
    """Standard deviations of one repetition: bias at rest, and scale factor, of each channel."""
    axes, first = range(3), ACCEL_COLUMNS.start
    made = {
        f"{rate_sensor}_bias_repeatability": ("deg/s", DEG, [
            _repeated_rests(evidence, i, i) for i in axes]),
        f"{rate_sensor}_scale_repeatability": ("ppm", PPM, [
            _repeated_rates(evidence, i) for i in axes]),
    }  # fmt: skip
    if rate_sensor == "gyro":
        made |= {
            "accel_bias_repeatability": ("m/s2", 1.0, [
                _repeated_rests(evidence, i, first + i) for i in axes]),
            "accel_scale_repeatability": ("ppm", PPM, [
                _repeated_scale(evidence, i, first + i) for i in axes]),
        }  # fmt: skip
    return {name: _entry(name, *rest) for name, rest in made.items() if any(n for _, n in rest[2])}


def pooled_deviation(groups: list[np.ndarray]) -> Deviation:
    """Standard deviation of one repetition pooled over groups (n,), and its degrees of freedom.

    NaN where no group has two.
    """
    dof = sum(len(group) - 1 for group in groups if len(group) > 1)
    if not dof:
        return float("nan"), 0
    square = sum(float(((group - group.mean()) ** 2).sum()) for group in groups if len(group) > 1)
    return float(np.sqrt(square / dof)), dof


def _repeated_rests(evidence: Evidence, axis: int, channel: int) -> Deviation:
    rests = (evidence.rests[f"{sign}{AXES[axis]}"] for sign in "+-")
    return pooled_deviation([_known(evidence.means[list(held), channel]) for held in rests])


def _repeated_rates(evidence: Evidence, channel: int) -> Deviation:
    """Outputs over rate where one rate was held several times."""
    points = list(evidence.points[AXES[channel]])
    points = [i for i in points if abs(evidence.rate[i]) > SAME_RATE]
    groups: dict[int, list[float]] = {}
    for i in points:
        output = evidence.means[i, channel] / evidence.rate[i]
        groups.setdefault(round(evidence.rate[i] / SAME_RATE), []).append(output)
    return pooled_deviation([_known(np.array(group)) for group in groups.values()])


def _repeated_scale(evidence: Evidence, axis: int, channel: int) -> Deviation:
    """(Up less down)/2g at each heading at which both were held."""
    gravity = evidence.gravity
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


def _entry(name: str, unit: str, factor: float, deviations: list[Deviation]) -> Information:
    """Deviations with u = s/√(2·dof)."""
    s, dof = (np.array(column, float) for column in zip(*deviations, strict=True))
    u = s / np.sqrt(2.0 * np.maximum(dof, 1.0))
    listed = ", ".join(f"{axis} {int(n)}" for axis, n in zip(AXES, dof, strict=True) if n)
    title = message(f"information-{name.replace('_', '-')}")
    text = message("information-repetition", dof=listed)
    return entry(title, unit, by_axis(factor * s), by_axis(factor * u), text)
