"""The Stop button of a station: one press, no question asked; and the address that it calls."""

from collections.abc import Callable
from typing import Any

import dash_mantine_components as dmc
from dash import html
from dash.development.base_component import Component
from flask import Blueprint, Response, request
from pydantic import ValidationError

from flows.pages.json_answers import json_answer, refusal
from flows.pages.line.models import AlarmPressed, StationNow, StopPressed, StopShown
from flows.pages.line.stops import stops_of
from flows.pages.local_time import second_of
from flows.pages.page import View, view_of_request
from schemas.access import MAY, Visitor
from schemas.base import Frozen, NotThere, Unusable, first_fault
from storage.home import Home
from tasks.words import message


def stop_button(station: str, view: View) -> Component:
    """Stops whatever the station does; for whoever may not, what stops it at the station.

    `stop.js` sees the press.
    """
    if not view.visitor.may("stop"):
        roles = tuple(message(f"pages-role.{role}") for role in MAY["stop"])
        hint = message("pages-line-stop.elsewhere", roles=roles, station=station)
        return html.Div(view.say(hint), className="station-details")
    asked: dict[str, Any] = {
        "data-stop": station,
        "data-failed": view.say(message("pages-line-stop.failed")),
    }
    word = view.say(message("pages-line-stop"))
    return html.Button([html.Span(className="stop-sign"), word], className="stop", **asked)


def release_button(now: StationNow, view: View) -> list[Component]:
    """Lets the orders of a station go on that was stopped; who stopped it, for whoever may not."""
    if now.lockout is None:
        return []
    stopped = {"by": now.lockout.by, "at": second_of(now.lockout.at)}
    stop = html.Div(view.say(message("pages-line-lockout", **stopped)), className="station-now")
    if not view.visitor.may("stop"):
        return [stop]
    asked: dict[str, Any] = {
        "data-release": now.station,
        "data-failed": view.say(message("pages-line-lockout.failed")),
    }
    word = view.say(message("pages-line-lockout.release"))
    return [stop, html.Button(word, className="release", **asked)]


def outcome_of_stop(now: StationNow, view: View) -> list[Component]:
    """The last press, for as long as no later run began."""
    stop = now.stopped
    is_old = stop is not None and now.run is not None and now.run.began_at > stop.at
    return [] if stop is None or is_old else [_outcome(stop, view)]


def _outcome(stop: StopShown, view: View) -> Component:
    """A table that may still turn is said so in red, and what to do at once."""
    rest = "at-rest" if stop.is_at_rest else "not-at-rest"
    words = message(f"pages-line-stop.{rest}", by=stop.by, at=second_of(stop.at))
    color = "green" if stop.is_at_rest else "red"
    return dmc.Alert(stop.fault, title=view.say(words), color=color, p="xs")


def stop_presses(home: Home) -> Blueprint:
    """POST /api/v1/stop and /api/v1/release with a station: stops it in the name of whoever is
    logged in, and lets its orders go on. POST /api/v1/acknowledge with the key of an alarm.
    """
    made = Blueprint("stop", __name__)

    @made.post("/api/v1/stop")
    def press() -> Response:
        return _done(lambda station, visitor: stops_of(home).press(station, visitor))

    @made.post("/api/v1/release")
    def release() -> Response:
        return _done(lambda station, visitor: stops_of(home).release(station, visitor))

    @made.post("/api/v1/acknowledge")
    def acknowledge() -> Response:
        return _done(lambda key, visitor: stops_of(home).acknowledge(key, visitor), AlarmPressed)

    return made


def _done(act: Callable[[str, Visitor], Frozen], pressed: type[Frozen] = StopPressed) -> Response:
    """What an act with the station or the alarm of the request gave, or why it was refused."""
    try:
        (about,) = pressed.model_validate_json(request.get_data()).model_dump().values()
        return json_answer(act(about, view_of_request().visitor).model_dump_json())
    except ValidationError as error:
        return refusal(400, first_fault(error))
    except Unusable as error:
        return refusal(404 if isinstance(error, NotThere) else 403, str(error))
