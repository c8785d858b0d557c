"""The layout of the Quality page."""

from collections.abc import Sequence
from typing import Any

import dash_mantine_components as dmc
from dash import ClientsideFunction, Dash, Input, Output, State, dcc
from dash.development.base_component import Component

from flows.pages.page import View
from flows.pages.parts import facts, table
from flows.pages.pictures import picture
from flows.pages.quality.pictures import chart_figure, stations_figure, weeks_figure
from flows.pages.states import StepState, badge
from schemas.pages.quality import (
    CapabilityShown,
    ChartShown,
    IndexShown,
    QualityQuestion,
    QualityShown,
    StationShown,
    Yield,
)
from storage.home import Home
from tasks.quality.charts import RULES
from tasks.specifications.items import symbol
from tasks.words import message
from tasks.words.quantities import plain, quantities, unit_text
from tasks.words.rounding import MINUS, USUAL_K

ASKED = ("model", "item", "element", "station", "serial", "since", "until", "plot")


def layout(shown: QualityShown, view: View, question: QualityQuestion) -> Component:
    """What is asked for, then yield, capability, chart and stations of it."""
    if shown.model is None:
        return dmc.Text(view.say(message("pages-quality-no-run")))
    parts = [
        choices(shown, view, question),
        _heading("yield", view),
        _counts(shown, view),
        _yields(shown, view),
    ]
    if shown.capability is not None:
        parts += [_heading("capability", view, shown), _capability(shown.capability, shown, view)]
    if shown.chart is not None:
        parts += [_heading("chart", view, shown), *_chart(shown.chart, shown, view)]
    if shown.stations:
        parts += [_heading("stations", view, shown), _stations(shown.stations, shown, view)]
    return dmc.Stack(parts, gap="sm")


def _heading(name: str, view: View, shown: QualityShown | None = None) -> Component:
    text = view.say(message(f"pages-quality-{name}"))
    if shown and shown.title:
        text = f"{text}: {view.say(shown.title)} {shown.symbol}"
    return dmc.Title(text, order=3, mt="sm")


def _counts(shown: QualityShown, view: View) -> Component:
    counted = shown.counted
    sentence = message(
        "pages-quality-counted", runs=counted.runs, first=counted.first, retests=counted.retests,
        undecided=counted.undecided, invalid=counted.invalid,
    )  # fmt: skip
    rule = message("pages-quality-rule", days=shown.retest_days)
    return dmc.Box([
        dmc.Text(view.say(sentence), size="sm"),
        dmc.Text(view.say(rule), size="sm", c="dimmed"),
    ])  # fmt: skip


def _yields(shown: QualityShown, view: View) -> Component:
    titles = {each.item: view.say(each.title) for each in shown.choices.items}
    total = [_yield(each, view.say(message("pages-quality-total"))) for each in _of(shown)]
    by_item = [_yield(each, titles.get(each.name, each.name)) for each in shown.by_item]
    others = [
        _yield_table("by-station", [_yield(each) for each in shown.by_station], view),
        _yield_table("by-model", [_yield(each) for each in shown.by_model], view),
    ]
    tables = [_yield_table("by-item", [*total, *by_item], view), dmc.Stack(others)]
    return dmc.Stack([
        picture("quality-weeks", weeks_figure(shown, view)),
        dmc.SimpleGrid(tables, cols={"base": 1, "md": 2}, spacing="md"),
    ])  # fmt: skip


def _of(shown: QualityShown) -> list[Yield]:
    return [shown.total] if shown.total else []


def _yield(of: Yield, name: str | None = None) -> tuple[str, ...]:
    interval = f"{100 * of.low:.1f} … {100 * of.high:.1f} %"
    return name or of.name, f"{of.passed} / {of.of}", f"{100 * of.share:.1f} %", interval


def _yield_table(by: str, rows: Sequence[tuple[str, ...]], view: View) -> Component:
    names = ("passed", "share", "interval")
    headings = [message(f"pages-quality-{by}")]
    headings += [message(f"pages-quality-column.{name}") for name in names]
    return table(headings, rows, view, min_width=320)


def _capability(found: CapabilityShown, shown: QualityShown, view: View) -> Component:
    unit = "" if shown.unit == "1" else f" {unit_text(shown.unit)}"
    limits = [None if each is None else plain(each, 5) for each in (found.lower, found.upper)]
    span = " … ".join(each or "–" for each in limits) + unit if any(limits) else None
    indices = [(message(f"pages-quality-index.{name}"), _index(getattr(found, name)))
               for name in ("cp", "cpk", "pp", "ppk")]  # fmt: skip
    spreads = {"mean": found.mean, "within": found.within, "overall": found.overall}
    shares = {"margin-median": found.margin_median, "margin-95": found.margin_95}
    numbers = [
        (message("pages-quality-fact.n"), str(found.n)),
        (message("pages-quality-fact.limits"), span),
        *(
            (
                message(f"pages-quality-fact.{name}"),
                value if value is None else plain(value, 4) + unit,
            )
            for name, value in spreads.items()
        ),
        *(
            (
                message(f"pages-quality-fact.{name}"),
                None if share is None else f"{100 * share:.1f} %",
            )
            for name, share in shares.items()
        ),
        (message("pages-quality-fact.over"), str(found.over)),
    ]
    remarks = ["pages-quality-about.capability", "pages-quality-about.margin"]
    if found.lower is None and found.upper is None:
        remarks.append("pages-quality-about.no-limits")
    elif found.lower is None or found.upper is None:
        remarks.append("pages-quality-about.one-sided")
    remarks += ["pages-quality-about.limits-vary"] if found.limits_vary else []
    texts = [dmc.Text(view.say(message(each)), size="sm", c="dimmed") for each in remarks]
    return dmc.Stack([facts(indices, view), facts(numbers, view), dmc.Box(texts)], gap="sm")


