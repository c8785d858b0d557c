"""What a certificate says of the laboratory's capabilities (CMC) and of its accreditation."""

from collections.abc import Iterator

from schemas.certificate import Certificate
from tasks.conformity.capabilities import (
    not_accredited,
    outside_accreditation,
    raised_elements,
)
from tasks.specifications.items import item_title, symbol
from tasks.words import Message, message


def stated_above(certificate: Certificate) -> tuple[Message, ...]:
    """Of which elements a U smaller than the capability was evaluated, before it was raised."""
    found, laboratory = certificate.as_found, certificate.laboratory
    raised = raised_elements(certificate.calibration, laboratory)
    before = raised_elements(found.calibration, laboratory) if found else {}
    items = tuple(
        message(
            "certificate-capability-item", item=item_title(name),
            symbols=", ".join(
                symbol(name, element)
                for element in dict.fromkeys((*raised.get(name, ()), *before.get(name, ())))
            ),
        )
        for name in dict.fromkeys((*raised, *before))
    )  # fmt: skip
    return (message("certificate-capability.stated", items=items),) if items else ()


def without_accreditation(certificate: Certificate) -> Iterator[Message]:
    """Why nothing refers to the accreditation: of the whole certificate, or of which items."""
    if why := not_accredited(certificate):
        yield message(f"certificate-accreditation-not-claimed.{why}")
    elif outside := outside_accreditation(certificate):
        items = tuple(item_title(name) for name in outside)
        yield message("certificate-capability.outside", items=items)
