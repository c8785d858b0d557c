"""Repeatability of a channel where a run holds the same input several times.

An axis that points up reads the same gravity and the same part of Earth's rotation at every
heading, so all rests with it up are one measurement repeated; those with it down another.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence

import numpy as np

from schemas.calibration import Information
from schemas.recording import AXES
from tasks.calibrate.information.entry import entry, of_axes, student_k, unit_and_table
from tasks.segments.summarise import ACCEL_COLUMNS
from tasks.specifications.estimate import DEG
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import message

SAME_RATE = np.radians(0.1)  # rad/s: rates closer than this are one rate held twice
PPM = 1e6

Deviation = tuple[float, int]  # standard deviation of one repetition, degrees of freedom


def repeatability_information(evidence: ClauseEvidence, rate_sensor: str) -> dict[str, Information]:
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


def pooled_deviation(groups: Iterable[Sequence[float] | np.ndarray]) -> Deviation:
    """Standard deviation of one repetition pooled over groups (n,), and its degrees of freedom.

    Readings that are NaN do not count; NaN where no group has two others.
    """
    known = [values[np.isfinite(values)] for values in map(np.array, groups)]
    repeated = [values for values in known if len(values) > 1]
    dof = sum(len(values) - 1 for values in repeated)
    if not dof:
        return float("nan"), 0
    square = sum(float(((values - values.mean()) ** 2).sum()) for values in repeated)
    return float(np.sqrt(square / dof)), dof


def _repeated_rests(evidence: ClauseEvidence, axis: int, channel: int) -> Deviation:
    rests = (evidence.rests[f"{sign}{AXES[axis]}"] for sign in "+-")
    return pooled_deviation(evidence.means[list(held), channel] for held in rests)


def _repeated_rates(evidence: ClauseEvidence, channel: int) -> Deviation:
    """Outputs over rate where one rate was held several times."""
    rate = evidence.rate
    groups = defaultdict(list)
    for i in evidence.points[AXES[channel]]:
        if abs(rate[i]) > SAME_RATE:
            groups[round(rate[i] / SAME_RATE)].append(evidence.means[i, channel] / rate[i])
    return pooled_deviation(groups.values())


def _repeated_scale(evidence: ClauseEvidence, axis: int, channel: int) -> Deviation:
    """(Up less down)/2g at each heading at which both were held."""
    gravity = evidence.gravity
    if gravity is None:
        return float("nan"), 0
    up, down = (_by_heading(evidence, f"{sign}{AXES[axis]}", channel) for sign in "+-")
    return pooled_deviation([
        [(up[turn] - down[turn]) / (2.0 * gravity) for turn in up if turn in down]
    ])  # fmt: skip


def _by_heading(evidence: ClauseEvidence, up: str, channel: int) -> dict[int, float]:
    """Mean reading at each heading, whole degrees."""
    groups = defaultdict(list)
    for i in evidence.positions[up]:
        turn = evidence.segments[i].segment.turn_deg
        if turn is not None:
            groups[round(turn) % 360].append(evidence.means[i, channel])
    return {turn: float(np.mean(held)) for turn, held in groups.items()}


def _entry(name: str, unit: str, factor: float, deviations: list[Deviation]) -> Information:
    """Deviations with u = s/√(2·dof); without U where that would reach below zero."""
    s, dof = (np.array(column, float) for column in zip(*deviations, strict=True))
    u = s / np.sqrt(2.0 * np.maximum(dof, 1.0))
    listed = ", ".join(f"{axis} {int(n)}" for axis, n in zip(AXES, dof, strict=True) if n)
    text = message("information-repetition", dof=listed)
    k = student_k(dof)
    vague = k * u >= s
    few = [axis for axis, n, v in zip(AXES, dof, vague, strict=True) if n and v]
    return entry(
        name, unit, s, u, text, *unit_and_table(np.where(vague, np.nan, s)),
        *of_axes("information-few-degrees-of-freedom", few), factor=factor, k=k,
        without_U=vague,
    )  # fmt: skip
