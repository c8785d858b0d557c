"""The unit as found, before adjustment, beside the unit as left."""

from collections.abc import Iterator
from dataclasses import dataclass

from schemas.calibration import Elements, Item
from schemas.certificate import AsFound, Certificate
from schemas.decision import LimitDecision
from schemas.tolerance import Quantity
from tasks.certificate import cover
from tasks.certificate.element_rows import Mark, mark
from tasks.certificate.fields import Field, day, field, given
from tasks.conformity.limits import quantity_title
from tasks.specifications.items import ItemDefinition, item_title
from tasks.specifications.specification import Specification
from tasks.words import Message, Sayable, message
from tasks.words.quantities import unit_text
from tasks.words.rounding import column


@dataclass(frozen=True)
class FoundRow:
    """One element: value and U as found and as left (None: no number), the marks as found."""

    name: Sayable
    letter: str
    sub: str
    found: str | None
    U_found: str | None
    left: str | None
    U_left: str | None
    marks: tuple[Mark, ...]


@dataclass(frozen=True)
class FoundGroup:
    """One item, in units of 10^exponent; quantity: which value, where it is not the clause's."""

    title: Sayable
    quantity: Message | None
    unit: str
    exponent: int
    rows: tuple[FoundRow, ...]


@dataclass(frozen=True)
class FoundSection:
    """What is printed of the unit as found."""

    fields: tuple[Field, ...]
    introduction: Message
    groups: tuple[FoundGroup, ...]


def scope_with_found(certificate: Certificate, scope: Message | None) -> Message | None:
    """The scope of the verdict, for the first page, with the verdict as found."""
    found = certificate.as_found
    if found is None or scope is None:
        return scope
    verdict = cover.verdict(found.decision)
    return message("certificate-scope.as-found", scope=scope, verdict=verdict)


def as_found(certificate: Certificate, specification: Specification) -> FoundSection | None:
    """Every item that is known as found or as left; None for a unit that was not adjusted."""
    found = certificate.as_found
    if found is None:
        return None
    calibration = found.calibration
    return FoundSection(
        fields=(
            field("calibrated", day(found.calibrated_on)),
            field("recording", given(calibration.recording_id)),
            field("run", given(calibration.run)),
            field("digest", given(calibration.digest)),
            field("as-found", cover.verdict(found.decision)),
        ),
        introduction=message("certificate-as-found"),
        groups=tuple(_groups(found, certificate, specification)),
    )


def _groups(
    found: AsFound, certificate: Certificate, specification: Specification
) -> Iterator[FoundGroup]:
    for name, definition in specification.definitions.items():
        before = found.calibration.items.get(name)
        after = certificate.calibration.items.get(name)
        if before is None or after is None:
            continue
        limits = [limit for limit in found.decision.limits if limit.item == name]
        group = _group(definition, before, after, limits)
        if any(row.found or row.left for row in group.rows):
            yield group


def _group(
    definition: ItemDefinition, before: Item, after: Item, limits: list[LimitDecision]
) -> FoundGroup:
    quantity: Quantity = limits[0].applied_to if limits else "value"
    elements, n = definition.elements, len(definition.elements)
    numbers = [_numbers(item, quantity) for item in (before, after)]
    printed = column(
        [values.get(e) for values, _ in numbers for e in elements],
        [U.get(e) for _, U in numbers for e in elements],
        after.k,
    )
    return FoundGroup(
        title=item_title(definition.key),
        quantity=quantity_title(limits[0]) if quantity != "value" else None,
        unit=unit_text(after.unit),
        exponent=printed.exponent,
        rows=tuple(
            FoundRow(
                name=definition.element_title(element),
                letter=definition.letter,
                sub=definition.element_subscript(element),
                found=printed.values[i],
                U_found=printed.uncertainties[i],
                left=printed.values[n + i],
                U_left=printed.uncertainties[n + i],
                marks=tuple(mark(limit) for limit in limits if limit.element == element),
            )
            for i, element in enumerate(elements)
        ),
    )


def _numbers(item: Item, quantity: Quantity) -> tuple[Elements, Elements]:
    """The values that the limits are applied to, and their U."""
    without_earth = quantity == "value_without_earth_rotation"
    own = item.U_without_earth_rotation if without_earth else None
    return getattr(item, quantity) or {}, own or item.U
