"""Layout parts that several pages share."""

from collections.abc import Sequence
from typing import Any
from urllib.parse import urlencode

import dash_mantine_components as dmc
from dash import dcc
from dash.development.base_component import Component

from flows.pages.page import View
from tasks.words import Message, Sayable, cause_of, identifiers

OWN_WORDS = "pages-grid-"
GRID_OPTIONS: dict[str, Any] = {
    "theme": "themeQuartz",
    "rowHeight": 44,  # px, room for a finger
    "suppressCellFocus": True,
    "enableCellTextSelection": True,
    "animateRows": False,
}
Cell = str | Component | None
ON_ONE_LINE = 32  # letters


def table(
    headings: Sequence[Message], rows: Sequence[Sequence[Cell]], view: View, min_width: int = 600
) -> Component:
    """A plain table; what is missing is a dash. min_width: px, below which it scrolls."""
    head = dmc.TableThead(dmc.TableTr([dmc.TableTh(view.say(each)) for each in headings]))
    body = [dmc.TableTr([_cell(cell) for cell in row]) for row in rows]
    shown = dmc.Table(
        [head, dmc.TableTbody(body)], striped=True, withTableBorder=True, verticalSpacing=4
    )
    return dmc.TableScrollContainer(shown, minWidth=min_width)


def _cell(cell: Cell) -> Component:
    """What is short, as a symbol or a number, stands on one line: the table scrolls instead."""
    is_short = isinstance(cell, str) and len(cell) <= ON_ONE_LINE
    shown = "–" if cell is None else cell
    return dmc.TableTd(shown, maw=480, className="whole" if is_short else None)


def notice(view: View, words: str, color: str, fault: Exception | str = "") -> Component:
    """What stands in the place of a page or of what was asked for, with the cause of the fault."""
    cause = view.say(cause_of(fault)) if fault else ""
    return dmc.Alert(cause, title=view.text(words), color=color, className="notice")


def asking(question: Sayable, view: View) -> dict[str, str]:
    """What a button carries that acts after a question alone; `asking.js` puts it."""
    yes, no = (view.text(f"pages-asking.{word}") for word in ("yes", "no"))
    return {"data-ask": view.say(question), "data-yes": yes, "data-no": no}


def link(text: str, path: str, **fields: str) -> Component:
    """A link to a page with the fields of its question."""
    return dcc.Link(text, href=f"{path}?{urlencode(fields)}")


def facts(pairs: Sequence[tuple[Message, Cell]], view: View, across: int = 4) -> Component:
    """Names and what they are, side by side."""
    cards = [
        dmc.Box([dmc.Text(view.say(name), size="xs", c="dimmed"), _fact(value)])
        for name, value in pairs
    ]
    return dmc.SimpleGrid(cards, cols={"base": 2, "sm": across}, spacing="xs")


def _fact(value: Cell) -> Component:
    return value if isinstance(value, Component) else dmc.Text(value or "–", lineClamp=3)


def locale(view: View) -> dict[str, str]:
    """The grid's words by its own keys, which are the ends of the identifiers."""
    return {id_.removeprefix(OWN_WORDS): view.text(id_) for id_ in identifiers(OWN_WORDS)}
