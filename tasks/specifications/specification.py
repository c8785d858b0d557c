"""The record of a specification: everything that distinguishes it from another."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from schemas.calibration import Method
from schemas.recording import Recording, Standard
from tasks.segments.conditions import Conditions
from tasks.specifications.estimate import ClauseResult
from tasks.specifications.items import ItemDefinition
from tasks.uncertainty.equipment import Equipment
from tasks.words import Message, message


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
