"""The Stop button of a station: one press, no question asked."""

from typing import Any

import dash_mantine_components as dmc
from dash import MATCH, Dash, Input, Output, ctx, html, no_update
from dash.development.base_component import Component

from flows.pages.line.stops import stops_of
from flows.pages.local_time import second_of
from flows.pages.page import View, view_of_request
from schemas.access import MAY
from schemas.base import Unusable
from schemas.pages.line import StationNow, StopShown
from storage.home import Home
from tasks.words import message


def stop_button(station: str, view: View) -> Component:
    """Stops whatever the station does; for whoever may not, what stops it at the station."""
    if not view.visitor.may("stop"):
        roles = tuple(message(f"pages-role.{role}") for role in MAY["stop"])
        hint = message("pages-line-stop.elsewhere", roles=roles, station=station)
        return html.Div(view.say(hint), className="station-details")
    word = view.say(message("pages-line-stop"))
    return html.Button(
        [html.Span(className="stop-sign"), word], id={"stop": station}, className="stop"
    )


def what_became_of(now: StationNow, view: View) -> Component:
    """The last press, for as long as no later run began."""
    stop = now.stopped
    is_old = stop is not None and now.run is not None and now.run.began_at > stop.at
    shown = None if stop is None or is_old else _became(stop, view)
    return html.Div(shown, id={"stopped": now.station})


def _became(stop: StopShown, view: View) -> Component:
    """A table that may still turn is said so in red, and what to do at once."""
    rest = "at-rest" if stop.is_at_rest else "not-at-rest"
    words = message(f"pages-line-stop.{rest}", by=stop.by, at=second_of(stop.at))
    color = "green" if stop.is_at_rest else "red"
    return dmc.Alert(stop.fault, title=view.say(words), color=color, p="xs")


def callbacks(app: Dash, home: Home) -> None:
    """A press stops the station, in the name of whoever is logged in."""

    @app.callback(
        Output({"stopped": MATCH}, "children"),
        Input({"stop": MATCH}, "n_clicks"),
        prevent_initial_call=True,
    )
    def press(clicks: int | None) -> Any:
        if not clicks or not isinstance(ctx.triggered_id, dict):
            return no_update
        view = view_of_request()
        return pressed(str(ctx.triggered_id["stop"]), view, home)


def pressed(station: str, view: View, home: Home) -> Component:
    """Stops the station; what became of it, as the card shows it."""
    try:
        return _became(stops_of(home).press(station, view.visitor), view)
    except Unusable as error:
        return dmc.Alert(str(error), color="red", p="xs")
