"""The charts of the Quality page, as plotly figures."""

from collections.abc import Sequence
from datetime import timedelta

from flows.pages.page import View
from flows.pages.pictures import BLUE, GREY, ORANGE, RED, Figure, figure
from flows.pages.quality.models import (
    ChartShown,
    Failing,
    GoldenPoint,
    GoldenShown,
    Plot,
    QualityShown,
    StationShown,
)
from tasks.words.quantities import unit_text

CAUSES = {"adjusted": "#ae3ec9", "station": "#0ca678", "equipment": ORANGE}
BARS = 20  # of the Pareto chart; the table beside it has all
MARGIN = timedelta(days=15)  # beside the first and the last day
LEGEND = {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0}
MANY = 300  # points, above which a connecting line no longer shows their order


def periods_figure(shown: QualityShown, view: View) -> Figure:
    """The yield of each period with its interval; a bar across it shows how long it is."""
    periods = shown.by_period
    middle = [each.since + (each.until - each.since) / 2 for each in periods]
    trace = {
        "type": "scatter", "mode": "markers", "x": [str(day) for day in middle],
        "y": [100 * each.share for each in periods], "marker": {"color": BLUE, "size": 8},
        "error_y": {
            "type": "data", "symmetric": False, "thickness": 1.5, "width": 5, "color": GREY,
            "array": [100 * (each.high - each.share) for each in periods],
            "arrayminus": [100 * (each.share - each.low) for each in periods],
        },
        "text": [f"{each.name}: {each.passed} / {each.of}" for each in periods],
        "customdata": [[100 * each.low, 100 * each.high] for each in periods],
        "hovertemplate": "%{text}, %{y:.1f} % (%{customdata[0]:.1f} … %{customdata[1]:.1f} %)"
        "<extra></extra>",
    }  # fmt: skip
    spans = {
        "type": "scatter", "mode": "lines", "line": {"color": BLUE, "width": 3},
        "x": [day for p in periods for day in (str(p.since), str(p.until), None)],
        "y": [y for p in periods for y in (100 * p.share, 100 * p.share, None)],
        "hoverinfo": "skip",
    }  # fmt: skip
    total = [_level(100 * shown.total.share, BLUE)] if shown.total else []
    return figure([trace, spans], view, 280, shapes=total,
                  xaxis={"type": "date", "tickformat": "%Y-%m-%d", "nticks": 8},
                  yaxis={"ticksuffix": " %", "range": [0, 103]})  # fmt: skip


def failing_figure(shown: QualityShown, view: View) -> Figure:
    """The most frequent failures as bars, and their cumulative share as a line."""
    first = shown.failing[:BARS]
    names = [failing_name(each, view) for each in first]
    bars = [
        {
            "type": "bar", "x": names, "y": [getattr(each, kind) for each in first],
            "marker": {"color": color}, "name": view.text(f"pages-quality-failing.{kind}"),
        }
        for kind, color in (("failed", RED), ("inconclusive", ORANGE))
    ]  # fmt: skip
    line = {
        "type": "scatter", "mode": "lines+markers", "x": names, "yaxis": "y2",
        "y": [100 * each.cumulative for each in first], "line": {"color": GREY},
        "name": view.text("pages-quality-failing.cumulative"),
        "hovertemplate": "%{x}: %{y:.1f} %<extra></extra>",
    }  # fmt: skip
    return figure(
        [*bars, line], view, 360, barmode="stack", showlegend=True, legend=LEGEND,
        margin={"t": 20, "r": 60, "l": 60, "b": 90},
        xaxis={"type": "category", "tickangle": -40},
        yaxis={"rangemode": "tozero", "tickformat": "d"},
        yaxis2={"overlaying": "y", "side": "right", "range": [0, 103], "ticksuffix": " %",
                "tickmode": "linear", "tick0": 0, "dtick": 20, "showgrid": False},
    )  # fmt: skip


def failing_name(failing: Failing, view: View) -> str:
    """An element by its symbol, which is short; else by what it is."""
    return failing.symbol or view.say(failing.title)


def golden_figure(of: GoldenShown, shown: QualityShown, view: View) -> Figure:
    """The values of a golden unit on a station, between the limits of their own history; in the
    same ranges as on the other stations.
    """
    broken = [point for point in of.points if point.broken]
    wrong = _golden_points(broken, RED, 8)
    levels = [(of.centre, GREY), (of.lower, RED), (of.upper, RED)]
    every = [each for each in shown.golden if each.serial == of.serial]
    values = [p.value for each in every for p in each.points]
    values += [y for each in every for y in (each.lower, each.upper) if y is not None]
    room = 0.1 * (max(values) - min(values))
    days = sorted(p.day for each in every for p in each.points)
    return figure(
        [_golden_points(of.points, BLUE, 5), wrong], view, 240,
        shapes=[_level(y, color) for y, color in levels if y is not None],
        xaxis={"tickformat": "%Y-%m-%d", "nticks": 5,
               "range": [str(days[0] - MARGIN), str(days[-1] + MARGIN)]},
        yaxis={"exponentformat": "power", "range": [min(values) - room, max(values) + room],
               "title": {"text": f"{shown.symbol}{_unit(shown)}"}},
    )  # fmt: skip


