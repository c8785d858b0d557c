"""What a laboratory is capable of (CMC): no smaller U is stated, and none outside is accredited.

The result itself is left as it was evaluated; what is decided on and printed is `as_stated`.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from datetime import date
from typing import Literal

from schemas.base import Unusable
from schemas.calibration import BudgetInput, Calibration, Elements, Item
from schemas.certificate import Certificate, Laboratory
from schemas.laboratory import EquipmentLimit, MeasurementStandard
from schemas.text import no_text, text_of
from schemas.tolerance import Capability, LimitDecision, Range
from tasks.specifications.estimate import ITEMS
from tasks.uncertainty.equipment import (
    LIMIT_NAMES,
    TAKEN_TO_BE_MET,
    FunctionSource,
    standard_uncertainty,
    stated_limits,
)
from tasks.words import Message, Sayable, message
from tasks.words.numbers import clause, plain, quantity_text

# Reasons on the side of the measuring equipment that prevent a pass.

LIMIT_ROUNDING = 1e-9  # relative: two limits that differ by less are one


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
        and line.u < standard_uncertainty(stated[name]) * (1 - LIMIT_ROUNDING)
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


Capabilities = Sequence[Capability]


def check_capabilities(capabilities: Capabilities) -> None:
    """Raises Unusable for items and units that no specification has, all at once."""
    faults = []
    for n, each in enumerate(capabilities, start=1):
        if each.item not in ITEMS:
            known = ", ".join(sorted(ITEMS))
            faults.append(f"capability {n} is of {each.item!r}, which is none of {known}")
        elif each.unit != (unit := ITEMS[each.item].unit):
            faults.append(f"capability {n} is in {each.unit!r}, but {each.item} is in {unit!r}")
    if faults:
        raise Unusable(f"laboratory.toml: {'; '.join(faults)}; correct [[capabilities]] there.")


def as_stated(calibration: Calibration, laboratory: Laboratory | None) -> Calibration:
    """The calibration with no U below a laboratory's capabilities; as it is where it has none.

    U of a budget is the stated one too; its u_c and its lines remain what was evaluated.
    """
    if laboratory is None or not laboratory.capabilities:
        return calibration
    items = {
        name: _raised(item, _least(calibration, name, laboratory.capabilities))
        for name, item in calibration.items.items()
    }
    return calibration.model_copy(update={"items": items})


def certificate_as_stated(certificate: Certificate) -> Certificate:
    """The certificate with every U as it is stated, and the accreditation where it may be claimed.

    Accreditation is not referred to where an item is not covered (ISO/IEC 17025:2017, 8.1;
    ILAC-P8), where a standard is not traceable, in a simplified report, and of an invalid run.
    """
    laboratory, found = certificate.laboratory, certificate.as_found
    if laboratory is None:
        return certificate
    if not_accredited(certificate) or outside_accreditation(certificate):
        laboratory = laboratory.model_copy(update=no_text("accreditation"))
    if found:
        stated = as_stated(found.calibration, laboratory)
        found = found.model_copy(update={"calibration": stated})
    calibration = as_stated(certificate.calibration, laboratory)
    return certificate.model_copy(
        update={"laboratory": laboratory, "calibration": calibration, "as_found": found}
    )


def not_accredited(certificate: Certificate) -> Literal["report", "untraceable"] | None:
    """Why a whole certificate is none under the accreditation that its laboratory names."""
    laboratory = certificate.laboratory
    if laboratory is None or not text_of(laboratory, "accreditation"):
        return None
    if certificate.report or certificate.calibration.validity.verdict == "invalid":
        return "report"
    return "untraceable" if untraceable(laboratory.equipment) else None


def outside_accreditation(certificate: Certificate) -> tuple[str, ...]:
    """The items with a value that no capability covers; none where no accreditation is claimed."""
    laboratory, found = certificate.laboratory, certificate.as_found
    if laboratory is None or not laboratory.capabilities:
        return ()
    if not text_of(laboratory, "accreditation"):
        return ()
    results = [certificate.calibration, *([found.calibration] if found else [])]
    outside = (
        name
        for result in results
        for name, item in result.items.items()
        if set(_known(item)) - _least(result, name, laboratory.capabilities).keys()
    )
    return tuple(dict.fromkeys(outside))


def raised_elements(
    calibration: Calibration, laboratory: Laboratory | None
) -> dict[str, tuple[str, ...]]:
    """By item, the elements whose evaluated U is below the capability."""
    capabilities = laboratory.capabilities if laboratory else ()
    found = {
        name: tuple(
            element
            for element, least in _least(calibration, name, capabilities).items()
            if (U := item.U.get(element)) is not None and least > U
        )
        for name, item in calibration.items.items()
    }
    return {name: elements for name, elements in found.items() if elements}


def _raised(item: Item, least: dict[str, float]) -> Item:
    def raised(U: Elements) -> Elements:
        return {e: None if u is None else max(u, least.get(e, 0.0)) for e, u in U.items()}

    second = item.U_without_earth_rotation
    return item.model_copy(
        update={
            "U": raised(item.U),
            "U_without_earth_rotation": second and raised(second),
            "budgets": {
                e: budget.model_copy(update={"U": max(budget.U, least.get(e, 0.0))})
                for e, budget in item.budgets.items()
            },
        }
    )


def _known(item: Item) -> Iterator[str]:
    return (element for element, value in item.value.items() if value is not None)


def _least(calibration: Calibration, name: str, capabilities: Capabilities) -> dict[str, float]:
    """The smallest U that may be stated of each element that is covered.

    Covered is an element by the capabilities that hold its value, if between them they hold every
    rate that the run was held at; of these the largest U counts.
    """
    of_item = [each for each in capabilities if each.item == name]
    rates = {abs(s.rate_deg_s) for s in calibration.segments if s.kind == "rate" and s.rate_deg_s}
    item = calibration.items[name]
    least = {}
    for element in _known(item):
        value = item.value[element] or 0.0
        here = [each for each in of_item if _holds(each.values, value)]
        used = [
            each
            for each in here
            if each.rates_deg_s is None or any(_holds(each.rates_deg_s, rate) for rate in rates)
        ]
        if used and all(any(_holds(each.rates_deg_s, rate) for each in used) for rate in rates):
            least[element] = max(each.U * abs(value) if each.relative else each.U for each in used)
    return least


def _holds(stated: Range | None, number: float) -> bool:
    return stated is None or stated[0] <= number <= stated[1]
