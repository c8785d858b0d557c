"""What a laboratory is capable of (CMC): no smaller U is stated, and none outside is accredited.

The result itself is left as it was evaluated; what is decided on and printed is `as_stated`.
"""

from collections.abc import Iterator, Sequence
from typing import Literal

from schemas.base import Unusable
from schemas.calibration import Calibration, Elements, Item
from schemas.capability import Capability, Range
from schemas.certificate import Certificate, Laboratory
from schemas.text import no_text, text_of
from tasks.conformity.equipment import untraceable
from tasks.specifications.items import ITEMS

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


def as_stated(calibration: Calibration, capabilities: Capabilities) -> Calibration:
    """The calibration with no U below the capabilities; as it is where none are given.

    U of a budget is the stated one too; its u_c and its lines remain what was evaluated.
    """
    if not capabilities:
        return calibration
    items = {
        name: _raised(item, _least(calibration, name, capabilities))
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
    capabilities = laboratory.capabilities
    if not_accredited(certificate) or outside_accreditation(certificate):
        laboratory = laboratory.model_copy(update=no_text("accreditation"))
    return certificate.model_copy(
        update={
            "laboratory": laboratory,
            "calibration": as_stated(certificate.calibration, capabilities),
            "as_found": found
            and found.model_copy(
                update={"calibration": as_stated(found.calibration, capabilities)}
            ),
        }
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
