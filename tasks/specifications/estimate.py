"""Estimates before their budgets: of one element, of an item, and a clause's contributions."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from schemas.calibration import Method
from schemas.recording import AXES, Axis, Recording, Standard
from schemas.text import Remark, Statement
from tasks.segments.find import Conditions
from tasks.segments.summarise import CHANNELS
from tasks.specifications.equipment_errors import EquipmentErrors
from tasks.specifications.evidence import (
    BLOCKING_EXCESS,
    BirgeRatio,
    ClauseEvidence,
    Solution,
    birge_ratio,
    solve,
)
from tasks.uncertainty.budget import Contribution, drift_in_run, observed, resolution
from tasks.uncertainty.equipment import NOBODY, Equipment
from tasks.uncertainty.type_a import type_a_dof
from tasks.words import Message, Sayable, clauses, message, remark

# The items that the specifications calibrate: symbol, unit and elements of each.
#
# The names of items and elements stand in the catalogues under `item-…`, by the item's key.

# Elements: the axis that reads, then the input axis.
MATRIX_ELEMENTS = tuple(reads + given for reads in AXES for given in AXES)
OFF_DIAGONAL_ELEMENTS = tuple(e for e in MATRIX_ELEMENTS if e[0] != e[1])
# Column by column, as Appendix B of JJF 2003-2022 and Appendix C of JJF 1536-2015 list them.
BY_INPUT_AXIS = ("yx", "zx", "xy", "zy", "xz", "yz")

RATE_ERRORS = ("ε1", "ε2", "ε3", "ε4", "ε5")  # relative errors of the rate and of the time base
ANGLE_ERRORS = ("α1θ", "α2θ")  # of a turned angle

SecondValue = Literal["value_without_earth_rotation", "value_model"]


@dataclass(frozen=True)
class ItemDefinition:
    """The definition of an item, independent of any recording.

    letter, subscript: the symbol of an element; {e} is replaced by the element, {twice} by it
    twice. elements: in printing order; unit: as in results. second_value: the field of a result's
    item for the value beside that of the clause. divisor, power: the symbols of the equipment's
    errors by which the value is divided (`tasks.uncertainty.equipment`), and to which power.
    """

    key: str
    letter: str
    subscript: str
    unit: str
    elements: tuple[str, ...]
    second_value: SecondValue | None = None
    divisor: tuple[str, ...] = ()
    power: int = 1

    @property
    def title(self) -> Message:
        """The name of the item."""
        return message(f"item-{self.key.replace('_', '-')}")

    def element_title(self, element: str) -> Message:
        """The name of one element."""
        reads, given = element[0].upper(), element[-1].upper()
        return message(f"item-{self.key.replace('_', '-')}.element", reads=reads, input=given)

    def element_subscript(self, element: str) -> str:
        """What stands under the letter: gxx for a diagonal coefficient given as x."""
        return self.subscript.format(e=element, twice=element * 2)

    def symbol(self, element: str) -> str:
        """The symbol of an element as plain text, like K_gxx."""
        return f"{self.letter}_{self.element_subscript(element)}"


MIMU_ITEMS = (
    ItemDefinition("gyro_scale_factor", "K", "g{twice}", "1", AXES, divisor=RATE_ERRORS),
    ItemDefinition("gyro_cross_coupling", "K", "g{e}", "1", BY_INPUT_AXIS, divisor=RATE_ERRORS),
    ItemDefinition("gyro_fit_offset", "b", "{e}", "deg/s", AXES),
    ItemDefinition("gyro_bias", "B", "g{e}", "deg/s", AXES),
    ItemDefinition(
        "gyro_g_sensitivity", "g", "{e}", "(deg/s)/g", MATRIX_ELEMENTS,
        second_value="value_without_earth_rotation",
    ),
    ItemDefinition("accel_scale_factor", "K", "a{twice}", "1", AXES, divisor=("g",)),
    ItemDefinition("accel_cross_coupling", "K", "a{e}", "1", BY_INPUT_AXIS, divisor=("g",)),
    ItemDefinition("accel_bias", "B", "a{e}", "m/s2", AXES),
    ItemDefinition(
        "accel_rate_sensitivity", "p", "{e}", "m", OFF_DIAGONAL_ELEMENTS,
        second_value="value_model", divisor=RATE_ERRORS, power=2,
    ),
)  # fmt: skip
AHRS_ITEMS = (
    ItemDefinition("ahrs_scale_factor", "K", "{e}", "1", AXES, divisor=RATE_ERRORS),
    ItemDefinition("ahrs_zero_offset", "B", "{e}", "deg/s", AXES),
    ItemDefinition("ahrs_misalignment", "L", "{e}", "deg", BY_INPUT_AXIS, divisor=ANGLE_ERRORS),
)
ITEMS = {item.key: item for item in (*MIMU_ITEMS, *AHRS_ITEMS)}


def second_value(key: str) -> SecondValue | None:
    """The field of the value beside the clause's own; None where an item has one value."""
    return ITEMS[key].second_value if key in ITEMS else None


