"""Options and translated texts that every grid shares."""

from typing import Any

from flows.pages.page import View
from tasks.words import identifiers, message

OWN_WORDS = "pages-grid-"
GRID_OPTIONS: dict[str, Any] = {
    "theme": "themeQuartz",
    "rowHeight": 38,
    "suppressCellFocus": True,
    "enableCellTextSelection": True,
    "animateRows": False,
}


def locale(view: View) -> dict[str, str]:
    """The grid's words by its own keys, which are the ends of the identifiers."""
    return {id_.removeprefix(OWN_WORDS): view.say(message(id_)) for id_ in identifiers(OWN_WORDS)}
