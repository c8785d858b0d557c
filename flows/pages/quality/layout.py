"""The layout of the Quality page."""

from collections.abc import Callable, Sequence
from typing import Any

import dash_mantine_components as dmc
from dash.development.base_component import Component

from flows.pages.numbers import csv_link
from flows.pages.page import View
from flows.pages.parts import facts, heading, note, table
from flows.pages.pictures import picture
from flows.pages.quality.choices import choices
from flows.pages.quality.models import (
    CapabilityShown,
    ChartShown,
    GoldenShown,
    QualityQuestion,
    QualityShown,
    StationShown,
    Yield,
)
from flows.pages.quality.pictures import (
    BARS,
    chart_figure,
    failing_figure,
    golden_figure,
    periods_figure,
    stations_figure,
)
from flows.pages.states import StepState, badge, stated
from tasks.quality.capability import FEWEST as FEWEST_IN_INDEX
from tasks.quality.capability import CapabilityIndex
from tasks.quality.charts import RULES
from tasks.quality.golden import FEWEST, HISTORY
from tasks.quality.yields import FEWEST_IN_POINT
from tasks.words.quantities import Scale, plain, quantities, unit_text
from tasks.words.rounding import MINUS, USUAL_K

WithCsv = Callable[[str, Component], Component]  # a part by its name, with the link to its CSV


def layout(shown: QualityShown, view: View, question: QualityQuestion) -> Component:
    """What is asked for, then yield, capability, chart and stations of it."""
    if shown.model is None:
        return dmc.Text(view.text("pages-quality-no-run"))
    chosen = {name: getattr(shown, name) for name in ("model", "item", "element")}
    same = question.model_copy(update=chosen)  # the choices that were made for who asked

    def with_csv(part: str, place: Component) -> Component:
        return dmc.Box([csv_link("quality", part, same), place], className="with-csv")

    of = f": {view.say(shown.title)} {shown.symbol}" if shown.title else ""
    parts = [
        choices(shown, view, question),
        heading("pages-quality-yield", view),
        _counts(shown, view),
        _yields(shown, view, with_csv),
    ]
    if shown.failing:
        parts += [heading("pages-quality-failing", view), _failing(shown, view, with_csv)]
    if shown.capability is not None:
        found = _capability(shown.capability, shown, view)
        parts += [heading("pages-quality-capability", view, of), with_csv("capability", found)]
    if shown.chart is not None:
        parts += [
            heading("pages-quality-chart", view, of),
            *_chart(shown.chart, shown, view, with_csv),
        ]
    if shown.golden:
        parts += [heading("pages-quality-golden", view, of), _golden(shown, view, with_csv)]
    if shown.stations:
        compared = _stations(shown.stations, shown, view)
        parts += [heading("pages-quality-stations", view, of), with_csv("stations", compared)]
    return dmc.Stack(parts, gap="sm")


def _counts(shown: QualityShown, view: View) -> Component:
    counted = view.text("pages-quality-counted", **shown.counted.model_dump())
    rule = view.text("pages-quality-rule", days=shown.retest_days, fewest=FEWEST_IN_POINT)
    return dmc.Box([dmc.Text(counted, size="sm"), note(rule)])


def _yields(shown: QualityShown, view: View, with_csv: WithCsv) -> Component:
    titles = {each.item: view.say(each.title) for each in shown.choices.items}
    in_all = view.text("pages-quality-total")
    total = [_yield(shown.total, in_all)] if shown.total else []
    by_item = [_yield(each, titles.get(each.name, each.name)) for each in shown.by_item]
    others = [
        with_csv(f"by_{name}", _yield_table(f"by-{name}", [_yield(each) for each in of], view))
        for name, of in (("station", shown.by_station), ("model", shown.by_model))
    ]
    first = with_csv("by_item", _yield_table("by-item", [*total, *by_item], view))
    tables = [first, dmc.Stack(others)]
    return dmc.Stack([
        with_csv("by_period", picture("quality-periods", periods_figure(shown, view))),
        dmc.SimpleGrid(tables, cols={"base": 1, "md": 2}, spacing="md"),
    ])  # fmt: skip


def _yield(of: Yield, name: str | None = None) -> tuple[str, ...]:
    interval = f"{100 * of.low:.1f} … {100 * of.high:.1f} %"
    return name or of.name, f"{of.passed} / {of.of}", f"{100 * of.share:.1f} %", interval


def _yield_table(by: str, rows: Sequence[tuple[str, ...]], view: View) -> Component:
    names = f"pages-quality-{by} passed share interval"
    return table("pages-quality-column", names, rows, view, 320)


