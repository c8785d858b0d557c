"""The Line page: what each station is doing, what is to be seen to, what waits, and the day."""

from collections.abc import Sequence
from datetime import timedelta
from typing import Any

import dash_mantine_components as dmc
from dash import html
from dash.development.base_component import Component

from flows.pages.do import roles_of
from flows.pages.line_data import (
    NO_SERVER,
    AlarmShown,
    Flows,
    LineNow,
    LineQuestion,
    Queued,
    StationNow,
    Waits,
    line_now,
)
from flows.pages.parts import (
    Cell,
    Kind,
    Page,
    StepState,
    asking,
    badge,
    facts,
    heading,
    hour_of,
    notice,
    said,
    say,
    second_of,
    stated,
    table,
    view,
)
from schemas.recording import RunStatus
from tasks.words import Sayable, message

# The Stop button of a station: one press, no question asked.


def stop_button(station: str) -> Component:
    """Stops whatever the station does; for whoever may not, what stops it at the station.

    `stop.js` sees the press.
    """
    if not view().visitor.may("stop"):
        hint = said("pages-line-stop.elsewhere", roles=roles_of("stop"), station=station)
        return html.Div(hint, className="station-details")
    asked: dict[str, Any] = {
        "data-stop": station,
        "data-failed": said("pages-line-stop.failed"),
    }
    word = said("pages-line-stop")
    return html.Button([html.Span(className="stop-sign"), word], className="stop", **asked)


def lockout(now: StationNow) -> list[Component]:
    """Who stopped the station so that its orders wait, and whether its table is at rest; for
    whoever may, the button that lets it turn again, after a question. It stands far from Stop.
    """
    shown = _outcome_of_stop(now)
    if now.lockout is None:
        return [html.Div(shown, className="lockout")] if shown else []
    stopped = {"by": now.lockout.by, "at": second_of(now.lockout.at)}
    shown.append(html.Div(said("pages-line-lockout", **stopped)))
    if view().visitor.may("stop"):
        asked: dict[str, Any] = {
            "data-release": now.station,
            "data-failed": said("pages-line-lockout.failed"),
            **asking(said("pages-line-lockout.ask", station=now.station)),
        }
        word = said("pages-line-lockout.release")
        shown.append(html.Button(word, className="release", **asked))
    return [html.Div(shown, className="lockout station-now")]


def acknowledgement(alarm: AlarmShown) -> Component | None:
    """Who saw to an alarm, else the button that says so, for whoever may."""
    if alarm.acknowledged is not None:
        by = {"by": alarm.acknowledged.by, "at": hour_of(alarm.acknowledged.at)}
        return html.Span(said("pages-line-acknowledged", **by))
    if not view().visitor.may("stop"):
        return None
    asked: dict[str, Any] = {
        "data-acknowledge": alarm.key,
        "data-failed": said("pages-line-acknowledge.failed"),
    }
    word = said("pages-line-acknowledge")
    return html.Button(word, className="acknowledge", **asked)


def _outcome_of_stop(now: StationNow) -> list[Component]:
    """The last stop, for as long as no later run began: a table that may still turn is said so in
    red, and what to do at once.
    """
    stop = now.stopped
    if stop is None or (now.run is not None and now.run.began_at > stop.at):
        return []
    rest = "at-rest" if stop.is_at_rest else "not-at-rest"
    words = said(f"pages-line-stop.{rest}", by=stop.by, at=second_of(stop.at))
    fault = [html.Div(say(stop.cause))] if stop.cause else []
    color = "good" if stop.is_at_rest else "bad"
    return [html.Div(words, className=f"at-rest alarm-{color}"), *fault]


# The card of a station, whose large type is read from three metres.

WAITING_SHOWN = 3
UNITS = {"gyro": "°/s", "accel": "m/s²"}
# What is good, what waits for a person, what went wrong; a free station asks for nothing.
KINDS: dict[str, Kind] = {
    "free": "none", "begun": "good", "warming_up": "good", "measuring": "good", "repeating": "open",
    "paused": "open", "turning_over": "open", "finishing": "good", "done": "none",
    "stopped": "bad", "lost": "bad", "silent": "bad",
}  # fmt: skip
RUNS = ("begun", "warming_up", "measuring", "repeating", "paused", "turning_over", "finishing")


