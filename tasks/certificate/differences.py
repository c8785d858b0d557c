"""What two certificates print differently: an amendment, and what it replaces."""

from collections.abc import Iterator

from schemas.calibration import Calibration
from schemas.certificate import Amended, Certificate
from tasks.certificate.content import content
from tasks.certificate.fields import NONE, field
from tasks.conformity.capabilities import certificate_as_stated
from tasks.specifications.items import item_title, symbol
from tasks.words import Sayable, clauses, message, statement
from tasks.words.quantities import quantity

NOT_COMPARED = {  # which certificate is replaced is said beside the changes
    field("replaces", "").label,
    field("settings", "").label,  # what they change stands in the values and their U
}


def differences(before: Certificate, after: Certificate) -> tuple[Amended, ...]:
    """Every field, standard, value with U and verdict that is printed otherwise than before."""
    old, new = (
        {label: statement(value) for label, value in _printed(each) if label not in NOT_COMPARED}
        for each in (before, after)
    )
    return tuple(
        Amended(what=statement(label), before=old.get(label, NONE), after=new.get(label, NONE))
        for label in dict.fromkeys((*old, *new))
        if old.get(label) != new.get(label)
    )


def _printed(certificate: Certificate) -> Iterator[tuple[Sayable, Sayable]]:
    """What a certificate prints, by its label."""
    printed = content(certificate)
    yield message("certificate-label-conclusion"), printed.verdict_text
    yield message("mandatory-what.laboratory"), printed.laboratory
    yield message("mandatory-what.laboratory-address"), printed.laboratory_address
    for each in (
        *printed.laboratory_fields,
        *printed.front,
        *printed.calibrated_object,
        *printed.conformity,
        *printed.trace,
    ):
        yield each.label, each.value
    operator = printed.signatures[0]
    yield operator.role, operator.name
    standards = [
        message("certificate-amended-standard", name=row.name, serial=row.serial,
                certificate=row.certificate)
        for row in printed.standards
    ]  # fmt: skip
    yield message("certificate-label-standards"), clauses(standards)
    yield message("certificate-label-traceability"), printed.traceability
    for row in printed.environment:
        yield row.name, row.measured
    yield from _values(certificate_as_stated(certificate).calibration)


def _values(calibration: Calibration) -> Iterator[tuple[Sayable, Sayable]]:
    """Every value with its U, and its unit."""
    for name, item in calibration.items.items():
        for element, value in item.value.items():
            if value is not None:
                U = item.U.get(element) or 0.0
                label = clauses((item_title(name), symbol(name, element)))
                yield label, quantity(value, U, item.unit)
