"""An entry of the result's information."""

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from schemas.calibration import Elements, Information, Item
from schemas.recording import AXES
from schemas.text import text_fields
from tasks.segments.summarise import ACCEL_COLUMNS
from tasks.specifications.estimate import DEG
from tasks.specifications.evidence import (
    EXCESS_LEVEL,
    ClauseEvidence,
    EarthRotationGain,
    earth_rotation_message,
    residuals_of,
    solve,
)
from tasks.uncertainty.propagation import coverage_factor
from tasks.words import Message, clauses, message, statement, worded
from tasks.words.numbers import USUAL_K

Numbers = Sequence[float | None] | np.ndarray


def entry(
    name: str,
    unit: str,
    value: Numbers,
    u: Numbers,
    *sentences: Message,
    elements: Iterable[str] = AXES,
    factor: float = 1.0,
    k: float = USUAL_K,
    without_U: np.ndarray | bool = False,  # noqa: N803
    about: str | None = None,
) -> Information:
    """Values with standard uncertainties, one for each element, NaN if there is none; U = k·u.

    name: of the title's message; sentences: what it is and how it was found; factor: from the
    values' unit to the printed one; about: the item it refers to. without_U: u is not a complete
    uncertainty, so that no U is stated.
    """
    title = message(f"information-{name.replace('_', '-')}")
    values = factor * np.array(value, float)
    us = np.where(np.isfinite(values), factor * np.array(u, float), np.nan)
    expanded = np.where(without_U, np.nan, k * us)

    def known(numbers: np.ndarray) -> Elements:
        finite = (float(n) if np.isfinite(n) else None for n in numbers)
        return dict(zip(elements, finite, strict=True))

    return Information(
        **text_fields("title", statement(title)),
        unit=unit,
        value=known(values),
        u=known(us),
        U=known(expanded),
        k=k,
        about=about,
        **worded(clauses(sentences, by="report-sentences")),
    )


def student_k(dof: np.ndarray) -> float:
    """k by Student's t for the fewest degrees of freedom (n,) that there are, rounded up to two
    decimals as that of an item; NaN or 0: none.
    """
    k = coverage_factor(float(min(dof[dof > 0], default=math.inf)))
    return math.ceil(100 * round(k, 9)) / 100


def of_axes(id_: str, axes: Sequence[str], **arguments: str) -> list[Message]:
    """A sentence about some axes; none for no axes."""
    return [message(id_, axes=", ".join(axes), **arguments)] if axes else []


def type_b(item: Item | None, elements: Iterable[str]) -> np.ndarray:
    """What the equipment adds to u of each element of an item, by its budget; NaN without one."""
    budgets = item.budgets if item else {}
    return np.array([
        math.sqrt(sum(line.contribution**2 for line in budgets[element].inputs if line.kind == "B"))
        if element in budgets
        else math.nan
        for element in elements
    ])  # fmt: skip


def or_why_not(u: np.ndarray) -> list[Message]:
    """The sentence on what u (n,) includes: type B as well, or why there is none."""
    known = bool(np.isfinite(u).any())
    return [message(f"information-type-b.{'contained' if known else 'not-evaluated'}")]


def without_type_b(u: np.ndarray, elements: Sequence[str]) -> list[Message]:
    """Which elements have no U where others have one: the equipment's share is of no budget."""
    known = np.isfinite(u)
    bare = [element for element, has in zip(elements, known, strict=True) if not has]
    named = bare if known.any() else []
    return [message("information-type-b.in-part", elements=", ".join(named))] if named else []


def unit_and_table(values: np.ndarray) -> list[Message]:
    """Why no type B is added to a figure (n,) that has the table in it; none without a figure."""
    return [message("information-type-b.unit-and-table")] if np.isfinite(values).any() else []


# Deviation of the rate points from a straight line: non-linearity and asymmetry.
#
# Source: GJB 7952-2012 and IEEE Std 1431: non-linearity is the largest residual from the line
# through all points over the largest output; asymmetry is the slope of the positive rates less
# that of the negative ones, over the mean of both. Residuals are those of the clauses' own line,
# eq. (4) of JJF 2003 and eq. (13) of JJF 1536.

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
        f"{rate_sensor}_scale_{name}": _ratio_entry(name, item, three, of_ratio[name])
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


def _ratio_entry(name: str, item: str, ratios: list[Ratio], equipment: np.ndarray) -> Information:
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


# The g-sensitivity of JJF 2003 without Earth's rotation, and whether the data show any.

ITEM = "gyro_g_sensitivity"
WITHOUT_EARTH = "gyro_g_sensitivity_without_earth_rotation"
EARTH_ROTATION = "earth_rotation_seen"


def earth_information(
    earth: EarthRotationGain | None, items: Mapping[str, Item]
) -> dict[str, Information]:
    """The gain λ of Earth's rotation, and g-sensitivity less K·ωe·sin φ, (deg/s)/g.

    Nothing where the recording has no g-sensitivity or no latitude.
    """
    item = items.get(ITEM)
    return {**_gain(earth), **separated(item, earth)} if item else {}


def _gain(earth: EarthRotationGain | None) -> dict[str, Information]:
    if earth is None:
        return {}
    text = message(
        "information-earth-gain.text", shown=earth_rotation_message(earth),
        gain=f"{earth.gain:.3f}", spread=f"{2.0 * earth.u:.3f}",
    )  # fmt: skip
    gain = entry(
        "earth-gain", "1", [round(earth.gain, 3)], [earth.u], text,
        elements="λ", without_U=True, about=ITEM,
    )  # fmt: skip
    return {EARTH_ROTATION: gain}


def separated(item: Item, earth: EarthRotationGain | None) -> dict[str, Information]:
    """The value without Earth's rotation; nothing where it is that of the item itself."""
    without = item.value_without_earth_rotation
    if without is None:
        return {}
    off = max(
        (
            abs(value - other) / U
            for element, other in without.items()
            if other is not None
            and (value := item.value[element]) is not None
            and (U := item.U[element])
        ),
        default=0.0,
    )
    if not off:
        return {}
    text = message("information-without-earth.text", difference=_difference(off, earth))
    u = item.u_without_earth_rotation or dict.fromkeys(without)
    numbers = [*without.values()], [*u.values()]
    shown = entry(
        "without-earth", item.unit, *numbers, text, elements=without, k=item.k, about=ITEM
    )
    return {WITHOUT_EARTH: shown}


def _difference(off: float, earth: EarthRotationGain | None) -> Message:
    """What the difference of both values, so many times U, means."""
    state = earth.state if earth and earth.state in ("present", "not_shown") else "unknown"
    return message(f"information-earth-{state.replace('_', '-')}", times=f"{off:.2g}")


# Repeatability of a channel where a run holds the same input several times.
#
# An axis that points up reads the same gravity and the same part of Earth's rotation at every
# heading, so all rests with it up are one measurement repeated; those with it down another.

SAME_RATE = np.radians(0.1)  # rad/s: rates closer than this are one rate held twice

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
    return {
        name: _repeatability_entry(name, *rest)
        for name, rest in made.items()
        if any(n for _, n in rest[2])
    }


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


def _repeatability_entry(
    name: str, unit: str, factor: float, deviations: list[Deviation]
) -> Information:
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
