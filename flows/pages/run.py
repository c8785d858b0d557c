"""The page of one run: signals, segments, items, certificates, log and lineage."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import dash_mantine_components as dmc
from dash import Dash, Input, Output, State, dcc, no_update
from dash.development.base_component import Component

from flows.pages.parts import (
    GRAPH,
    Page,
    badge,
    certificate_state,
    day_of,
    decision_state,
    facts,
    figure,
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
    BudgetShown,
    CertificateShown,
    ElementShown,
    LimitShown,
    RunQuestion,
    RunShown,
    SegmentShown,
    SignalsQuestion,
    SignalsShown,
    data,
)
from schemas.base import Unusable
from schemas.recording import Recording, Stream
from schemas.text import Remark, Statement
from storage.catalogue import results, runs
from storage.catalogue.runs import STANDARD_DOCUMENT, Run, find
from storage.home import Home
from tasks.certificate.equipment import setting
from tasks.conformity.capabilities import name_of
from tasks.rendering import envelope
from tasks.specifications.estimate import item_title, symbol
from tasks.words import Sayable, message, statement
from tasks.words.numbers import column, plain, power_of_ten, unit_text

# Raw channels of a run between two times, reduced so that minima and maxima are kept.


HEIGHT_PX = 420
KEPT = 2  # recordings that stay in memory, for the next look at the same run
UNITS = {"gyro": "rad/s", "accel": "m/s²", "angle": "rad", "temperature": "°C", "humidity": "%RH",
         "supply": "V", "mag": "µT"}  # fmt: skip
LOW, HIGH = "#1c7ed6", "#4dabf7"


def signal_data(question: SignalsQuestion, home: Home) -> SignalsShown:
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
        low=_finite_or_none(shown.low), high=_finite_or_none(shown.high), channels=channels,
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


def _finite_or_none(values: Any) -> tuple[float | None, ...]:
    return tuple(None if value != value else value for value in values.tolist())


@lru_cache(maxsize=KEPT)
def _recording(run: Run, home: Home) -> Recording:
    """Raw recordings never change, so a cached one equals the file."""
    return runs.load(run, home)


def signal_section(run: str, question: SignalsQuestion | None = None) -> Component:
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


def signal_layout(shown: SignalsShown, question: SignalsQuestion) -> Component:
    """The graph alone."""
    return signal_section(shown.run, question)


def signal_callbacks(app: Dash, home: Home) -> None:
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
        shown = signal_data(
            SignalsQuestion(
                run=run, stream=stream, channel=channel, since=zoom.get("xaxis.range[0]"),
                until=zoom.get("xaxis.range[1]"),
            ),
            home,
        )  # fmt: skip
        listed = [f"{name} {each}" for name, every in shown.channels.items() for each in every]
        words = "reduced" if shown.is_reduced else "whole"
        count = message(f"pages-signals-rows.{words}", rows=shown.rows, points=len(shown.t))
        return _signal_figure(shown), listed, say(count)


def _signal_figure(shown: SignalsShown) -> dict[str, Any]:
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


SIGNALS_PAGE = Page(
    "signals",
    SignalsQuestion,
    SignalsShown,
    signal_data,
    signal_layout,
    in_navigation=False,
    callbacks=signal_callbacks,
)


# The uncertainty budget of one element.


def budget_data(question: BudgetQuestion, home: Home) -> BudgetShown:
    """The budget of an element by the run's newest result; Unusable where there is none."""
    result = results.find(question.run, home)
    item = result.calibration.items.get(question.item)
    budget = item.budgets.get(question.element) if item else None
    if budget is None:
        raise Unusable(
            f"result {result.id} of run {result.run} has no budget of {question.item} "
            f"{question.element}; GET /api/v1/run?id={result.run} lists those that have one"
        )
    return BudgetShown(
        run=result.run,
        result=result.id,
        title=statement(item_title(question.item)),
        symbol=symbol(question.item, question.element),
        budget=budget,
    )


def budget_layout(shown: BudgetShown, _: BudgetQuestion) -> Component:
    """A line for each input, as the certificate prints them."""
    budget = shown.budget
    unit = unit_text(budget.unit)
    rows = [
        (
            f"{say(name_of(each))} ({each.symbol})",
            f"{each.kind}, {said(f'pages-distribution.{each.distribution}')}",
            f"{plain(each.u)} {unit_text(each.unit)}",
            plain(each.sensitivity),
            f"{plain(each.contribution)} {unit}",
            f"{100 * each.share:.1f} %",
            each.source,
        )
        for each in budget.inputs
    ]
    printed = column([budget.value], [budget.U], budget.k)
    power = f"{power_of_ten(printed.exponent)} ".lstrip()
    summary = said(
        "pages-budget-summary", item=shown.title, symbol=shown.symbol,
        value=f"{printed.values[0]} {power}{unit}",
        u=f"{plain(budget.u_c)} {unit}", k=f"{budget.k:.3g}",
        expanded=f"{printed.uncertainties[0]} {power}{unit}",
    )  # fmt: skip
    names = "input kind u sensitivity contribution share source"
    return dmc.Stack(
        [
            dmc.Text(summary),
            table("pages-budget-column", names, rows),
        ]
    )


BUDGET_PAGE = Page(
    "budget", BudgetQuestion, BudgetShown, budget_data, budget_layout, in_navigation=False
)


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
        "signals": signal_section(shown.run.id),
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
        return budget_layout(budget_data(question, home), question)


PAGE = Page("run", RunQuestion, RunShown, data, layout, in_navigation=False, callbacks=callbacks)