def card(now: StationNow) -> Component:
    """State and station, units, segment and remaining time, alarm, queue, and Stop."""
    word = said(f"pages-line-state.{now.state.replace('_', '-')}")
    head = [
        html.Div(word, className="station-state"),
        html.Div(now.station, className="station-id"),
    ]
    body: list[Component] = []
    if now.run is not None and now.state != "free":
        body += _run(now, now.run)
    else:
        body += _free(now)
    if now.alarm is not None:
        # Red where the station stands for it; else it is one that a run goes on or ended with
        kind = "bad" if KINDS[now.state] == "bad" else "open"
        at = f"{hour_of(now.alarm.at)}  " if now.alarm.at else ""
        body.append(
            html.Div(
                [
                    html.Div(f"{at}{say(now.alarm.cause)}", className="station-cause"),
                    html.Div(f"→ {say(now.alarm.todo)}"),
                ],
                className=f"station-alarm alarm-{kind}",
            )
        )
    body += _queue(now.waiting)
    return html.Section(
        [
            html.Div(head, className=f"station-head station-{KINDS[now.state]}"),
            *lockout(now),
            html.Div(body, className="station-body"),
            html.Div(stop_button(now.station), className="station-foot"),
        ],
        className="station",
    )


def _run(now: StationNow, run: RunStatus) -> list[Component]:
    share = 100 * run.station_s_done / run.station_s_total if run.station_s_total else 0
    parts: list[Component] = [
        html.Div(", ".join(run.units), className="station-units"),
        html.Div(f"{run.procedure} · {run.now}", className="station-now"),
    ]
    large = [_figure(message("pages-line-segment"), f"{run.segment} / {run.segments}")]
    if now.state in RUNS:
        end = hour_of(run.at + timedelta(seconds=run.wall_s_left))
        left = say(_duration(run.wall_s_left))
        large.append(_figure(message("pages-line-left", end=end), left))
    rates = [f"{name} {rate:.1f} Hz" for name, rate in run.rates_hz.items()]
    noise = [f"{name} {value:.2g} {UNITS.get(name, '')}" for name, value in run.noise.items()]
    at = said("pages-line-at", at=second_of(run.at))
    parts += [
        html.Div(large, className="station-figures"),
        dmc.Progress(value=min(share, 100), size="lg"),
        html.Div(" · ".join([at, *rates, *noise]), className="station-details one-line"),
    ]
    return parts


def _free(now: StationNow) -> list[Component]:
    """What is to be mounted next, and what was measured last."""
    ahead = [each for each in now.waiting if each.state == "waiting"]
    parts: list[Component] = []
    if ahead:
        parts.append(html.Div(", ".join(ahead[0].serials), className="station-units"))
        parts.append(_small(message("pages-line-next", procedure=ahead[0].procedure)))
    if now.run is None:
        return [*parts, _small(message("pages-line-never"))]
    units, at = ", ".join(now.run.units), hour_of(now.run.at)
    return [*parts, _small(message("pages-line-last-done", unit=units, at=at))]


def _figure(name: Sayable, value: str) -> Component:
    return html.Div([
        html.Div(value, className="station-figure"),
        html.Div(say(name), className="station-details"),
    ])  # fmt: skip


