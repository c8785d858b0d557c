"""The numbers of a page's tables and charts as CSV, for a spreadsheet or a script of one's own."""

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from typing import Any
from urllib.parse import urlencode

from dash import html
from dash.development.base_component import Component

from schemas.base import Frozen

Row = Mapping[str, Any]
Numbers = Mapping[str, Callable[[Any], Sequence[Row]]]  # rows of an answer, by the name of the part
BOM = "\ufeff"  # without it, spreadsheets do not recognise UTF-8
FORMULA = ("=", "+", "-", "@", "\t", "\r")  # characters with which a spreadsheet formula begins


def rows_of(shown: Sequence[Frozen], **same: Any) -> list[Row]:
    """Each model as a row, after fields that are the same in all of them."""
    return [{**same, **_flat(each.model_dump(mode="json"))} for each in shown]


def _flat(fields: Row) -> dict[str, Any]:
    """A model inside a model is a column for each of its fields, a text one for each language."""
    flat: dict[str, Any] = {}
    for name, value in fields.items():
        if isinstance(value, Mapping):
            inside = ((inner, each) for inner, each in value.items() if inner != "message")
            flat |= {f"{name}_{inner}": each for inner, each in inside}
        else:
            flat[name] = value
    return flat


def csv_of(rows: Sequence[Row]) -> str:
    """CSV (RFC 4180) with a heading; nothing at all of no rows."""
    written = io.StringIO()
    if rows:
        writer = csv.DictWriter(written, list(rows[0]))
        writer.writeheader()
        writer.writerows({name: _cell(value) for name, value in row.items()} for row in rows)
    return BOM + written.getvalue()


def _cell(value: Any) -> Any:
    if isinstance(value, list):
        return " ".join(map(str, value))
    is_formula = isinstance(value, str) and value.startswith(FORMULA)
    return f"'{value}" if is_formula else value


def csv_link(page: str, part: str, question: Frozen) -> Component:
    """A link that downloads a part of the answer to the same question."""
    asked = {name: str(value) for name, value in question if value is not None}
    href = f"/api/v1/{page}/{part}.csv?{urlencode(asked)}"
    return html.A("CSV ↓", href=href, className="csv", download=f"{page}-{part}.csv")
