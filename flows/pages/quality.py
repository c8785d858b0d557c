"""The Quality page: yield, failures, capability, control charts and stations of selected runs."""

from collections.abc import Callable, Sequence
from datetime import timedelta
from typing import Any

import dash_mantine_components as dmc
from dash.development.base_component import Component

from flows.pages.parts import (
    BLUE,
    GREY,
    ORANGE,
    RED,
    Figure,
    Page,
    StepState,
    badge,
    csv_link,
    facts,
    figure,
    heading,
    note,
    picture,
    said,
    say,
    stated,
    table,
)
from flows.pages.quality_data import (
    NUMBERS,
    CapabilityShown,
    ChartShown,
    Failing,
    GoldenPoint,
    GoldenShown,
    Plot,
    QualityQuestion,
    QualityShown,
    StationShown,
    Yield,
    callbacks,
    choices,
    data,
)
from tasks.quality import FEWEST, FEWEST_IN_INDEX, FEWEST_IN_POINT, HISTORY, RULES, CapabilityIndex
from tasks.words.numbers import MINUS, USUAL_K, Scale, plain, quantities, unit_text

# The charts of the Quality page, as plotly figures.

CAUSES = {"adjusted": "#ae3ec9", "station": "#0ca678", "equipment": ORANGE}
BARS = 20  # of the Pareto chart; the table beside it has all
MARGIN = timedelta(days=15)  # beside the first and the last day
LEGEND = {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0}
MANY = 300  # points, above which a connecting line no longer shows their order


def periods_figure(shown: QualityShown) -> Figure:
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
    return figure([trace, spans], 280, shapes=total,
                  xaxis={"type": "date", "tickformat": "%Y-%m-%d", "nticks": 8},
                  yaxis={"ticksuffix": " %", "range": [0, 103]})  # fmt: skip


def failing_figure(shown: QualityShown) -> Figure:
    """The most frequent failures as bars, and their cumulative share as a line."""
    first = shown.failing[:BARS]
    names = [failing_name(each) for each in first]
    bars = [
        {
            "type": "bar", "x": names, "y": [getattr(each, kind) for each in first],
            "marker": {"color": color}, "name": said(f"pages-quality-failing.{kind}"),
        }
        for kind, color in (("failed", RED), ("inconclusive", ORANGE))
    ]  # fmt: skip
    line = {
        "type": "scatter", "mode": "lines+markers", "x": names, "yaxis": "y2",
        "y": [100 * each.cumulative for each in first], "line": {"color": GREY},
        "name": said("pages-quality-failing.cumulative"),
        "hovertemplate": "%{x}: %{y:.1f} %<extra></extra>",
    }  # fmt: skip
    return figure(
        [*bars, line], 360, barmode="stack", showlegend=True, legend=LEGEND,
        margin={"t": 20, "r": 60, "l": 60, "b": 90},
        xaxis={"type": "category", "tickangle": -40},
        yaxis={"rangemode": "tozero", "tickformat": "d"},
        yaxis2={"overlaying": "y", "side": "right", "range": [0, 103], "ticksuffix": " %",
                "tickmode": "linear", "tick0": 0, "dtick": 20, "showgrid": False},
    )  # fmt: skip


def failing_name(failing: Failing) -> str:
    """An element by its symbol, which is short; else by what it is."""
    return failing.symbol or say(failing.title)


def golden_figure(of: GoldenShown, shown: QualityShown) -> Figure:
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
        [_golden_points(of.points, BLUE, 5), wrong], 240,
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