def item_title(key: str) -> Message | Statement:
    """The name of an item; its key where no specification has it."""
    return ITEMS[key].title if key in ITEMS else Statement(en=key, zh=key)


def symbol(key: str, element: str) -> str:
    """The symbol of an element as plain text, like K_gxx; the element where there is none."""
    return ITEMS[key].symbol(element) if key in ITEMS else element


DEG = float(np.degrees(1.0))  # degrees in a radian, where something is printed
MATRIX = tuple((i, j) for i in range(3) for j in range(3))
NO_EXCESS = BirgeRatio()
NEGLIGIBLE = 1e-6  # of a variance: no line of its own
OF_DATA = ("u_A", "q", "d")  # symbols of the lines of repeatability, resolution and drift


@dataclass(frozen=True)
class Estimate:
    """A value, the lines of its budget so far, and what Appendix A adds up to its u₃.

    operator: (6, n), the value as a combination of the segment means of all channels; None where
    it is none. without_earth: whether Earth's rotation was taken from it.

    lines: of the data first (type A, the unit's resolution), then those of the equipment, with
    sensitivities in the unit of the value per their own; no unit: that of the value.
    repeated: standard uncertainties, each as if its position alone gave the result; empty: the
    type A line itself is the repeatability. NaN: not determined.
    """

    value: float
    lines: tuple[Contribution, ...] = ()
    repeated: tuple[float, ...] = ()
    operator: np.ndarray | None = field(default=None, compare=False)
    without_earth: bool = False

    @property
    def determined(self) -> bool:
        """Whether there is a value."""
        return math.isfinite(self.value)

    @property
    def has_uncertainty(self) -> bool:
        """Whether there is a value, and every line of its budget is known."""
        sizes = (line.quantity.u * line.sensitivity for line in self.lines)
        return self.determined and all(map(math.isfinite, sizes))

    @property
    def unstated(self) -> tuple[Contribution, ...]:
        """The lines that nobody states, where one of them is the largest: there is no U then."""
        by_size = sorted(self.lines, key=lambda line: abs(line.quantity.u * line.sensitivity))
        nobody = tuple(line for line in self.lines if line.quantity.source == NOBODY)
        return nobody if nobody and by_size[-1] in nobody else ()

    @property
    def u_of_data(self) -> float:
        """Standard uncertainty by the data: noise, scatter and the unit's resolution."""
        lines = [line for line in self.lines if line.quantity.symbol in OF_DATA]
        return float(np.linalg.norm([line.quantity.u * line.sensitivity for line in lines]))

    @property
    def has_repeatability(self) -> bool:
        """Whether what Appendix A adds up is known."""
        return all(map(math.isfinite, self.repeated))

    def scaled(self, factor: float) -> "Estimate":
        """The same in another unit."""
        return Estimate(
            self.value * factor,
            tuple(line.scaled(factor) for line in self.lines),
            tuple(abs(factor) * u for u in self.repeated),
            None if self.operator is None else factor * self.operator,
            self.without_earth,
        )

    def with_lines(self, *more: Contribution) -> "Estimate":
        """With further lines in its budget."""
        return replace(self, lines=(*self.lines, *more))

    def lines_in(self, unit: str) -> tuple[Contribution, ...]:
        """The lines, those of the data in the value's unit with sensitivity 1."""
        return tuple(line if line.quantity.unit else _own(line, unit) for line in self.lines)


