"""Charts of a unit's history: one panel per element, with U and limits."""

from collections.abc import Sequence
from typing import Any

from flows.pages.page import View
from flows.pages.pictures import BLUE, GREY, ORANGE, RED, Figure, figure
from schemas.pages.unit import AsMeasured, ElementHistory, Reading
from tasks.words import message
from tasks.words.units import unit_text

ACROSS, PANEL_PX, GAP = 3, 230, 0.08
COLORS: dict[AsMeasured, str] = {"found": BLUE, "left": ORANGE, "invalid": GREY}
SYMBOLS: dict[AsMeasured, str] = {"found": "circle", "left": "diamond", "invalid": "x"}


def history_figure(elements: Sequence[ElementHistory], view: View) -> Figure:
    """Values with U over the years, limits dotted; as left and invalid in their own colours."""
    down = -(-len(elements) // ACROSS)
    axes: dict[str, Any] = {}
    traces, shapes = [], []
    shown: set[AsMeasured] = set()
    for number, element in enumerate(elements):
        end = "" if number == 0 else str(number + 1)
        axes |= _axes(number, down, end, element)
        shapes += [_limit(edge, end) for edge in (element.lower, element.upper) if edge is not None]
        for state in COLORS:
            of = [
                each for each in element.readings if each.state == state and each.value is not None
            ]
            if of:
                traces.append(_points(of, state, end, state not in shown, view))
                shown.add(state)
    return figure(
        traces, view, 90 + PANEL_PX * down, shapes=shapes, showlegend=True,
        legend={"orientation": "h", "y": 1.0, "yref": "container", "yanchor": "top", "x": 0},
        annotations=[_title(number, down, each) for number, each in enumerate(elements)],
        margin={"t": 60, "r": 15, "l": 65, "b": 35}, **axes,
    )  # fmt: skip


def _domains(number: int, down: int) -> tuple[list[float], list[float]]:
    """From left to right and from the top down."""
    row, column = divmod(number, ACROSS)
    width = (1.0 - GAP * (ACROSS - 1)) / ACROSS
    gap = 0.22 / down
    height = (1.0 - gap * (down - 1)) / down
    left, top = column * (width + GAP), 1.0 - row * (height + gap)
    return [left, left + width], [max(top - height, 0.0), top]


def _axes(number: int, down: int, end: str, element: ElementHistory) -> dict[str, Any]:
    x, y = _domains(number, down)
    return {
        f"xaxis{end}": {"domain": x, "anchor": f"y{end}", "tickformat": "%Y-%m", "nticks": 4,
                        "type": "date"},
        f"yaxis{end}": {"domain": y, "anchor": f"x{end}", "exponentformat": "power", "nticks": 6},
    }  # fmt: skip


def _title(number: int, down: int, element: ElementHistory) -> dict[str, Any]:
    x, y = _domains(number, down)
    unit = "" if element.unit == "1" else f" ({unit_text(element.unit)})"
    return {
        "text": f"{element.symbol}{unit}", "x": x[0], "y": y[1], "xref": "paper", "yref": "paper",
        "xanchor": "left", "yanchor": "bottom", "showarrow": False,
    }  # fmt: skip


def _points(
    readings: Sequence[Reading], state: AsMeasured, end: str, in_legend: bool, view: View
) -> Figure:
    return {
        "type": "scatter", "mode": "markers", "xaxis": f"x{end}", "yaxis": f"y{end}",
        "x": [str(each.day) for each in readings], "y": [each.value for each in readings],
        "error_y": {"type": "data", "array": [each.U or 0.0 for each in readings], "width": 0,
                    "thickness": 1},
        "marker": {"color": COLORS[state], "symbol": SYMBOLS[state], "size": 5},
        "customdata": [each.run for each in readings],
        "text": [f"{each.run}, {each.station or '–'}" for each in readings],
        "hovertemplate": "%{x}: %{y:.6g}<br>%{text}<extra></extra>",
        "name": view.say(message(f"pages-unit-state.{state}")), "legendgroup": state,
        "showlegend": in_legend,
    }  # fmt: skip


def _limit(edge: float, end: str) -> dict[str, Any]:
    return {
        "type": "line", "xref": f"x{end} domain", "x0": 0, "x1": 1, "yref": f"y{end}", "y0": edge,
        "y1": edge, "line": {"color": RED, "width": 1, "dash": "dot"},
    }  # fmt: skip
