"""What the Quality page is asked for, as controls, and what they do."""

from collections.abc import Sequence
from typing import Any

import dash_mantine_components as dmc
from dash import ClientsideFunction, Dash, Input, Output
from dash.development.base_component import Component

from flows.pages.page import View
from flows.pages.quality.models import QualityQuestion, QualityShown
from flows.pages.query_controls import asks, choice
from storage.home import Home
from tasks.specifications.items import symbol

EVERY = "pages-quality-all"


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

    def select(name: str, values: Sequence[Any], every: str = "") -> Component:
        return choice(name, f"pages-quality-asked.{name}", values, asked[name], view, every)

    def day(name: str) -> Component:
        return dmc.DateInput(
            id=asks(name, asked[name]), label=view.text(f"pages-quality-asked.{name}"),
            value=asked[name], valueFormat="YYYY-MM-DD", clearable=True, placeholder="YYYY-MM-DD",
        )  # fmt: skip

    controls = [
        select("model", known.models), select("item", of_items), select("element", of_elements),
        select("station", known.stations, EVERY), select("serial", known.serials, EVERY),
        day("since"), day("until"), select("plot", plots),
    ]  # fmt: skip
    shown_all = dmc.SimpleGrid(controls, cols={"base": 2, "sm": 4}, spacing="xs")
    return dmc.DatesProvider(shown_all, settings={"locale": view.language, "firstDayOfWeek": 1})


def callbacks(app: Dash, _: Home) -> None:
    """A point of the chart is its run."""
    app.clientside_callback(
        ClientsideFunction("quality", "open"),
        Output("address", "href"),
        Input("quality-chart", "clickData"),
        prevent_initial_call=True,
    )
