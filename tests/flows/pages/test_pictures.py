"""The pictures of the pages: plotly takes them, and they hold every number of their page."""

from typing import Any

import plotly.graph_objects as go
import pytest

from flows.pages import due, quality, run, unit
from flows.pages.parts import Page, Theme, View, seen_by
from storage.home import Home
from tests.flows.pages.laid_out import components
from tests.proof.line import Line, recorded_runs

Figures = dict[str, go.Figure]


@pytest.fixture(scope="module")
def home(line_store: tuple[Home, Line]) -> Home:
    return line_store[0]


def drawn(page: Page, home: Home, theme: Theme = "light", **asked: object) -> tuple[Any, Figures]:
    """What a page shows, and its pictures; plotly refuses a property that it does not know."""
    question = page.question.model_validate(asked)
    shown = page.data(question, home)
    laid_out = list(components(seen_by(View(theme=theme), page.layout, shown, question)))
    ids = [part.id for part in laid_out if hasattr(part, "id")]
    kept = [part for part in laid_out if _kind(part) == "picture-kept"]
    assert all({"type": "picture", "name": part.id["name"]} in ids for part in kept)
    return shown, {part.id["name"]: go.Figure(part.data["props"]["figure"]) for part in kept}


def _kind(part: Any) -> str | None:
    id_ = getattr(part, "id", None)
    return id_["type"] if isinstance(id_, dict) and "type" in id_ else None


def _points(figure: go.Figure) -> int:
    return sum(len(trace.x) for trace in figure.data)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_quality_draws_every_period_failure_value_and_station(home: Home, theme: Theme) -> None:
    shown, figures = drawn(quality.PAGE, home, theme)
    assert set(figures) == {
        "quality-periods", "quality-failing", "quality-chart", "quality-stations",
    }  # fmt: skip
    values = [each for trace in figures["quality-chart"].data for each in trace.y]
    assert {point.value for point in shown.chart.points} <= set(values)
    assert len(figures["quality-periods"].data[0].x) == len(shown.by_period)
    failed, inconclusive, cumulative = figures["quality-failing"].data
    drawn_limits = [sum(both) for both in zip(failed.y, inconclusive.y, strict=True)]
    assert drawn_limits == [each.failed + each.inconclusive for each in shown.failing]
    assert cumulative.y[-1] == pytest.approx(100.0)
    known = {each.station for each in shown.stations if each.difference is not None}
    assert known <= {name for trace in figures["quality-stations"].data for name in trace.x}


def test_a_unit_draws_every_value_of_the_item_that_is_asked_for(home: Home) -> None:
    (line, *_) = drawn(unit.PAGE, home)[0].units
    shown, figures = drawn(unit.PAGE, home, id=line.id, item="gyro_bias")
    readings = [
        reading.value
        for element in shown.elements
        if element.item == "gyro_bias"
        for reading in element.readings
        if reading.value is not None
    ]
    (history,) = figures.values()
    assert sorted(y for trace in history.data for y in trace.y) == pytest.approx(sorted(readings))
    assert all(trace.error_y.array is not None for trace in history.data)


def test_what_falls_due_is_a_bar_for_each_month(home: Home) -> None:
    shown, (months,) = drawn(due.PAGE, home)[0], drawn(due.PAGE, home)[1].values()
    assert list(months.data[0].x) == [each.month for each in shown.months]
    assert list(months.data[0].y) == [each.units for each in shown.months]


@pytest.mark.parametrize(("bins", "lines"), [(1000, 2), (10_000, 1)])
def test_signals_are_a_band_of_bins_or_the_line_of_every_row(
    home: Home, bins: int, lines: int
) -> None:
    question = run.SIGNALS_PAGE.question.model_validate(
        {"run": next(iter(recorded_runs(home))), "bins": bins}
    )
    shown = run.signal_data(question, home)
    figure = go.Figure(seen_by(View(), run._signal_figure, shown))
    assert len(figure.data) == lines
    assert _points(figure) == lines * len(shown.t) > 0
