"""Raw channels of a run between two times, reduced so that minima and maxima are kept."""

from functools import lru_cache
from typing import Any

import dash_mantine_components as dmc
from dash import Dash, Input, Output, State, dcc, no_update
from dash.development.base_component import Component

from flows.pages.parts import GRAPH, Page, figure, said, say
from flows.pages.run_data import SignalsQuestion, SignalsShown
from schemas.base import Unusable
from schemas.recording import Recording, Stream
from storage.catalogue import runs
from storage.catalogue.runs import Run, find
from storage.home import Home
from tasks.rendering.chart import envelope
from tasks.words import message

HEIGHT_PX = 420
KEPT = 2  # recordings that stay in memory, for the next look at the same run
UNITS = {"gyro": "rad/s", "accel": "m/s²", "angle": "rad", "temperature": "°C", "humidity": "%RH",
         "supply": "V", "mag": "µT"}  # fmt: skip
LOW, HIGH = "#1c7ed6", "#4dabf7"


def data(question: SignalsQuestion, home: Home) -> SignalsShown:
    """A channel between two times. Raises Unusable for a stream or channel the run lacks."""
    run = find(question.run, home)
    streams = _recording(run, home).streams()
    channels = {name: tuple(stream.columns) for name, stream in streams.items()}
    stream = _stream(streams, question)
    since = float(stream.t[0]) if question.since is None else question.since
    until = float(stream.t[-1]) if question.until is None else question.until
    rows = stream.rows(since, until)
    if question.until is None:
        rows = slice(rows.start, len(stream.t))
    shown = envelope(stream.t[rows], stream.columns[question.channel][rows], question.bins)
    return SignalsShown(
        run=run.id, stream=question.stream, channel=question.channel,
        unit=UNITS.get(question.channel.split("_")[0], ""), since=since, until=until,
        rows=rows.stop - rows.start, is_reduced=shown.is_reduced, t=tuple(shown.t.tolist()),
        low=_numbers(shown.low), high=_numbers(shown.high), channels=channels,
    )  # fmt: skip


def _stream(streams: dict[str, Stream], question: SignalsQuestion) -> Stream:
    stream = streams.get(question.stream)
    if stream is None or question.channel not in stream.columns:
        known = ", ".join(f"{name} {each}" for name, s in streams.items() for each in s.columns)
        raise Unusable(
            f"the run has no channel {question.channel} in a stream {question.stream}; there are "
            f"{known}",
            message("cause-none.choice", name=question.channel, known=known),
        )
    return stream


def _numbers(values: Any) -> tuple[float | None, ...]:
    return tuple(None if value != value else value for value in values.tolist())


@lru_cache(maxsize=KEPT)
def _recording(run: Run, home: Home) -> Recording:
    """Raw recordings never change, so a cached one equals the file."""
    return runs.load(run, home)


def section(run: str, question: SignalsQuestion | None = None) -> Component:
    """The graph of a run's signals with the choice of a channel; it loads by itself."""
    asked = question or SignalsQuestion(run=run)
    return dmc.Stack(
        [
            dcc.Store(id="signals-run", data=run),
            dmc.Select(
                id="signals-channel",
                label=said("pages-signals-channel"),
                value=f"{asked.stream} {asked.channel}",
                data=[f"{asked.stream} {asked.channel}"],
                searchable=True,
                maw=320,
            ),
            dmc.Text(id="signals-rows", size="sm", c="dimmed"),
            dcc.Graph(id="signals", figure=figure([], HEIGHT_PX), config=GRAPH),
        ]
    )


def layout(shown: SignalsShown, question: SignalsQuestion) -> Component:
    """The graph alone."""
    return section(shown.run, question)


def callbacks(app: Dash, home: Home) -> None:
    """The graph is made again of the rows that are looked at."""

    @app.callback(
        Output("signals", "figure"),
        Output("signals-channel", "data"),
        Output("signals-rows", "children"),
        Input("signals", "relayoutData"),
        Input("signals-channel", "value"),
        State("signals-run", "data"),
        State("signals-rows", "children"),
    )
    def look(zoom: dict[str, Any] | None, chosen: str | None, run: str, rows: str | None) -> Any:
        zoom = zoom or {}
        if rows and zoom and set(zoom) <= {"autosize"}:  # before them it may be the only call
            return no_update, no_update, no_update
        stream, _, channel = (chosen or "imu gyro_x").partition(" ")
        shown = data(
            SignalsQuestion(
                run=run, stream=stream, channel=channel, since=zoom.get("xaxis.range[0]"),
                until=zoom.get("xaxis.range[1]"),
            ),
            home,
        )  # fmt: skip
        listed = [f"{name} {each}" for name, every in shown.channels.items() for each in every]
        words = "reduced" if shown.is_reduced else "whole"
        count = message(f"pages-signals-rows.{words}", rows=shown.rows, points=len(shown.t))
        return _figure(shown), listed, say(count)


def _figure(shown: SignalsShown) -> dict[str, Any]:
    line = {"type": "scattergl" if not shown.is_reduced else "scatter", "mode": "lines"}
    low = line | {"x": shown.t, "y": shown.low, "line": {"width": 1, "color": LOW}, "name": "min"}
    high = line | {"x": shown.t, "y": shown.high, "line": {"width": 1, "color": LOW}, "name": "max"}
    traces = [low, high | {"fill": "tonexty", "fillcolor": HIGH}] if shown.is_reduced else [low]
    time = said("pages-signals-time")
    return figure(
        traces, HEIGHT_PX, margin={"t": 20, "r": 20},
        xaxis={"title": {"text": time}, "range": [shown.since, shown.until]},
        yaxis={"title": {"text": f"{shown.channel} ({shown.unit})"}},
    )  # fmt: skip


PAGE = Page(
    "signals", SignalsQuestion, SignalsShown, data, layout, in_navigation=False, callbacks=callbacks
)