def chart_figure(chart: ChartShown, shown: QualityShown) -> Figure:
    """Individual values above, moving ranges below; what breaks a rule is red."""
    points = chart.points
    broken = [point for point in points if point.broken]
    values = _points(points, [p.value for p in points], BLUE, 4) | {
        "mode": "lines+markers" if len(points) < MANY else "markers",
        "line": {"width": 0.5, "color": GREY},
        "name": said(f"pages-quality-plot.{chart.plotted}"),
    }
    wrong = _points(broken, [p.value for p in broken], RED, 7) | {
        "text": [", ".join(map(str, p.broken)) for p in broken],
        "name": said("pages-quality-broken"),
        "hovertemplate": "%{x}: %{y:.6g}<br>%{meta}: %{text}<extra></extra>",
        "meta": said("pages-quality-nelson.rule"),
    }
    moving = [point for point in points if point.range is not None]
    ranges = _points(moving, [p.range for p in moving], BLUE, 3) | {
        "yaxis": "y2", "name": said("pages-quality-range"), "showlegend": False,
    }  # fmt: skip
    levels = [_level(chart.centre, GREY), _level(chart.lower, RED), _level(chart.upper, RED)]
    levels += [_level(chart.mean_range, GREY, "y2"), _level(chart.range_limit, RED, "y2")]
    return figure(
        [values, wrong, ranges, *_causes(chart)], 520, shapes=levels,
        xaxis={"anchor": "y2", "tickformat": "%Y-%m-%d", "nticks": 8},
        yaxis={"domain": [0.36, 1], "exponentformat": "power",
            "title": {"text": f"{shown.symbol}{_unit(shown)}"}},
        yaxis2={"domain": [0, 0.28], "title": {"text": said("pages-quality-range")},
                "rangemode": "tozero", "exponentformat": "power"},
        showlegend=True,
        legend=LEGEND,
    )  # fmt: skip


def stations_figure(stations: Sequence[StationShown], shown: QualityShown) -> Figure:
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
    return figure([trace], 320, shapes=[_level(0.0, GREY)], xaxis={"type": "category"},
                   yaxis={"exponentformat": "power",
            "title": {"text": f"{shown.symbol}{_unit(shown)}"}})  # fmt: skip


def _points(points: Sequence[Plot], y: Sequence[float | None], color: str, size: int) -> Figure:
    return {
        "type": "scatter", "mode": "markers", "x": [str(p.day) for p in points], "y": list(y),
        "marker": {"color": color, "size": size}, "customdata": [p.run for p in points],
        "text": [f"{p.serial}, {p.station}" for p in points],
        "hovertemplate": "%{x}: %{y:.6g}<br>%{text}<extra></extra>",
    }  # fmt: skip


def _causes(chart: ChartShown) -> list[Figure]:
    """A mark above the values for each thing that may have caused a change."""
    return [
        {
            "type": "scatter", "mode": "markers", "x": [str(each.day) for each in of],
            "y": [chart.upper] * len(of), "text": [each.name for each in of],
            "marker": {"symbol": "triangle-down", "size": 10, "color": color},
            "name": said(f"pages-quality-cause.{cause}"),
            "hovertemplate": "%{x}: %{text}",
        }
        for cause, color in CAUSES.items()
        if (of := [each for each in chart.events if each.cause == cause])
    ]  # fmt: skip


def _level(y: float, color: str, axis: str = "y") -> Figure:
    return {
        "type": "line", "xref": "paper", "x0": 0, "x1": 1, "yref": axis, "y0": y, "y1": y,
        "line": {"color": color, "width": 1, "dash": "dot"},
    }  # fmt: skip


# The layout of the Quality page.

WithCsv = Callable[[str, Component], Component]  # a part by its name, with the link to its CSV


def layout(shown: QualityShown, question: QualityQuestion) -> Component:
    """What is asked for, then yield, capability, chart and stations of it."""
    if shown.model is None:
        return dmc.Text(said("pages-quality-no-run"))
    chosen = {name: getattr(shown, name) for name in ("model", "item", "element")}
    same = question.model_copy(update=chosen)  # the choices that were made for who asked

    def with_csv(part: str, place: Component) -> Component:
        return dmc.Box([csv_link("quality", part, same), place], className="with-csv")

    of = f": {say(shown.title)} {shown.symbol}" if shown.title else ""
    parts = [
        choices(shown, question),
        heading("pages-quality-yield"),
        _counts(shown),
        _yields(shown, with_csv),
    ]
    if shown.failing:
        parts += [heading("pages-quality-failing"), _failing(shown, with_csv)]
    if shown.capability is not None:
        found = _capability(shown.capability, shown)
        parts += [heading("pages-quality-capability", of), with_csv("capability", found)]
    if shown.chart is not None:
        parts += [
            heading("pages-quality-chart", of),
            *_chart(shown.chart, shown, with_csv),
        ]
    if shown.golden:
        parts += [heading("pages-quality-golden", of), _golden(shown, with_csv)]
    if shown.stations:
        compared = _stations(shown.stations, shown)
        parts += [heading("pages-quality-stations", of), with_csv("stations", compared)]
    return dmc.Stack(parts, gap="sm")


