"""The page of one run: signals, segments, items, certificates, log and lineage."""

from collections.abc import Sequence
from typing import Any

import dash_mantine_components as dmc
from dash import Dash, Input, Output, State
from dash.development.base_component import Component

from flows.pages import budget, signals
from flows.pages.parts import (
    Page,
    badge,
    certificate_state,
    day_of,
    decision_state,
    facts,
    heading,
    limit_state,
    link,
    minute_of,
    note,
    parameters,
    result_state,
    said,
    say,
    second_of,
    table,
    validity_state,
    verdict_state,
)
from flows.pages.run_data import (
    BudgetQuestion,
    CertificateShown,
    ElementShown,
    LimitShown,
    RunQuestion,
    RunShown,
    SegmentShown,
    data,
)
from schemas.text import Remark, Statement
from storage.catalogue.runs import STANDARD_DOCUMENT
from storage.home import Home
from tasks.certificate.equipment import setting
from tasks.words import Sayable, message
from tasks.words.numbers import power_of_ten, unit_text

# Certificates, log and lineage of a run.


def certificate_table(shown: Sequence[CertificateShown]) -> Component:
    """Certificates, each with its PDF and the run that it stands on."""
    names = "number state verdict result calibrated issued due why"
    rows = [
        (
            dmc.Anchor(
                each.number, href=f"/certificate/{each.number}.pdf", refresh=True, inherit=True
            ),
            badge(certificate_state(each.state)),
            badge(decision_state(each.verdict)),
            link(each.result, "/run", id=each.run),
            str(each.calibrated_on or "–"),
            str(each.issued_on),
            str(each.due or "–"),
            each.why,
        )
        for each in shown
    ]
    return table("pages-certificate-column", names, rows, none="pages-certificates-none")


def log(shown: RunShown) -> Component:
    """Every change of the run's state, when and why."""
    rows = [
        (
            second_of(entry.at),
            f"{entry.t:.2f}",
            said(f"pages-run-state.{entry.state.replace('_', '-')}"),
            say(entry),
        )
        for entry in shown.log
    ]
    return table("pages-log-column", "at t state cause", rows, none="pages-run-no-log")


def lineage(shown: RunShown) -> Component:
    """What the run and its results come from, and what stands on them."""
    results = [
        (
            each.id,
            each.method,
            each.code_version,
            minute_of(each.made_at),
            each.supersedes,
            each.why,
            ", ".join(c.number for c in shown.certificates if c.result == each.id) or None,
        )
        for each in shown.results
    ]
    names = "id method code made supersedes why certificates"
    # The number of a certificate, or that the recording's manifest does
    standards = [
        (
            each.name,
            each.serial,
            each.certificate,
            said("pages-standards-manifest")
            if each.document == STANDARD_DOCUMENT
            else each.document,
        )
        for each in shown.standards
    ]
    made_with = [setting(*each) for each in shown.settings.items()]
    settings = [(say(each.name), say(each.value)) for each in made_with]
    return dmc.Stack(
        [
            facts(
                {
                    "pages-lineage-raw": dmc.Code(shown.digest),
                    "pages-lineage-sources": ", ".join(shown.sources),
                    "pages-column-recording-id": shown.run.recording_id,
                    "pages-column-procedure": shown.run.procedure,
                },
            ),
            heading("pages-lineage-heading.results"),
            table("pages-results-column", names, results),
            heading("pages-lineage-heading.standards"),
            table("pages-standards-column", "name serial certificate document", standards),
            heading("pages-lineage-heading.settings"),
            table("pages-settings-column", "name value", settings),
        ]
    )


# Lays the page of one run out, and draws its signals.

MAX_INLINE_SEGMENTS = 3  # segments; a remark that names more of them stands once, above the table
TABS = ("items", "segments", "signals", "certificate", "log", "lineage")