def _index(index: IndexShown) -> str | None:
    """“1.33 (1.28 … 1.37)”."""
    if index.value is None or index.low is None or index.high is None:
        return None
    value, low, high = (
        f"{each:.2f}".replace("-", MINUS) for each in (index.value, index.low, index.high)
    )
    return f"{value} ({low} … {high})"


def _chart(chart: ChartShown, shown: QualityShown, view: View) -> list[Component]:
    counts = [sum(rule in point.broken for point in chart.points) for rule in range(1, RULES + 1)]
    rules = [
        (str(rule), view.say(message(f"pages-quality-nelson.rule-{rule}")), str(count))
        for rule, count in enumerate(counts, start=1)
    ]
    headings = [message(f"pages-quality-nelson.{name}") for name in ("rule", "pattern", "count")]
    about = message(f"pages-quality-about.chart-{chart.plotted}", count=len(chart.points))
    return [
        dmc.Text(view.say(about), size="sm", c="dimmed"),
        picture("quality-chart", chart_figure(chart, shown, view)),
        table(headings, rules, view, min_width=320),
    ]


def _stations(stations: Sequence[StationShown], shown: QualityShown, view: View) -> Component:
    names = ("station", "difference", "u", "runs", "state")
    headings = [message(f"pages-quality-station.{name}") for name in names]
    rows = [_station(each, shown, view) for each in stations]
    figure = stations_figure(stations, shown, view)
    return dmc.Stack([
        dmc.Text(view.say(message("pages-quality-about.stations")), size="sm", c="dimmed"),
        dmc.SimpleGrid(
            [picture("quality-stations", figure),
             table(headings, rows, view, min_width=320)],
            cols={"base": 1, "lg": 2},
        ),
    ])  # fmt: skip


def _station(one: StationShown, shown: QualityShown, view: View) -> tuple[Any, ...]:
    if one.difference is None or one.U is None:
        state = StepState(message("pages-quality-state.open"), "open")
        return one.station, None, None, str(one.runs), badge(state, view)
    made = quantities([one.difference], one.U, shown.unit)
    unit = "" if made.unit == "1" else f" {unit_text(made.unit)}"
    is_off = abs(one.difference) > one.U
    state = StepState(message(f"pages-quality-state.{'off' if is_off else 'within'}"),
                      "bad" if is_off else "good")  # fmt: skip
    cells = (f"{made.values[0]}{unit}", f"{made.uncertainties[0]}{unit} (k = {USUAL_K:g})")
    return one.station, *cells, str(one.runs), badge(state, view)


def choices(shown: QualityShown, view: View, question: QualityQuestion) -> Component:
    """The question as it was answered, in controls that ask another one."""
    asked = question.model_dump(mode="json") | {
        "model": shown.model, "item": shown.item, "element": shown.element
    }  # fmt: skip
    known = shown.choices
    item = next((each for each in known.items if each.item == shown.item), None)
    of_items = [{"value": i.item, "label": view.say(i.title)} for i in known.items]
    of_elements = (
        [{"value": e, "label": symbol(item.item, e)} for e in item.elements] if item else []
    )
    plots = [
        {"value": each, "label": view.say(message(f"pages-quality-plot.{each}"))}
        for each in ("value", "change")
    ]

    def select(name: str, values: Sequence[Any], *, needed: bool = False) -> Component:
        return dmc.Select(
            id=f"quality-{name}", label=view.say(message(f"pages-quality-asked.{name}")),
            data=list(values), value=asked[name], searchable=True, clearable=not needed,
            placeholder="" if needed else view.say(message("pages-quality-all")),
            allowDeselect=False,
        )  # fmt: skip

    def day(name: str) -> Component:
        return dmc.DateInput(
            id=f"quality-{name}", label=view.say(message(f"pages-quality-asked.{name}")),
            value=asked[name], valueFormat="YYYY-MM-DD", clearable=True, placeholder="YYYY-MM-DD",
        )  # fmt: skip

    controls = [
        select("model", known.models, needed=True), select("item", of_items, needed=True),
        select("element", of_elements, needed=True), select("station", known.stations),
        select("serial", known.serials), day("since"), day("until"),
        select("plot", plots, needed=True),
    ]  # fmt: skip
    grid = dmc.SimpleGrid(controls, cols={"base": 2, "sm": 4}, spacing="xs")
    kept = dcc.Store(id="quality-asked", data=asked)
    return dmc.DatesProvider([grid, kept], settings={"locale": view.language, "firstDayOfWeek": 1})


def callbacks(app: Dash, _: Home) -> None:
    """Another choice is another address; a point of the chart is its run."""
    app.clientside_callback(
        ClientsideFunction("quality", "ask"),
        Output("address", "search"),
        *(Input(f"quality-{name}", "value") for name in ASKED),
        State("quality-asked", "data"),
        prevent_initial_call=True,
    )
    app.clientside_callback(
        ClientsideFunction("quality", "open"),
        Output("address", "href"),
        Input("quality-chart", "clickData"),
        prevent_initial_call=True,
    )