def _counts(shown: QualityShown) -> Component:
    counted = said("pages-quality-counted", **shown.counted.model_dump())
    rule = said("pages-quality-rule", days=shown.retest_days, fewest=FEWEST_IN_POINT)
    return dmc.Box([dmc.Text(counted, size="sm"), note(rule)])


def _yields(shown: QualityShown, with_csv: WithCsv) -> Component:
    titles = {each.item: say(each.title) for each in shown.choices.items}
    in_all = said("pages-quality-total")
    total = [_yield(shown.total, in_all)] if shown.total else []
    by_item = [_yield(each, titles.get(each.name, each.name)) for each in shown.by_item]
    others = [
        with_csv(f"by_{name}", _yield_table(f"by-{name}", [_yield(each) for each in of]))
        for name, of in (("station", shown.by_station), ("model", shown.by_model))
    ]
    first = with_csv("by_item", _yield_table("by-item", [*total, *by_item]))
    tables = [first, dmc.Stack(others)]
    return dmc.Stack([
        with_csv("by_period", picture("quality-periods", periods_figure(shown))),
        dmc.SimpleGrid(tables, cols={"base": 1, "md": 2}, spacing="md"),
    ])  # fmt: skip


def _yield(of: Yield, name: str | None = None) -> tuple[str, ...]:
    interval = f"{100 * of.low:.1f} … {100 * of.high:.1f} %"
    return name or of.name, f"{of.passed} / {of.of}", f"{100 * of.share:.1f} %", interval


def _yield_table(by: str, rows: Sequence[tuple[str, ...]]) -> Component:
    names = f"pages-quality-{by} passed share interval"
    return table("pages-quality-column", names, rows, 320)


def _failing(shown: QualityShown, with_csv: WithCsv) -> Component:
    rows = [
        (f"{say(each.title)} {each.symbol}".strip(), str(each.failed), str(each.inconclusive),
         f"{100 * each.cumulative:.1f} %")
        for each in shown.failing[:BARS]
    ]  # fmt: skip
    names = "limit failed inconclusive cumulative"
    about = said("pages-quality-about.failing", count=len(shown.failing), shown=len(rows))
    parts = [
        picture("quality-failing", failing_figure(shown)),
        table("pages-quality-failing", names, rows, 320),
    ]
    return dmc.Stack(
        [note(about), with_csv("failing", dmc.SimpleGrid(parts, cols={"base": 1, "lg": 2}))]
    )


def _golden(shown: QualityShown, with_csv: WithCsv) -> Component:
    """A chart for each golden unit on each station, and how its last value stands."""
    about = said("pages-quality-about.golden", most=HISTORY, fewest=FEWEST)
    charts = [
        dmc.Box([
            dmc.Group([dmc.Text(f"{of.station} · {of.serial}", fw="bold"),
                       badge(_golden_state(of))]),
            picture(f"quality-golden-{number}", golden_figure(of, shown)),
        ])
        for number, of in enumerate(shown.golden)
    ]  # fmt: skip
    return dmc.Stack([
        note(about),
        with_csv("golden", dmc.SimpleGrid(charts, cols={"base": 1, "sm": 2, "xl": 3})),
    ])  # fmt: skip


def _golden_state(of: GoldenShown) -> StepState:
    """By the last value: a station that was out of control and is no longer may be used."""
    if of.centre is None:
        return stated("pages-quality-golden-state.few", "open", count=len(of.points))
    if of.points[-1].broken:
        rules = tuple(of.points[-1].broken)
        return stated("pages-quality-golden-state.out", "bad", rules=rules)
    return stated("pages-quality-golden-state.within", "good")