def _own(line: Contribution, unit: str) -> Contribution:
    u = line.quantity.u * abs(line.sensitivity)
    return Contribution(replace(line.quantity, u=u, unit=unit), 1.0)


UNDETERMINED = Estimate(float("nan"))
Estimates = dict[str, Estimate]  # by element


@dataclass(frozen=True)
class ItemEstimate:
    """The estimates of an item's elements, in its printed unit, and what they rest on.

    clause: as the result names it; readings: keys of `tasks.specifications.readings`.
    without_earth_rotation: the second value of an item that has one.
    """

    elements: Estimates
    clause: str
    readings: tuple[str, ...] = ()
    without_earth_rotation: Estimates | None = None

    @property
    def undetermined(self) -> tuple[str, ...]:
        """The elements without a value."""
        return tuple(e for e, estimate in self.elements.items() if not estimate.determined)


@dataclass(frozen=True)
class ClauseResult:
    """Items of a clause by their keys, reasons for what is missing, and remarks.

    errors: of the equipment, once they stand in the budgets.
    """

    items: Mapping[str, ItemEstimate] = field(default_factory=dict)
    unavailable: Mapping[str, Sayable] = field(default_factory=dict)
    remarks: tuple[Remark, ...] = ()
    errors: EquipmentErrors | None = None


def merged(results: Iterable[ClauseResult]) -> ClauseResult:
    """Several clauses as one: their items, their reasons, their remarks in the same order."""
    every = tuple(results)
    return ClauseResult(
        {key: item for result in every for key, item in result.items.items()},
        {key: reason for result in every for key, reason in result.unavailable.items()},
        tuple(remark for result in every for remark in result.remarks),
    )


def with_equipment(result: ClauseResult, errors: EquipmentErrors) -> ClauseResult:
    """The same with the lines of the equipment's errors in the budget of every element."""

    def with_lines(estimates: Estimates) -> Estimates:
        return {e: _with_errors(estimate, errors) for e, estimate in estimates.items()}

    items = {}
    for key, item in result.items.items():
        second = item.without_earth_rotation
        items[key] = replace(
            item,
            elements=with_lines(item.elements),
            without_earth_rotation=None if second is None else with_lines(second),
        )
    return replace(result, items=items, errors=errors)


def _with_errors(estimate: Estimate, errors: EquipmentErrors) -> Estimate:
    if estimate.operator is None:
        return estimate
    return estimate.with_lines(*errors.lines(estimate.operator, estimate.without_earth))


def linear_estimate(
    evidence: ClauseEvidence, channel: int, weights: np.ndarray, excess: BirgeRatio = NO_EXCESS
) -> Estimate:
    """o·U for one channel: its value, its type A line and, where the step is coarse, that too.

    weights: o (n,) of all segment means, in the unit of the result per that of the channel. Where
    the points scatter more than noise and rounding together, both are one line with the scatter
    observed, and the degrees of freedom of the residuals.
    """
    used = np.flatnonzero(weights)
    o, block = weights[used], np.ix_(used, used)
    value = float(o @ evidence.means[used, channel])
    if not math.isfinite(value):
        return UNDETERMINED
    noise = float(o @ evidence.noise_covariances[channel][block] @ o)
    rounding, draws = evidence.rounding(channel, weights)
    drift = evidence.drift(channel, weights)
    drifts = (drift_in_run(drift),) if drift else ()
    operator = np.zeros((len(CHANNELS), len(weights)))
    operator[channel] = weights
    if excess.factor > 1.0:
        u = excess.factor * np.sqrt(max(noise + rounding, 0.0))
        scattered = observed(float(u), "", excess.dof)
        return Estimate(value, (scattered, *drifts), operator=operator)
    dof = type_a_dof(weights, evidence.noise, channel, noise)
    lines = (observed(float(np.sqrt(max(noise, 0.0))), "", dof), *drifts)
    if rounding > NEGLIGIBLE * noise:
        line = resolution(float(np.sqrt(3.0 * rounding)), "", 1.0)
        lines = (*lines, replace(line, draws=draws))
    return Estimate(value, lines, operator=operator)


