"""Lays the page of one run out, and draws its signals."""

from collections.abc import Sequence
from typing import Any

import dash_mantine_components as dmc
from dash import Dash, Input, Output, State
from dash.development.base_component import Component

from flows.pages import budget, signals
from flows.pages.local_time import day_of
from flows.pages.page import View, parameters, view_of_request
from flows.pages.parts import facts, link, note, table
from flows.pages.run.lineage import certificate_table, lineage, log
from flows.pages.run.models import (
    BudgetQuestion,
    ElementShown,
    LimitShown,
    RunQuestion,
    RunShown,
    SegmentShown,
)
from flows.pages.states import (
    badge,
    certificate_state,
    limit_state,
    result_state,
    validity_state,
    verdict_state,
)
from schemas.text import Remark, Statement
from storage.home import Home
from tasks.words import Sayable, message
from tasks.words.quantities import power_of_ten, unit_text

MAX_INLINE_SEGMENTS = 3  # segments; a remark that names more of them stands once, above the table
TABS = ("items", "segments", "signals", "certificate", "log", "lineage")


def layout(shown: RunShown, view: View, _: RunQuestion) -> Component:
    """Who, where, when and how it stands; the rest in tabs."""
    panels: dict[str, Component] = {
        "items": _items(shown, view),
        "segments": _segments(shown, view),
        "signals": signals.section(shown.run.id, view),
        "certificate": certificate_table(shown.certificates, view),
        "log": log(shown, view),
        "lineage": lineage(shown, view),
    }
    names = [dmc.TabsTab(view.text(f"pages-run-tab.{tab}"), value=tab) for tab in TABS]
    return dmc.Stack(
        [
            _facts(shown, view),
            *_reasons(shown.reasons, view),
            *_reasons(shown.undecided, view, message("pages-run-undecided")),
            dmc.Tabs(
                [
                    dmc.TabsList(names),
                    *(dmc.TabsPanel(panels[tab], value=tab, pt="md") for tab in TABS),
                ],
                value=TABS[0],
                id="run-tabs",
            ),
        ]
    )


def _reasons(
    reasons: Sequence[Statement | Remark], view: View, title: Sayable = ""
) -> list[Component]:
    """Sentences in one box; nothing where there are none."""
    texts = [dmc.Text(view.say(reason), size="sm") for reason in reasons]
    box = dmc.Alert(dmc.Stack(texts, gap=6), title=view.say(title), color="yellow", p="sm")
    return [box] if texts else []


def _facts(shown: RunShown, view: View) -> Component:
    run = shown.run
    unit = f"{run.manufacturer} {run.model} {run.serial}"
    number, count = shown.order or (None, 1)
    again = view.text("pages-run-again", number=number or "", count=count)
    return facts(
        {
            "pages-column-id": run.id,
            "pages-line-unit": link(unit, "/unit", id=str(run.unit)),
            "pages-column-station": run.station,
            **({"pages-run-order": again if count > 1 else number} if number else {}),
            "pages-column-recorded-on": str(run.recorded_on or day_of(run.imported_at)),
            "pages-column-validity": badge(validity_state(run.validity), view),
            "pages-column-result-state": badge(result_state(run), view),
            "pages-column-verdict": badge(verdict_state(run), view),
            "pages-column-state": badge(certificate_state(run.state), view),
        },
        view,
    )


def _items(shown: RunShown, view: View) -> Component:
    names = "item symbol value u limits margin verdict"
    rows = [row for element in shown.elements for row in _element(element, view)]
    budgets = [
        {"value": f"{each.item} {each.element}", "label": f"{view.say(each.title)} {each.symbol}"}
        for each in shown.elements
        if each.has_budget
    ]
    absent = [dmc.Text(view.say(why), size="sm") for why in shown.unavailable.values()]
    limits = message("pages-items-limits", certificate=shown.limits_of or "")
    without = message("pages-items-no-limits")
    return dmc.Stack(
        [
            note(view.say(limits if shown.limits_of else without)),
            dmc.Select(
                id="budget-of",
                data=budgets,
                label=view.text("pages-budget-of"),
                searchable=True,
                clearable=True,
                maw=480,
            ),
            dmc.Box(id="budget"),
            table("pages-items-column", names, rows, view),
            *absent,
        ]
    )


def _element(shown: ElementShown, view: View) -> list[tuple[Any, ...]]:
    """A row for each limit of an element, and one for an element without."""
    power = f"{power_of_ten(shown.exponent)} ".lstrip()
    unit = f" {power}{'' if shown.unit == '1' else unit_text(shown.unit)}".rstrip()
    first = (
        view.say(shown.title),
        shown.symbol,
        shown.value_text and shown.value_text + unit,
        shown.U_text and f"{shown.U_text}{unit} (k = {shown.k:g})",
    )
    return [(*first, *_limit(limit, unit, view)) for limit in shown.limits or (None,)]


def _limit(limit: LimitShown | None, unit: str, view: View) -> tuple[Any, ...]:
    if limit is None:
        return None, None, None
    margin = None if limit.margin is None else f"{limit.margin:.1f} U"
    return limit.text + unit, margin, badge(limit_state(limit.decision), view)


def _segments(shown: RunShown, view: View) -> Component:
    names = "name kind since until rate rows checks"
    every = {remark.code: remark for each in shown.segments for remark in each.remarks}
    of_many = [each for each in every.values() if len(each.segments) > MAX_INLINE_SEGMENTS]
    rows = [_segment(each, view) for each in shown.segments]
    return dmc.Stack([*_reasons(of_many, view), table("pages-segments-column", names, rows, view)])


def _segment(segment: SegmentShown, view: View) -> tuple[Any, ...]:
    rows = None if segment.rows is None else f"{segment.rows}"
    if segment.rows_left_out:
        rows = view.text(
            "pages-segments-left-out", rows=segment.rows or 0, out=segment.rows_left_out
        )
    checks = [
        dmc.Text(view.say(remark), size="sm")
        for remark in segment.remarks
        if len(remark.segments) <= MAX_INLINE_SEGMENTS
    ]
    return (
        segment.name,
        view.text(f"pages-segment-kind.{segment.kind}"),
        f"{segment.t_start:.2f}",
        f"{segment.t_end:.2f}",
        None if segment.rate_deg_s is None else f"{segment.rate_deg_s:+g} °/s",
        rows,
        dmc.Stack(checks, gap=2) if checks else "",
    )


def callbacks(app: Dash, home: Home) -> None:
    """The budget of the element that is chosen."""

    @app.callback(
        Output("budget", "children"),
        Input("budget-of", "value"),
        State("address", "search"),
        prevent_initial_call=True,
    )
    def choose(chosen: str | None, search: str) -> Any:
        if not chosen:
            return None
        view, run = view_of_request(), parameters(search).get("id", "")
        item, _, element = chosen.partition(" ")
        question = BudgetQuestion(run=run, item=item, element=element)
        return budget.layout(budget.data(question, home), view, question)
