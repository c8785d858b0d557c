"""The Stop button of a station: one press, no question asked."""

from typing import Any

from dash import html
from dash.development.base_component import Component

from flows.pages.do.orders import roles_of
from flows.pages.line.models import AlarmShown, StationNow
from flows.pages.local_time import hour_of, second_of
from flows.pages.page import View
from flows.pages.parts import asking


def stop_button(station: str, view: View) -> Component:
    """Stops whatever the station does; for whoever may not, what stops it at the station.

    `stop.js` sees the press.
    """
    if not view.visitor.may("stop"):
        hint = view.text("pages-line-stop.elsewhere", roles=roles_of("stop"), station=station)
        return html.Div(hint, className="station-details")
    asked: dict[str, Any] = {
        "data-stop": station,
        "data-failed": view.text("pages-line-stop.failed"),
    }
    word = view.text("pages-line-stop")
    return html.Button([html.Span(className="stop-sign"), word], className="stop", **asked)


def lockout(now: StationNow, view: View) -> list[Component]:
    """Who stopped the station so that its orders wait, and whether its table is at rest; for
    whoever may, the button that lets it turn again, after a question. It stands far from Stop.
    """
    shown = _outcome_of_stop(now, view)
    if now.lockout is None:
        return [html.Div(shown, className="lockout")] if shown else []
    stopped = {"by": now.lockout.by, "at": second_of(now.lockout.at)}
    shown.append(html.Div(view.text("pages-line-lockout", **stopped)))
    if view.visitor.may("stop"):
        asked: dict[str, Any] = {
            "data-release": now.station,
            "data-failed": view.text("pages-line-lockout.failed"),
            **asking(view.text("pages-line-lockout.ask", station=now.station), view),
        }
        word = view.text("pages-line-lockout.release")
        shown.append(html.Button(word, className="release", **asked))
    return [html.Div(shown, className="lockout station-now")]


def acknowledgement(alarm: AlarmShown, view: View) -> Component | None:
    """Who saw to an alarm, else the button that says so, for whoever may."""
    if alarm.acknowledged is not None:
        by = {"by": alarm.acknowledged.by, "at": hour_of(alarm.acknowledged.at)}
        return html.Span(view.text("pages-line-acknowledged", **by))
    if not view.visitor.may("stop"):
        return None
    asked: dict[str, Any] = {
        "data-acknowledge": alarm.key,
        "data-failed": view.text("pages-line-acknowledge.failed"),
    }
    word = view.text("pages-line-acknowledge")
    return html.Button(word, className="acknowledge", **asked)


def _outcome_of_stop(now: StationNow, view: View) -> list[Component]:
    """The last stop, for as long as no later run began: a table that may still turn is said so in
    red, and what to do at once.
    """
    stop = now.stopped
    if stop is None or (now.run is not None and now.run.began_at > stop.at):
        return []
    rest = "at-rest" if stop.is_at_rest else "not-at-rest"
    words = view.text(f"pages-line-stop.{rest}", by=stop.by, at=second_of(stop.at))
    fault = [html.Div(view.say(stop.cause))] if stop.cause else []
    color = "good" if stop.is_at_rest else "bad"
    return [html.Div(words, className=f"at-rest alarm-{color}"), *fault]
