"""What the Quality page is asked for, as controls, and what they do."""

from collections.abc import Sequence
from typing import Any

import dash_mantine_components as dmc
from dash import ClientsideFunction, Dash, Input, Output, State, dcc
from dash.development.base_component import Component

from flows.pages.page import View
from flows.pages.quality.models import QualityQuestion, QualityShown
from storage.home import Home
from tasks.specifications.items import symbol

ASKED = ("model", "item", "element", "station", "serial", "since", "until", "plot")


def choices(shown: QualityShown, view: View, question: QualityQuestion) -> Component:
    """The question as it was answered, in controls that ask another one."""
    asked = question.model_dump(mode="json") | {
        "model": shown.model, "item": shown.item, "element": shown.element
    }  # fmt: skip
    known = shown.choices
    item = next((each for each in known.items if each.item == shown.item), None)
    of_items = [{"value": i.item, "label": view.say(i.title)} for i in known.items]
    of_elements = (
        [{"value": e, "label": symbol(item.item, e)} for e in item.elements] if item else []
    )
    plots = [
        {"value": each, "label": view.text(f"pages-quality-plot.{each}")}
        for each in ("value", "change")
    ]

    def select(name: str, values: Sequence[Any], *, needed: bool = False) -> Component:
        return dmc.Select(
            id=f"quality-{name}", label=view.text(f"pages-quality-asked.{name}"),
            data=list(values), value=asked[name], searchable=True, clearable=not needed,
            placeholder="" if needed else view.text("pages-quality-all"),
            allowDeselect=False,
        )  # fmt: skip

    def day(name: str) -> Component:
        return dmc.DateInput(
            id=f"quality-{name}", label=view.text(f"pages-quality-asked.{name}"),
            value=asked[name], valueFormat="YYYY-MM-DD", clearable=True, placeholder="YYYY-MM-DD",
        )  # fmt: skip

    controls = [
        select("model", known.models, needed=True), select("item", of_items, needed=True),
        select("element", of_elements, needed=True), select("station", known.stations),
        select("serial", known.serials), day("since"), day("until"),
        select("plot", plots, needed=True),
    ]  # fmt: skip
    grid = dmc.SimpleGrid(controls, cols={"base": 2, "sm": 4}, spacing="xs")
    kept = dcc.Store(id="quality-asked", data=asked)
    return dmc.DatesProvider([grid, kept], settings={"locale": view.language, "firstDayOfWeek": 1})


def callbacks(app: Dash, _: Home) -> None:
    """Another choice is another address; a point of the chart is its run."""
    app.clientside_callback(
        ClientsideFunction("quality", "ask"),
        Output("address", "search"),
        *(Input(f"quality-{name}", "value") for name in ASKED),
        State("quality-asked", "data"),
        prevent_initial_call=True,
    )
    app.clientside_callback(
        ClientsideFunction("quality", "open"),
        Output("address", "href"),
        Input("quality-chart", "clickData"),
        prevent_initial_call=True,
    )
