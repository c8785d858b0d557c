"""Reasons on the side of the measuring equipment that prevent a pass."""

import math
from collections.abc import Iterable, Iterator, Sequence
from datetime import date

from schemas.calibration import Calibration
from schemas.decision import LimitDecision
from schemas.equipment import EquipmentLimit, MeasurementStandard
from schemas.text import text_of
from schemas.uncertainty import BudgetInput
from tasks.uncertainty.equipment import (
    LIMIT_NAMES,
    TAKEN_TO_BE_MET,
    standard_uncertainty,
    stated_limits,
)
from tasks.uncertainty.standards import FunctionSource
from tasks.words import Message, Sayable, message
from tasks.words.quantities import plain, quantity_text
from tasks.words.typography import clause

ROUNDING = 1e-9  # relative: two limits that differ by less are one


def expired(equipment: Iterable[MeasurementStandard], on: date) -> tuple[Message, ...]:
    """A reason against a pass for each standard whose certificate had run out on a day."""
    return tuple(
        message(
            "conformity-expired",
            name=name_of(standard), serial=standard.serial,
            valid_until=str(standard.valid_until), day=str(on),
        )
        for standard in equipment
        if standard.valid_until and standard.valid_until < on
    )  # fmt: skip


def is_traceable(standard: MeasurementStandard) -> bool:
    """Whether a certificate shows that what a standard states is traceable to the SI."""
    return standard.traceable and not standard.virtual and bool(standard.certificate.strip())


def is_virtual(equipment: Sequence[MeasurementStandard]) -> bool:
    """Whether standards are those of a simulation, all of them."""
    return bool(equipment) and all(standard.virtual for standard in equipment)


def untraceable(equipment: Sequence[MeasurementStandard]) -> tuple[Message, ...]:
    """The reason against a pass where a standard has no traceability, or none is named.

    Whatever limits its papers state: nobody has shown that they hold.
    """
    if not equipment:
        return (message("conformity-untraceable.none"),)
    bare = tuple(
        message("conformity-named", name=name_of(standard), serial=standard.serial)
        for standard in equipment
        if not is_traceable(standard)
    )
    return (message("conformity-untraceable", standards=bare),) if bare else ()


def failed_checks(equipment: Iterable[MeasurementStandard]) -> tuple[Message, ...]:
    """A reason against a pass for each intermediate check of a standard beyond its limit."""
    return tuple(
        message(
            "conformity-check-failed",
            name=name_of(standard), serial=standard.serial, day=str(check.checked_on),
            what=text_of(check, "what") or "",
            result=quantity_text(plain(check.result, 6), check.unit or "1"),
            limit=quantity_text(plain(check.limit, 6), check.unit or "1"),
        )
        for standard in equipment
        for check in standard.checks
        if not check.passed
    )  # fmt: skip


def taken_to_be_met(
    calibration: Calibration, decisions: Iterable[LimitDecision]
) -> tuple[Message, ...]:
    """The reason against a pass where U of a limited element rests on a specification's limits.

    A table that recommends what equipment should keep says nothing of the equipment that was used.
    """
    lines = [
        line
        for decided in decisions
        for line in _lines(calibration, decided)
        if line.source in TAKEN_TO_BE_MET and line.contribution > 0
    ]
    if not lines:
        return ()
    names = dict.fromkeys(map(name_of, lines))
    sources = dict.fromkeys(clause(str(line.source)) for line in lines)
    return (message("conformity-taken-to-be-met", limits=tuple(names), sources=tuple(sources)),)


def smaller_than_stated(
    calibration: Calibration, equipment: Iterable[MeasurementStandard], day: date
) -> tuple[Message, ...]:
    """A reason against a pass for each limit in a budget below what the equipment's paper states.

    Compared are standard uncertainties, of the lines that are the laboratory's own; of what is
    stated by rate or angle the largest. day: of the measurement. What a line has from the function
    of the same certificate, drift of its own day included, is what is stated.
    """
    stated = stated_limits(equipment, day)
    used = {LIMIT_NAMES[line.symbol]: line for line in _own_lines(calibration)}
    return tuple(
        message(
            "conformity-smaller-than-stated",
            limit=name_of(line), source=str(line.source),
            used=bound_text(line.half_width or 0.0, line.unit), shape=_shape(line.distribution),
            stated=bound_text(stated[name].half_width, line.unit),
            stated_shape=_shape(stated[name].distribution), paper=stated[name].source,
        )
        for name, line in used.items()
        if name in stated
        and not _is_its_function(line, stated[name])
        and line.u < standard_uncertainty(stated[name]) * (1 - ROUNDING)
    )  # fmt: skip


def name_of(each: MeasurementStandard | BudgetInput) -> Sayable:
    """The name of a standard, or of an input quantity."""
    return text_of(each, "name") or ""


def bound_text(half_width: float, unit: str) -> str:
    """How far a property may be off, with its unit; angles in arcseconds."""
    if unit == "rad":
        return f"±{3600 * math.degrees(half_width):.4g}″"
    return f"±{quantity_text(plain(half_width, 4), unit)}"


def _lines(calibration: Calibration, decided: LimitDecision) -> tuple[BudgetInput, ...]:
    """The budget of a decided element; nothing where it has none."""
    item = calibration.items.get(decided.item)
    budget = item.budgets.get(decided.element) if item else None
    return budget.inputs if budget else ()


def _own_lines(calibration: Calibration) -> Iterator[BudgetInput]:
    for item in calibration.items.values():
        for budget in item.budgets.values():
            for line in budget.inputs:
                own = line.source is not None and line.source not in TAKEN_TO_BE_MET
                if own and line.half_width is not None and line.symbol in LIMIT_NAMES:
                    yield line


def _is_its_function(line: BudgetInput, stated: EquipmentLimit) -> bool:
    used, paper = (FunctionSource.read(str(each.source)) for each in (line, stated))
    return used is not None and paper is not None and used.paper == paper.paper


def _shape(distribution: str) -> Message:
    return message(f"certificate-distribution.{distribution}")
