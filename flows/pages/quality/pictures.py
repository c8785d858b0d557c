"""The charts of the Quality page, as plotly figures."""

from collections.abc import Sequence

from flows.pages.page import View
from flows.pages.pictures import BLUE, GREY, ORANGE, RED, Figure, figure
from schemas.pages.quality import ChartShown, Plot, QualityShown, StationShown
from tasks.words import message
from tasks.words.quantities import unit_text

CAUSES = {"adjusted": "#ae3ec9", "station": "#0ca678", "equipment": ORANGE}
MANY = 300  # points, whose order no line between them shows any more


def weeks_figure(shown: QualityShown, view: View) -> Figure:
    """The yield of each week with its interval."""
    weeks = shown.by_week
    trace = {
        "type": "scatter", "mode": "markers", "x": [each.name for each in weeks],
        "y": [100 * each.share for each in weeks], "marker": {"color": BLUE, "size": 5},
        "error_y": {
            "type": "data", "symmetric": False, "thickness": 1, "width": 0, "color": GREY,
            "array": [100 * (each.high - each.share) for each in weeks],
            "arrayminus": [100 * (each.share - each.low) for each in weeks],
        },
        "customdata": [f"{each.passed} / {each.of}" for each in weeks],
        "hovertemplate": "%{x}: %{customdata}, %{y:.1f} %<extra></extra>",
    }  # fmt: skip
    total = [_level(100 * shown.total.share, BLUE)] if shown.total else []
    axis = {"title": {"text": view.say(message("pages-quality-by-week"))}, "type": "category",
            "nticks": 12}  # fmt: skip
    return figure([trace], view, 280, xaxis=axis, shapes=total,
                   yaxis={"ticksuffix": " %", "range": [0, 103]})  # fmt: skip


def chart_figure(chart: ChartShown, shown: QualityShown, view: View) -> Figure:
    """Individual values above, moving ranges below; what breaks a rule is red."""
    points = chart.points
    broken = [point for point in points if point.broken]
    values = _points(points, [p.value for p in points], BLUE, 4) | {
        "mode": "lines+markers" if len(points) < MANY else "markers",
        "line": {"width": 0.5, "color": GREY},
        "name": view.say(message(f"pages-quality-plot.{chart.plotted}")),
    }  # fmt: skip
    wrong = _points(broken, [p.value for p in broken], RED, 7) | {
        "text": [", ".join(map(str, p.broken)) for p in broken],
        "name": view.say(message("pages-quality-broken")),
        "hovertemplate": "%{x}: %{y:.6g}<br>%{meta}: %{text}<extra></extra>",
        "meta": view.say(message("pages-quality-nelson.rule")),
    }  # fmt: skip
    moving = [point for point in points if point.range is not None]
    ranges = _points(moving, [p.range for p in moving], BLUE, 3) | {
        "yaxis": "y2", "name": view.say(message("pages-quality-range")), "showlegend": False,
    }  # fmt: skip
    levels = [_level(chart.centre, GREY), _level(chart.lower, RED), _level(chart.upper, RED)]
    levels += [_level(chart.mean_range, GREY, "y2"), _level(chart.range_limit, RED, "y2")]
    unit = "" if shown.unit == "1" else f" ({unit_text(shown.unit)})"
    return figure(
        [values, wrong, ranges, *_causes(chart, view)], view, 520, shapes=levels,
        xaxis={"anchor": "y2", "tickformat": "%Y-%m-%d", "nticks": 8},
        yaxis={"domain": [0.36, 1], "exponentformat": "power",
            "title": {"text": f"{shown.symbol}{unit}"}},
        yaxis2={"domain": [0, 0.28], "title": {"text": view.say(message("pages-quality-range"))},
                "rangemode": "tozero", "exponentformat": "power"},
        showlegend=True,
        legend={"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0},
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
    unit = "" if shown.unit == "1" else f" ({unit_text(shown.unit)})"
    return figure([trace], view, 320, shapes=[_level(0.0, GREY)], xaxis={"type": "category"},
                   yaxis={"exponentformat": "power",
            "title": {"text": f"{shown.symbol}{unit}"}})  # fmt: skip


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
            "name": view.say(message(f"pages-quality-cause.{cause}")),
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
