"""The card of a station, whose large type is read from three metres."""

from collections.abc import Sequence
from datetime import timedelta

import dash_mantine_components as dmc
from dash import html
from dash.development.base_component import Component

from flows.pages.line.models import AlarmShown, Queued, StationNow
from flows.pages.line.stop_button import lockout, stop_button
from flows.pages.local_time import hour_of, second_of
from flows.pages.page import View
from flows.pages.states import Kind
from schemas.run_log import RunStatus
from tasks.words import Sayable, message

WAITING_SHOWN = 3
UNITS = {"gyro": "°/s", "accel": "m/s²"}
# What is good, what waits for a person, what went wrong; a free station asks for nothing.
KINDS: dict[str, Kind] = {
    "free": "none", "begun": "good", "warming_up": "good", "measuring": "good", "repeating": "open",
    "paused": "open", "turning_over": "open", "finishing": "good", "done": "none",
    "stopped": "bad", "lost": "bad", "silent": "bad",
}  # fmt: skip
RUNS = ("begun", "warming_up", "measuring", "repeating", "paused", "turning_over", "finishing")


def card(now: StationNow, view: View) -> Component:
    """State and station, units, segment and remaining time, alarm, queue, and Stop."""
    word = view.text(f"pages-line-state.{now.state.replace('_', '-')}")
    head = [
        html.Div(word, className="station-state"),
        html.Div(now.station, className="station-id"),
    ]
    body: list[Component] = []
    if now.run is not None and now.state != "free":
        body += _run(now, now.run, view)
    else:
        body += _free(now, view)
    if now.alarm is not None:
        body.append(_alarm(now.alarm, now, view))
    body += _queue(now.waiting, view)
    return html.Section(
        [
            html.Div(head, className=f"station-head station-{KINDS[now.state]}"),
            *lockout(now, view),
            html.Div(body, className="station-body"),
            html.Div(stop_button(now.station, view), className="station-foot"),
        ],
        className="station",
    )


def _run(now: StationNow, run: RunStatus, view: View) -> list[Component]:
    share = 100 * run.station_s_done / run.station_s_total if run.station_s_total else 0
    parts: list[Component] = [
        html.Div(", ".join(run.units), className="station-units"),
        html.Div(f"{run.procedure} · {run.now}", className="station-now"),
    ]
    large = [_figure(message("pages-line-segment"), f"{run.segment} / {run.segments}", view)]
    if now.state in RUNS:
        end = hour_of(run.at + timedelta(seconds=run.wall_s_left))
        left = view.say(_duration(run.wall_s_left))
        large.append(_figure(message("pages-line-left", end=end), left, view))
    parts += [
        html.Div(large, className="station-figures"),
        dmc.Progress(value=min(share, 100), size="lg"),
        html.Div(_details(run, view), className="station-details one-line"),
    ]
    return parts


def _free(now: StationNow, view: View) -> list[Component]:
    """What is to be mounted next, and what was measured last."""
    ahead = [each for each in now.waiting if each.state == "waiting"]
    parts: list[Component] = []
    if ahead:
        parts.append(html.Div(", ".join(ahead[0].serials), className="station-units"))
        parts.append(_small(message("pages-line-next", procedure=ahead[0].procedure), view))
    if now.run is None:
        return [*parts, _small(message("pages-line-never"), view)]
    units, at = ", ".join(now.run.units), hour_of(now.run.at)
    return [*parts, _small(message("pages-line-last-done", unit=units, at=at), view)]


def _figure(name: Sayable, value: str, view: View) -> Component:
    return html.Div([
        html.Div(value, className="station-figure"),
        html.Div(view.say(name), className="station-details"),
    ])  # fmt: skip


def _duration(seconds: float) -> Sayable:
    """Minutes, rounded up, at least one."""
    minutes = max(1, -int(-seconds // 60))
    hours, rest = divmod(minutes, 60)
    if hours:
        return message("pages-line-duration.hours", hours=hours, minutes=f"{rest:02d}")
    return message("pages-line-duration.minutes", minutes=rest)


def _details(run: RunStatus, view: View) -> str:
    rates = [f"{name} {rate:.1f} Hz" for name, rate in run.rates_hz.items()]
    noise = [f"{name} {value:.2g} {UNITS.get(name, '')}" for name, value in run.noise.items()]
    at = view.text("pages-line-at", at=second_of(run.at))
    return " · ".join([at, *rates, *noise])


def _alarm(alarm: AlarmShown, now: StationNow, view: View) -> Component:
    """Red where the station stands for it; else it is one that a run goes on or ended with."""
    kind = "bad" if KINDS[now.state] == "bad" else "open"
    at = f"{hour_of(alarm.at)}  " if alarm.at else ""
    return html.Div(
        [
            html.Div(f"{at}{view.say(alarm.cause)}", className="station-cause"),
            html.Div(f"→ {view.say(alarm.todo)}"),
        ],
        className=f"station-alarm alarm-{kind}",
    )


def _queue(waiting: Sequence[Queued], view: View) -> list[Component]:
    """How many orders wait, and the next ones, and what keeps one from beginning; a running one is
    on the card already.
    """
    ahead = [each for each in waiting if each.state == "waiting"]
    if not ahead:
        return []
    named = [f"{', '.join(each.serials)} ({each.procedure})" for each in ahead[:WAITING_SHOWN]]
    parts = [_small(message("pages-line-waiting", count=len(ahead), named=tuple(named)), view)]
    hindrances = [view.say(each.hindrance) for each in ahead if each.hindrance]
    return [*parts, *(html.Div(each, className="station-alarm alarm-open") for each in hindrances)]


def _small(text: Sayable, view: View) -> Component:
    return html.Div(view.say(text), className="station-now")