def _capability(found: CapabilityShown, shown: QualityShown) -> Component:
    unit = "" if shown.unit == "1" else f" {unit_text(shown.unit)}"
    limits = [None if each is None else plain(each, 5) for each in (found.lower, found.upper)]
    span = " … ".join(each or "–" for each in limits) + unit if any(limits) else None
    indices = {f"pages-quality-index.{name}": _index(getattr(found, name))
               for name in ("cp", "cpk", "pp", "ppk")}  # fmt: skip
    spreads = {"mean": found.mean, "within": found.within, "overall": found.overall}
    shares = {"margin-median": found.margin_median, "margin-95": found.margin_95}
    numbers = {
        "n": str(found.n), "limits": span,
        **{name: None if value is None else plain(value, 4) + unit
           for name, value in spreads.items()},
        **{name: None if share is None else f"{100 * share:.1f} %"
           for name, share in shares.items()},
        "over": str(found.over),
    }  # fmt: skip
    stated = facts({f"pages-quality-fact.{name}": each for name, each in numbers.items()})
    remarks = ["pages-quality-about.capability", "pages-quality-about.margin"]
    if found.lower is None and found.upper is None:
        remarks.append("pages-quality-about.no-limits")
    elif found.lower is None or found.upper is None:
        remarks.append("pages-quality-about.one-sided")
    remarks += ["pages-quality-about.limits-vary"] if found.limits_vary else []
    first = facts(indices)
    if found.n < FEWEST_IN_INDEX:
        few = said("pages-quality-about.few", count=found.n, fewest=FEWEST_IN_INDEX)
        first = dmc.Text(few)
    return dmc.Stack([first, stated, dmc.Box([note(said(each)) for each in remarks])], gap="sm")


def _index(index: CapabilityIndex) -> str | None:
    """“1.33 (1.28 … 1.37)”."""
    if index.value is None or index.low is None or index.high is None:
        return None
    value, low, high = (
        f"{each:.2f}".replace("-", MINUS) for each in (index.value, index.low, index.high)
    )
    return f"{value} ({low} … {high})"


def _chart(chart: ChartShown, shown: QualityShown, with_csv: WithCsv) -> list[Component]:
    counts = [sum(rule in point.broken for point in chart.points) for rule in range(1, RULES + 1)]
    rules = [
        (str(rule), said(f"pages-quality-nelson.rule-{rule}"), str(count))
        for rule, count in enumerate(counts, start=1)
    ]
    about = said(f"pages-quality-about.chart-{chart.plotted}", count=len(chart.points))
    return [
        note(about),
        with_csv("chart", picture("quality-chart", chart_figure(chart, shown))),
        with_csv("rules", table("pages-quality-nelson", "rule pattern count", rules, 320)),
    ]


def _stations(stations: Sequence[StationShown], shown: QualityShown) -> Component:
    if all(each.difference is None for each in stations):
        return dmc.Text(said("pages-quality-about.one-station"))
    names = "station difference u runs state"
    rows = [_station(each, shown) for each in stations]
    figure = stations_figure(stations, shown)
    return dmc.Stack([
        note(said("pages-quality-about.stations")),
        dmc.SimpleGrid(
            [picture("quality-stations", figure),
             table("pages-quality-station", names, rows, 320)],
            cols={"base": 1, "lg": 2},
        ),
    ])  # fmt: skip


def _station(one: StationShown, shown: QualityShown) -> tuple[Any, ...]:
    if one.difference is None or one.U is None:
        state = stated("pages-quality-state.open", "open")
        return one.station, None, None, str(one.runs), badge(state)
    made = quantities([one.difference], one.U, shown.unit, Scale(1.0, 0, shown.unit))
    unit = "" if made.unit == "1" else f" {unit_text(made.unit)}"
    is_off = abs(one.difference) > one.U
    words = f"pages-quality-state.{'off' if is_off else 'within'}"
    state = stated(words, "bad" if is_off else "good")
    cells = (f"{made.values[0]}{unit}", f"{made.uncertainties[0]}{unit} (k = {USUAL_K:g})")
    return one.station, *cells, str(one.runs), badge(state)


PAGE = Page(
    "quality", QualityQuestion, QualityShown, data, layout, callbacks=callbacks, numbers=NUMBERS
)
