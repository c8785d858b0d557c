"""Charts, drawn after the text of their page and in the colours of the theme."""

from collections.abc import Sequence
from typing import Any

import dash_mantine_components as dmc
import plotly.io
from dash import MATCH, ClientsideFunction, Dash, Input, Output, dcc
from dash.development.base_component import Component

from flows.pages.parts import View

BLUE, RED, ORANGE, GREY = "#1c7ed6", "#e03131", "#f08c00", "#868e96"
GRAPH: Any = {"displaylogo": False, "responsive": True}
Figure = dict[str, Any]


def figure(traces: Sequence[Figure], view: View, height: int, **layout: Any) -> Figure:
    """Traces and layout as plotly takes them. height: px."""
    if view.figure_template not in plotly.io.templates:
        dmc.add_figure_templates()
    template = plotly.io.templates[view.figure_template].to_plotly_json()
    usual = {"margin": {"t": 20, "r": 20, "l": 70, "b": 50}, "height": height, "showlegend": False}
    return {"data": list(traces), "layout": {"template": template, **usual, **layout}}


def picture(id_: str, drawn: Figure) -> Component:
    """A picture that is drawn once the text stands, in a place of its height."""
    graph = dcc.Graph(id=id_, figure=drawn, config=GRAPH)
    kept = dcc.Store(id={"type": "picture-kept", "name": id_}, data=graph.to_plotly_json())
    place = dmc.Box(id={"type": "picture", "name": id_}, mih=drawn["layout"]["height"])
    return dmc.Box([kept, place])


def callbacks(app: Dash) -> None:
    """Each picture into its place."""
    app.clientside_callback(
        ClientsideFunction("pictures", "show"),
        Output({"type": "picture", "name": MATCH}, "children"),
        Input({"type": "picture-kept", "name": MATCH}, "data"),
    )
