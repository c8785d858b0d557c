"""Layout parts that several pages share."""

from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import urlencode

import dash_ag_grid as dag
import dash_mantine_components as dmc
from dash import dcc
from dash.development.base_component import Component

from flows.pages.page import View
from tasks.words import Argument, cause_of, identifiers

OWN_WORDS = "pages-grid-"
GRID_OPTIONS: dict[str, Any] = {
    "theme": "themeQuartz",
    "rowHeight": 44,  # px, room for a finger
    "suppressCellFocus": True,
    "enableCellTextSelection": True,
    "animateRows": False,
}
Cell = str | Component | None
ON_ONE_LINE = 32  # bytes: Latin letters, or ten Chinese ones, which are as wide


def table(
    group: str,
    names: str,
    rows: Sequence[Sequence[Cell]],
    view: View,
    min_width: int = 600,
    none: str = "",
    **arguments: Argument,
) -> Component:
    """A plain table; what is missing is a dash. names: of the columns, whose headings are the
    messages GROUP.NAME, or the one that is named whole, with these arguments. min_width: px, below
    which it scrolls. none: the message in the place of a table without rows.
    """
    if none and not rows:
        return dmc.Text(view.text(none), size="sm")
    ids = [name if name.startswith("pages-") else f"{group}.{name}" for name in names.split()]
    head = dmc.TableThead(dmc.TableTr([dmc.TableTh(view.text(id_, **arguments)) for id_ in ids]))
    body = [dmc.TableTr([_cell(cell) for cell in row]) for row in rows]
    shown = dmc.Table(
        [head, dmc.TableTbody(body)], striped=True, withTableBorder=True, verticalSpacing=4
    )
    return dmc.TableScrollContainer(shown, minWidth=min_width)


def _cell(cell: Cell) -> Component:
    """What is short, as a symbol or a link, stands on one line: the table scrolls instead."""
    is_short = (
        len(cell.encode()) <= ON_ONE_LINE if isinstance(cell, str) else isinstance(cell, dcc.Link)
    )
    shown = "–" if cell is None else cell
    return dmc.TableTd(shown, maw=480, className="whole" if is_short else None)


def heading(id_: str, view: View, more: str = "") -> Component:
    """Of a part of a page, as a message by its identifier."""
    return dmc.Title(view.text(id_) + more, order=3, mt="sm")


def note(text: str) -> Component:
    """What explains what stands beside it."""
    return dmc.Text(text, size="sm", c="dimmed")


def notice(view: View, words: str, color: str, fault: Exception | str = "") -> Component:
    """What stands in the place of a page or of what was asked for, with the cause of the fault."""
    cause = view.say(cause_of(fault)) if fault else ""
    return dmc.Alert(cause, title=view.text(words), color=color, className="notice")


def asking(question: str, view: View) -> dict[str, str]:
    """What a button carries that acts after a question alone; `asking.js` puts it."""
    yes, no = (view.text(f"pages-asking.{word}") for word in ("yes", "no"))
    return {"data-ask": question, "data-yes": yes, "data-no": no}


def link(text: str, path: str, **fields: str) -> Component:
    """A link to a page with the fields of its question."""
    return dcc.Link(text, href=f"{path}?{urlencode(fields)}")


def facts(named: Mapping[str, Cell], view: View, across: int = 4) -> Component:
    """Names, as messages by their identifiers, and what they are, side by side."""
    cards = [
        dmc.Box([dmc.Text(view.text(id_), size="xs", c="dimmed"), _fact(value)])
        for id_, value in named.items()
    ]
    return dmc.SimpleGrid(cards, cols={"base": 2, "sm": across}, spacing="xs")


def _fact(value: Cell) -> Component:
    return value if isinstance(value, Component) else dmc.Text(value or "–", lineClamp=3)


def grid(
    id_: str, group: str, names: str, rows: Sequence[Any], view: View, height: str, min_width: int,
    own: Mapping[str, Mapping[str, Any]],
) -> Component:  # fmt: skip
    """Rows that are sorted and filtered as somebody looks at them. group, names: as of a table;
    own: what a column has of its own. min_width: of a column, px.
    """
    columns = [
        {"field": name, "headerName": view.text(f"{group}.{name}"), **own.get(name, {})}
        for name in names.split()
    ]
    return dag.AgGrid(
        id=id_, columnDefs=columns, rowData=rows,
        defaultColDef={"resizable": True, "sortable": True, "flex": 1, "minWidth": min_width,
                       "filter": "agTextColumnFilter", "floatingFilter": True},
        dashGridOptions=GRID_OPTIONS | {"localeText": locale(view)},
        style={"height": height},
    )  # fmt: skip


def locale(view: View) -> dict[str, str]:
    """The grid's words by its own keys, which are the ends of the identifiers."""
    return {id_.removeprefix(OWN_WORDS): view.text(id_) for id_ in identifiers(OWN_WORDS)}