@dataclass(frozen=True)
class MeansFit:
    """Parameters (p) fitted to combinations of one channel's segment means."""

    solution: Solution
    excess: BirgeRatio
    estimates: tuple[Estimate, ...]


def fit_means(
    evidence: ClauseEvidence,
    channel: int,
    design: np.ndarray,
    outputs: np.ndarray,
    errors: EquipmentErrors,
) -> MeansFit:
    """Least squares of a (m, p) design to m outputs of a channel.

    outputs: (m, n), each a combination of all segment means. errors: of the equipment; what they
    scatter is no excess.
    """
    solution, used = solve(design), outputs.any(axis=0)
    readings = outputs[:, used] @ evidence.means[used, channel]
    expected = evidence.covariance(channel) + errors.covariance(channel)
    covariance = outputs[:, used] @ expected[np.ix_(used, used)] @ outputs[:, used].T
    excess = birge_ratio(solution, design, readings, covariance)
    estimates = (
        linear_estimate(evidence, channel, row @ outputs, excess) if known else UNDETERMINED
        for row, known in zip(solution.operator, solution.estimable, strict=True)
    )
    return MeansFit(solution, excess, tuple(estimates))


def u_of_means(evidence: ClauseEvidence, channel: int, weights: np.ndarray) -> np.ndarray:
    """Standard uncertainties (m,) of m combinations (m, n) of one channel's means, data only."""
    variance = (weights @ evidence.covariance(channel) * weights).sum(axis=1)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))


def scaled(estimates: Mapping[str, Estimate], factor: float) -> Estimates:
    """The elements in another unit."""
    return {element: estimate.scaled(factor) for element, estimate in estimates.items()}


def diagonal(matrix: Mapping[str, Estimate]) -> Estimates:
    """The elements xx, yy, zz of a matrix under the names x, y, z."""
    return {axis: matrix[axis * 2] for axis in AXES}


def off_diagonal(matrix: Mapping[str, Estimate]) -> Estimates:
    """The couplings of a matrix, row by row."""
    return {element: matrix[element] for element in OFF_DIAGONAL_ELEMENTS}


def undetermined(elements: Iterable[str]) -> Estimates:
    """Elements of which none is determined."""
    return dict.fromkeys(elements, UNDETERMINED)


def item_by_axis(
    key: str,
    item: ItemEstimate,
    of_axis: Callable[[int, Axis], "tuple[Estimates, Iterable[Remark]] | Message"],
) -> ClauseResult:
    """An item of which each axis gives some elements and remarks, or the reason why it cannot.

    item: with all its elements undetermined.
    """
    elements, missing, remarks = dict(item.elements), list[Sayable](), list[Remark]()
    for j, axis in enumerate(AXES):
        result = of_axis(j, axis)
        if isinstance(result, Message):
            missing.append(result)
        else:
            elements |= result[0]
            remarks += result[1]
    reasons = {key: clauses(missing)} if missing else {}
    return ClauseResult({key: replace(item, elements=elements)}, reasons, tuple(remarks))


