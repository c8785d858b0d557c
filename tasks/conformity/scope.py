"""Checks that a limit and a calibration refer to the same item, unit and elements."""

from schemas.base import Unusable
from schemas.calibration import Calibration, Item
from schemas.tolerance import Limit
from tasks.specifications.items import ITEMS, second_value

WHOLE = ("all",)  # an item of which nothing is known but that it is unavailable


def check(calibration: Calibration, limit: Limit) -> None:
    """Raises Unusable for an unknown item, element or quantity, or another unit."""
    place = f"The tolerance limits {limit.item}"
    item = calibration.items.get(limit.item)
    if item is None and limit.item not in calibration.unavailable:
        known = ", ".join(sorted({*calibration.items, *calibration.unavailable}))
        raise Unusable(
            f"{place}, which calibration {calibration.run} by {calibration.method} does not "
            f"have: name one of {known}, or remove the limit."
        )
    unit = item.unit if item else ITEMS[limit.item].unit if limit.item in ITEMS else limit.unit
    if limit.unit != unit:
        raise Unusable(
            f"{place} in {limit.unit!r} but the result is in {unit!r}: give the limit in {unit!r}."
        )
    known_elements = _elements(item, limit.item)
    strange = [element for element in limit.elements or () if element not in known_elements]
    if limit.elements == () or (strange and known_elements != WHOLE):
        raise Unusable(
            f"{place} for the elements {strange}, but this item has "
            f"{', '.join(known_elements)}: name some of these or leave `elements` out."
        )
    if limit.applied_to not in ("value", second_value(limit.item)):
        raise Unusable(
            f"{place} with applied_to = {limit.applied_to!r}, a quantity that this item does not "
            "have: apply the limit to 'value'."
        )


def limited(item: Item | None, limit: Limit) -> tuple[str, ...]:
    """The elements that a limit is about."""
    return limit.elements or _elements(item, limit.item)


def withdrawn(calibration: Calibration, name: str) -> bool:
    """Whether an item is unavailable as a whole although all its numbers are there."""
    item = calibration.items.get(name)
    if name not in calibration.unavailable or item is None:
        return name in calibration.unavailable
    second = getattr(item, second_value(name) or "value")
    return second is not None and None not in (*item.value.values(), *second.values())


def _elements(item: Item | None, name: str) -> tuple[str, ...]:
    """Every element the item has; those of the specification also where the result lacks them."""
    named = ITEMS[name].elements if name in ITEMS else ()
    return tuple(dict.fromkeys((*named, *(item.value if item else ())))) or WHOLE