def _failing(shown: QualityShown, view: View, with_csv: WithCsv) -> Component:
    rows = [
        (f"{view.say(each.title)} {each.symbol}".strip(), str(each.failed), str(each.inconclusive),
         f"{100 * each.cumulative:.1f} %")
        for each in shown.failing[:BARS]
    ]  # fmt: skip
    names = "limit failed inconclusive cumulative"
    about = view.text("pages-quality-about.failing", count=len(shown.failing), shown=len(rows))
    parts = [
        picture("quality-failing", failing_figure(shown, view)),
        table("pages-quality-failing", names, rows, view, 320),
    ]
    return dmc.Stack([
        note(about),
        with_csv("failing", dmc.SimpleGrid(parts, cols={"base": 1, "lg": 2})),
    ])  # fmt: skip


def _golden(shown: QualityShown, view: View, with_csv: WithCsv) -> Component:
    """A chart for each golden unit on each station, and how its last value stands."""
    about = view.text("pages-quality-about.golden", most=HISTORY, fewest=FEWEST)
    charts = [
        dmc.Box([
            dmc.Group([dmc.Text(f"{of.station} · {of.serial}", fw="bold"),
                       badge(_golden_state(of), view)]),
            picture(f"quality-golden-{number}", golden_figure(of, shown, view)),
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


def _capability(found: CapabilityShown, shown: QualityShown, view: View) -> Component:
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
    stated = facts({f"pages-quality-fact.{name}": each for name, each in numbers.items()}, view)
    remarks = ["pages-quality-about.capability", "pages-quality-about.margin"]
    if found.lower is None and found.upper is None:
        remarks.append("pages-quality-about.no-limits")
    elif found.lower is None or found.upper is None:
        remarks.append("pages-quality-about.one-sided")
    remarks += ["pages-quality-about.limits-vary"] if found.limits_vary else []
    first = facts(indices, view)
    if found.n < FEWEST_IN_INDEX:
        few = view.text("pages-quality-about.few", count=found.n, fewest=FEWEST_IN_INDEX)
        first = dmc.Text(few)
    return dmc.Stack(
        [first, stated, dmc.Box([note(view.text(each)) for each in remarks])], gap="sm"
    )


def _index(index: CapabilityIndex) -> str | None:
    """“1.33 (1.28 … 1.37)”."""
    if index.value is None or index.low is None or index.high is None:
        return None
    value, low, high = (
        f"{each:.2f}".replace("-", MINUS) for each in (index.value, index.low, index.high)
    )
    return f"{value} ({low} … {high})"


def _chart(
    chart: ChartShown, shown: QualityShown, view: View, with_csv: WithCsv
) -> list[Component]:
    counts = [sum(rule in point.broken for point in chart.points) for rule in range(1, RULES + 1)]
    rules = [
        (str(rule), view.text(f"pages-quality-nelson.rule-{rule}"), str(count))
        for rule, count in enumerate(counts, start=1)
    ]
    about = view.text(f"pages-quality-about.chart-{chart.plotted}", count=len(chart.points))
    return [
        note(about),
        with_csv("chart", picture("quality-chart", chart_figure(chart, shown, view))),
        with_csv("rules", table("pages-quality-nelson", "rule pattern count", rules, view, 320)),
    ]


def _stations(stations: Sequence[StationShown], shown: QualityShown, view: View) -> Component:
    if all(each.difference is None for each in stations):
        return dmc.Text(view.text("pages-quality-about.one-station"))
    names = "station difference u runs state"
    rows = [_station(each, shown, view) for each in stations]
    figure = stations_figure(stations, shown, view)
    return dmc.Stack([
        note(view.text("pages-quality-about.stations")),
        dmc.SimpleGrid(
            [picture("quality-stations", figure),
             table("pages-quality-station", names, rows, view, 320)],
            cols={"base": 1, "lg": 2},
        ),
    ])  # fmt: skip


def _station(one: StationShown, shown: QualityShown, view: View) -> tuple[Any, ...]:
    if one.difference is None or one.U is None:
        state = stated("pages-quality-state.open", "open")
        return one.station, None, None, str(one.runs), badge(state, view)
    made = quantities([one.difference], one.U, shown.unit, Scale(1.0, 0, shown.unit))
    unit = "" if made.unit == "1" else f" {unit_text(made.unit)}"
    is_off = abs(one.difference) > one.U
    words = f"pages-quality-state.{'off' if is_off else 'within'}"
    state = stated(words, "bad" if is_off else "good")
    cells = (f"{made.values[0]}{unit}", f"{made.uncertainties[0]}{unit} (k = {USUAL_K:g})")
    return one.station, *cells, str(one.runs), badge(state, view)