def excess_remarks(
    text: str, factors: Sequence[float], first_channel: int = 0, **arguments: Sayable
) -> tuple[Remark, ...]:
    """One remark on the channels that scatter more than their noise explains, if any does.

    text: the message's identifier; factors: of the channels from `first_channel` on.
    """
    above = [i for i, factor in enumerate(factors) if factor > 1.0]
    if not above:
        return ()
    channels = ", ".join(f"{CHANNELS[first_channel + i]} {factors[i]:.1f}" for i in above)
    phrase = message(text, channels=channels, **arguments)
    return (remark("excess_scatter", phrase, blocks_pass=bool(max(factors) > BLOCKING_EXCESS)),)


# The covariance of all elements of a result, type A and type B together.
#
# Elements that are combinations of the same means share their noise, and whatever the equipment
# was off by: one error of the rate is in every scale factor.


def covariance_of(
    estimates: Sequence[Estimate], evidence: ClauseEvidence, errors: EquipmentErrors
) -> np.ndarray:
    """Covariance (p, p) of estimates that are combinations of the segment means, in their units.

    Its diagonal is that of their budgets: where points scatter more than noise explains, what the
    data give is taken in the same proportion.
    """
    weights = np.array([estimate.operator for estimate in estimates], float)  # (p, 6, n)
    noise = np.zeros((len(estimates), len(estimates)))
    for channel in range(weights.shape[1]):
        used = np.flatnonzero(weights[:, channel].any(axis=0))
        of_means = evidence.covariance(channel)[np.ix_(used, used)]
        part = weights[:, channel][:, used]
        noise += part @ of_means @ part.T
    stated = np.array([estimate.u_of_data for estimate in estimates])
    shown = np.sqrt(np.maximum(np.diag(noise), 0.0))
    scale = np.divide(stated, shown, out=np.zeros_like(stated), where=shown > 0.0)
    total = noise * np.outer(scale, scale)
    free = np.array([estimate.without_earth for estimate in estimates])
    for source in errors.sources:
        felt = np.tensordot(weights, source.effects, axes=((1, 2), (2, 1)))
        if source.of_latitude:
            felt = felt * free[:, None]
        total += source.quantity.u**2 * felt @ felt.T
    return np.asarray(0.5 * (total + total.T))


# The record of a specification: everything that distinguishes it from another.


@dataclass(frozen=True)
class Section:
    """A numbered section of the certificate: the key of its title, and its items in order."""

    key: str
    items: tuple[str, ...]

    @property
    def title(self) -> Message:
        """The heading."""
        return message(f"section-{self.key}")


@dataclass(frozen=True)
class Specification:
    """A specification, or a method that follows the model of one.

    method: how orders and results call it; standard: the document; procedure: the clauses that a
    result names. items: in the order of a result; required: the keys of those that the document
    asks for, in its order; printed_once: those whose second value equals the first. conditions:
    of points and environment. interval_months: until recalibration is due. layout: of the
    certificate's results; reported_conditions: what it says of the measurement
    (`tasks.certificate.conditions`). equipment: the limits that the document itself recommends,
    and equipment_source where. rate_sensor: how results call what senses the rate.

    check raises Unusable for a recording that the method cannot serve; gather sorts its segments;
    estimate makes the items of them, the equipment's errors among their uncertainties.
    """

    method: Method
    standard: Standard
    procedure: str
    items: tuple[ItemDefinition, ...]
    conditions: Conditions
    interval_months: int
    layout: tuple[Section, ...]
    equipment: Equipment
    equipment_source: str
    check: Callable[[Recording], None]
    gather: Callable[[Recording], Any]
    estimate: Callable[[Any, Equipment], ClauseResult]
    required: tuple[str, ...] = ()
    printed_once: tuple[str, ...] = ()
    reported_conditions: tuple[str, ...] = ("dwell", "positions", "attitudes", "mounting")
    rate_sensor: Literal["gyro", "ahrs"] = "gyro"

    @property
    def definitions(self) -> dict[str, ItemDefinition]:
        """The items by their keys."""
        return {item.key: item for item in self.items}
