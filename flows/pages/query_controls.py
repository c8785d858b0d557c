"""Controls that reload a page with another question: each is a parameter of the address."""

from collections.abc import Sequence
from typing import Any

import dash_mantine_components as dmc
from dash import ALL, ClientsideFunction, Dash, Input, Output, State
from dash.development.base_component import Component

from flows.pages.page import View


def asks(field: str, value: object) -> dict[str, str]:
    """The id of a control that asks for a field of the question and holds a value now."""
    return {"asks": field, "was": "" if value is None else str(value)}


def choice(
    field: str, label: str, values: Sequence[Any], value: object, view: View, every: str = ""
) -> Component:
    """A choice of one of some values, or with `every` of all. label, every: messages."""
    return dmc.Select(
        id=asks(field, value), label=view.text(label), data=list(values),
        value=None if value is None else str(value), searchable=True, clearable=bool(every),
        placeholder=view.text(every) if every else "", allowDeselect=False,
    )  # fmt: skip


def callbacks(app: Dash) -> None:
    """Another choice is another address."""
    control = {"asks": ALL, "was": ALL}
    app.clientside_callback(
        ClientsideFunction("asked", "ask"),
        Output("address", "search", allow_duplicate=True),
        Input(control, "value"),
        State(control, "id"),
        State("address", "search"),
        prevent_initial_call=True,
    )
