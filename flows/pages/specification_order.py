"""The order of items and elements on the pages: that of the specifications."""

from tasks.specifications.items import ITEMS

ORDER = {item: place for place, item in enumerate(ITEMS)}


def place(item: str, element: str = "") -> tuple[int, str, int, str]:
    """What to sort by; an item or element that no specification has comes last, by its name."""
    elements = ITEMS[item].elements if item in ITEMS else ()
    within = elements.index(element) if element in elements else len(elements)
    return ORDER.get(item, len(ORDER)), item, within, element