def _duration(seconds: float) -> Sayable:
    """Minutes, rounded up, at least one."""
    minutes = max(1, -int(-seconds // 60))
    hours, rest = divmod(minutes, 60)
    if hours:
        return message("pages-line-duration.hours", hours=hours, minutes=f"{rest:02d}")
    return message("pages-line-duration.minutes", minutes=rest)


def _queue(waiting: Sequence[Queued]) -> list[Component]:
    """How many orders wait, and the next ones, and what keeps one from beginning; a running one is
    on the card already.
    """
    ahead = [each for each in waiting if each.state == "waiting"]
    if not ahead:
        return []
    named = [f"{', '.join(each.serials)} ({each.procedure})" for each in ahead[:WAITING_SHOWN]]
    parts = [_small(message("pages-line-waiting", count=len(ahead), named=tuple(named)))]
    hindrances = [say(each.hindrance) for each in ahead if each.hindrance]
    return [*parts, *(html.Div(each, className="station-alarm alarm-open") for each in hindrances)]


def _small(text: Sayable) -> Component:
    return html.Div(say(text), className="station-now")


# The layout of the Line page.

WAITS: dict[Waits, Kind] = {"running": "good", "waiting": "open"}
COLUMNS = 3  # of cards on a wide screen; more would be too small to be read from three metres


def layout(line: LineNow, _: LineQuestion) -> Component:
    """A card for each station, then alarms, orders, flow runs and the day."""
    parts = [
        _stations(line),
        heading("pages-line-heading.alarms"),
        _alarms(line.alarms),
    ]
    if line.catalogue is not None:
        parts.insert(0, notice("pages-no-database", "red"))
    if line.today is not None:
        parts += [heading("pages-line-heading.orders"), _orders(line.orders)]
    parts += [heading("pages-line-heading.flows"), _flows(line.flows)]
    if line.today is not None:
        title = said("pages-line-today", day=str(line.today.day))
        stations = ", ".join(f"{name} {count}" for name, count in line.today.by_station.items())
        counts = line.today.model_dump(exclude={"day", "by_station"})
        shown: dict[str, Cell] = {
            f"pages-line-output.{name.replace('_', '-')}": str(count)
            for name, count in counts.items()
        }
        parts += [
            dmc.Title(title, order=3, mt="sm"),
            facts(shown | {"pages-line-output.by-station": stations}),
        ]
    return dmc.Stack(parts, gap="sm")


def _stations(line: LineNow) -> Component:
    if not line.stations:
        return dmc.Text(said("pages-line-no-station"))
    widest = min(COLUMNS, len(line.stations))
    columns = {"base": 1, "sm": min(2, widest), "lg": widest}
    cards = [card(each) for each in line.stations]
    return dmc.SimpleGrid(cards, cols=columns, spacing="md")


def _alarms(alarms: Sequence[AlarmShown]) -> Component:
    rows = [
        (
            hour_of(each.at) if each.at else None,
            each.station or None,
            each.about or None,
            say(each.cause),
            say(each.todo),
            acknowledgement(each),
        )
        for each in alarms
    ]
    names = "at station about cause todo acknowledged"
    return table("pages-line-alarm", names, rows, 760, none="pages-line-none.alarms")


def _orders(orders: Sequence[Queued]) -> Component:
    """The queue of each station, what runs first."""
    rows = [
        (
            each.station,
            ", ".join(each.serials),
            each.procedure,
            badge(stated(f"pages-line-waits.{each.state}", WAITS[each.state])),
            hour_of(each.since),
            each.client or None,
            each.number,
        )
        for each in sorted(orders, key=lambda each: (each.station, each.state))
    ]
    names = "station serial procedure state since client number"
    return table("pages-line-order", names, rows, 760, none="pages-line-none.orders")


def _flows(flows: Flows) -> Component:
    if not flows.server:
        return dmc.Text(said("pages-line-no-server"), size="sm")
    if flows.fault is not None:
        return dmc.Alert(say(NO_SERVER), color="red")
    rows = [
        (
            each.deployment,
            each.subject or None,
            badge(StepState(each.state, "bad" if each.is_late else "none")),
            hour_of(each.expected_at) if each.expected_at else None,
        )
        for each in flows.runs
    ]
    return table(
        "pages-line-flow",
        "deployment subject state expected",
        rows,
        none="pages-line-none.flows",
    )


REFRESH_S = 2.0

PAGE = Page("line", LineQuestion, LineNow, line_now, layout, refresh_s=REFRESH_S)