def layout(shown: RunShown, _: RunQuestion) -> Component:
    """Who, where, when and how it stands; the rest in tabs."""
    panels: dict[str, Component] = {
        "items": _items(shown),
        "segments": _segments(shown),
        "signals": signals.section(shown.run.id),
        "certificate": certificate_table(shown.certificates),
        "log": log(shown),
        "lineage": lineage(shown),
    }
    names = [dmc.TabsTab(said(f"pages-run-tab.{tab}"), value=tab) for tab in TABS]
    return dmc.Stack(
        [
            _facts(shown),
            *_reasons(shown.reasons),
            *_reasons(shown.undecided, message("pages-run-undecided")),
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


def _reasons(reasons: Sequence[Statement | Remark], title: Sayable = "") -> list[Component]:
    """Sentences in one box; nothing where there are none."""
    texts = [dmc.Text(say(reason), size="sm") for reason in reasons]
    box = dmc.Alert(dmc.Stack(texts, gap=6), title=say(title), color="yellow", p="sm")
    return [box] if texts else []


def _facts(shown: RunShown) -> Component:
    run = shown.run
    unit = f"{run.manufacturer} {run.model} {run.serial}"
    number, count = shown.order or (None, 1)
    again = said("pages-run-again", number=number or "", count=count)
    return facts(
        {
            "pages-column-id": run.id,
            "pages-line-unit": link(unit, "/unit", id=str(run.unit)),
            "pages-column-station": run.station,
            **({"pages-run-order": again if count > 1 else number} if number else {}),
            "pages-column-recorded-on": str(run.recorded_on or day_of(run.imported_at)),
            "pages-column-validity": badge(validity_state(run.validity)),
            "pages-column-result-state": badge(result_state(run)),
            "pages-column-verdict": badge(verdict_state(run)),
            "pages-column-state": badge(certificate_state(run.state)),
        },
    )


def _items(shown: RunShown) -> Component:
    names = "item symbol value u limits margin verdict"
    rows = [row for element in shown.elements for row in _element(element)]
    budgets = [
        {"value": f"{each.item} {each.element}", "label": f"{say(each.title)} {each.symbol}"}
        for each in shown.elements
        if each.has_budget
    ]
    absent = [dmc.Text(say(why), size="sm") for why in shown.unavailable.values()]
    limits = message("pages-items-limits", certificate=shown.limits_of or "")
    without = message("pages-items-no-limits")
    return dmc.Stack(
        [
            note(say(limits if shown.limits_of else without)),
            dmc.Select(
                id="budget-of",
                data=budgets,
                label=said("pages-budget-of"),
                searchable=True,
                clearable=True,
                maw=480,
            ),
            dmc.Box(id="budget"),
            table("pages-items-column", names, rows),
            *absent,
        ]
    )


def _element(shown: ElementShown) -> list[tuple[Any, ...]]:
    """A row for each limit of an element, and one for an element without."""
    power = f"{power_of_ten(shown.exponent)} ".lstrip()
    unit = f" {power}{'' if shown.unit == '1' else unit_text(shown.unit)}".rstrip()
    first = (
        say(shown.title),
        shown.symbol,
        shown.value_text and shown.value_text + unit,
        shown.U_text and f"{shown.U_text}{unit} (k = {shown.k:g})",
    )
    return [(*first, *_limit(limit, unit)) for limit in shown.limits or (None,)]


def _limit(limit: LimitShown | None, unit: str) -> tuple[Any, ...]:
    if limit is None:
        return None, None, None
    margin = None if limit.margin is None else f"{limit.margin:.1f} U"
    return limit.text + unit, margin, badge(limit_state(limit.decision))


def _segments(shown: RunShown) -> Component:
    names = "name kind since until rate rows checks"
    every = {remark.code: remark for each in shown.segments for remark in each.remarks}
    of_many = [each for each in every.values() if len(each.segments) > MAX_INLINE_SEGMENTS]
    rows = [_segment(each) for each in shown.segments]
    return dmc.Stack([*_reasons(of_many), table("pages-segments-column", names, rows)])


def _segment(segment: SegmentShown) -> tuple[Any, ...]:
    rows = None if segment.rows is None else f"{segment.rows}"
    if segment.rows_left_out:
        rows = said("pages-segments-left-out", rows=segment.rows or 0, out=segment.rows_left_out)
    checks = [
        dmc.Text(say(remark), size="sm")
        for remark in segment.remarks
        if len(remark.segments) <= MAX_INLINE_SEGMENTS
    ]
    return (
        segment.name,
        said(f"pages-segment-kind.{segment.kind}"),
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
        run = parameters(search).get("id", "")
        item, _, element = chosen.partition(" ")
        question = BudgetQuestion(run=run, item=item, element=element)
        return budget.layout(budget.data(question, home), question)


PAGE = Page("run", RunQuestion, RunShown, data, layout, in_navigation=False, callbacks=callbacks)