def _golden_points(points: Sequence[GoldenPoint], color: str, size: int) -> Figure:
    return {
        "type": "scatter", "mode": "markers", "x": [str(p.day) for p in points],
        "y": [p.value for p in points], "marker": {"color": color, "size": size},
        "text": [", ".join(map(str, p.broken)) for p in points],
        "hovertemplate": "%{x}: %{y:.6g} %{text}<extra></extra>",
    }  # fmt: skip


def _unit(shown: QualityShown) -> str:
    return "" if shown.unit == "1" else f" ({unit_text(shown.unit)})"


def chart_figure(chart: ChartShown, shown: QualityShown, view: View) -> Figure:
    """Individual values above, moving ranges below; what breaks a rule is red."""
    points = chart.points
    broken = [point for point in points if point.broken]
    values = _points(points, [p.value for p in points], BLUE, 4) | {
        "mode": "lines+markers" if len(points) < MANY else "markers",
        "line": {"width": 0.5, "color": GREY},
        "name": view.text(f"pages-quality-plot.{chart.plotted}"),
    }  # fmt: skip
    wrong = _points(broken, [p.value for p in broken], RED, 7) | {
        "text": [", ".join(map(str, p.broken)) for p in broken],
        "name": view.text("pages-quality-broken"),
        "hovertemplate": "%{x}: %{y:.6g}<br>%{meta}: %{text}<extra></extra>",
        "meta": view.text("pages-quality-nelson.rule"),
    }  # fmt: skip
    moving = [point for point in points if point.range is not None]
    ranges = _points(moving, [p.range for p in moving], BLUE, 3) | {
        "yaxis": "y2", "name": view.text("pages-quality-range"), "showlegend": False,
    }  # fmt: skip
    levels = [_level(chart.centre, GREY), _level(chart.lower, RED), _level(chart.upper, RED)]
    levels += [_level(chart.mean_range, GREY, "y2"), _level(chart.range_limit, RED, "y2")]
    return figure(
        [values, wrong, ranges, *_causes(chart, view)], view, 520, shapes=levels,
        xaxis={"anchor": "y2", "tickformat": "%Y-%m-%d", "nticks": 8},
        yaxis={"domain": [0.36, 1], "exponentformat": "power",
            "title": {"text": f"{shown.symbol}{_unit(shown)}"}},
        yaxis2={"domain": [0, 0.28], "title": {"text": view.text("pages-quality-range")},
                "rangemode": "tozero", "exponentformat": "power"},
        showlegend=True,
        legend=LEGEND,
    )  # fmt: skip


def stations_figure(stations: Sequence[StationShown], shown: QualityShown, view: View) -> Figure:
    """The difference of each station with U; one beyond its U is red."""
    known = [each for each in stations if each.difference is not None]
    colors = [RED if each.U is not None and abs(each.difference or 0.0) > each.U else BLUE
              for each in known]  # fmt: skip
    trace = {
        "type": "scatter", "mode": "markers", "x": [each.station for each in known],
        "y": [each.difference for each in known], "marker": {"color": colors, "size": 9},
        "error_y": {"type": "data", "array": [each.U or 0.0 for each in known], "color": GREY},
        "hovertemplate": "%{x}: %{y:.4g}<extra></extra>",
    }  # fmt: skip
    return figure([trace], view, 320, shapes=[_level(0.0, GREY)], xaxis={"type": "category"},
                   yaxis={"exponentformat": "power",
            "title": {"text": f"{shown.symbol}{_unit(shown)}"}})  # fmt: skip


def _points(points: Sequence[Plot], y: Sequence[float | None], color: str, size: int) -> Figure:
    return {
        "type": "scatter", "mode": "markers", "x": [str(p.day) for p in points], "y": list(y),
        "marker": {"color": color, "size": size}, "customdata": [p.run for p in points],
        "text": [f"{p.serial}, {p.station}" for p in points],
        "hovertemplate": "%{x}: %{y:.6g}<br>%{text}<extra></extra>",
    }  # fmt: skip


def _causes(chart: ChartShown, view: View) -> list[Figure]:
    """A mark above the values for each thing that may have caused a change."""
    return [
        {
            "type": "scatter", "mode": "markers", "x": [str(each.day) for each in of],
            "y": [chart.upper] * len(of), "text": [each.name for each in of],
            "marker": {"symbol": "triangle-down", "size": 10, "color": color},
            "name": view.text(f"pages-quality-cause.{cause}"),
            "hovertemplate": "%{x}: %{text}",
        }
        for cause, color in CAUSES.items()
        if (of := [each for each in chart.events if each.cause == cause])
    ]  # fmt: skip


def _level(y: float, color: str, axis: str = "y") -> Figure:
    """A line across the picture."""
    return {
        "type": "line", "xref": "paper", "x0": 0, "x1": 1, "yref": axis, "y0": y, "y1": y,
        "line": {"color": color, "width": 1, "dash": "dot"},
    }  # fmt: skip
