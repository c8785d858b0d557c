"""Mismatch: which physics is missing, on which station, unit and model, and since when."""

from collections.abc import Sequence

import dash_mantine_components as dmc
from dash import html
from dash.development.base_component import Component

from flows.pages.asked import asks
from flows.pages.mismatch_data import data
from flows.pages.page import Page, View
from flows.pages.parts import Cell, facts, link, table
from flows.pages.states import StepState, badge
from schemas.discrepancy import FoundParameter, Verdict
from schemas.pages.mismatch import (
    Carried,
    EffectSeen,
    ExplainedRun,
    MismatchQuestion,
    MismatchShown,
    Papers,
    ReviewShown,
    Shown,
)
from schemas.review import Touched
from tasks.explain.report.names import parameter_text
from tasks.specifications.items import symbol
from tasks.words import message
from tasks.words.quantities import multiple

ASKED = ("effect", "station", "model", "serial")
FEW = 8  # carriers listed


def layout(shown: MismatchShown, view: View, question: MismatchQuestion) -> Component:
    """The last review, then what the explained runs show one by one."""
    none = message("pages-mismatch-no-review")
    review = _review(shown.review, view) if shown.review else [dmc.Text(view.say(none))]
    counted = message("pages-mismatch-explained", explained=shown.explained, runs=shown.runs)
    return dmc.Stack(
        [
            _heading("review", view),
            *review,
            _heading("own", view),
            _choices(shown, view, question),
            dmc.Text(view.say(counted), size="sm", c="dimmed"),
            *(_effect(each, view) for each in shown.effects),
            _heading("runs", view),
            _runs(shown.newest, view),
        ],
        gap="sm",
    )


def _heading(name: str, view: View) -> Component:
    return dmc.Title(view.say(message(f"pages-mismatch-{name}")), order=3, mt="sm")


def _choices(shown: MismatchShown, view: View, question: MismatchQuestion) -> Component:
    values = {"effect": shown.known, "station": shown.stations, "model": shown.models,
              "serial": shown.serials}  # fmt: skip
    asked = question.model_dump()
    controls = [
        dmc.Select(
            id=asks(name, asked[name]), label=view.say(message(f"pages-mismatch-asked.{name}")),
            data=list(values[name]), value=asked[name], searchable=True, clearable=True,
            placeholder=view.say(message("pages-mismatch-all")),
        )
        for name in ASKED
    ]  # fmt: skip
    return dmc.SimpleGrid(controls, cols={"base": 2, "sm": 4}, spacing="xs")


def _review(review: ReviewShown, view: View) -> list[Component]:
    asked = ", ".join(_asked(name, value, view) for name, value in review.asked.items())
    days = f"{review.days[0]} … {review.days[1]}" if review.days else None
    everything = view.say(message("pages-mismatch-all"))
    about = facts(
        [
            (message("pages-mismatch-fact.at"), f"{review.at:%F %T} UTC"),
            (
                message("pages-mismatch-fact.asked"),
                asked or everything,
            ),
            (message("pages-mismatch-fact.runs"), f"{review.runs} (+ {review.skipped})"),
            (message("pages-mismatch-fact.days"), days),
        ],
        view,
    )
    state = _state(review.verdict)
    summary = dmc.Group([badge(state, view), dmc.Text(view.say(review.statement))])
    return [about, summary, *(_carried(each, view) for each in review.findings)]


def _asked(name: str, value: str, view: View) -> str:
    """A part of what a review was asked of, in words."""
    if name == "paths":
        return view.say(message("pages-mismatch-recordings", count=int(value)))
    kind = "fact" if name in ("since", "until") else "asked"
    return f"{view.say(message(f'pages-mismatch-{kind}.{name}'))} {value}"


def _state(verdict: Verdict) -> StepState:
    """A mismatch is never good, explained or not: a name is a reason to act."""
    words = message(f"pages-mismatch-verdict.{verdict.replace('_', '-')}")
    return StepState(words, "good" if verdict == "no_mismatch" else "bad")


def _carried(carried: Carried, view: View) -> Component:
    finding = carried.finding
    evidence = finding.evidence
    carrier = view.say(message(f"pages-mismatch-level.{finding.level}")) + f" {finding.carrier}"
    since = f"{finding.since.at[:10]}" if finding.since else None
    until = f"{finding.until.at[:10]}" if finding.until else None
    sizes = dmc.Stack([dmc.Text(_parameter(p, view)) for p in finding.parameters], gap=0)
    leaning = f"{evidence.runs_that_show_it} / {evidence.runs}"
    shown = facts(
        [
            (message("pages-mismatch-fact.since"), since),
            (message("pages-mismatch-fact.until"), until),
            (message("pages-mismatch-fact.shown"), leaning),
            (message("pages-mismatch-fact.sizes"), sizes),
        ],
        view,
    )
    head = dmc.Group([
        dmc.Title(carrier, order=4), dmc.Text(view.say(carried.title), fw="bold"),
    ])  # fmt: skip
    moved = {(t.item, t.element): t.in_U for t in sorted(finding.touched, key=_size)}
    most = sorted(moved.items(), key=lambda each: -abs(each[1]))[:FEW]
    elements = ", ".join(f"{symbol(*element)} {multiple(in_U)} U" for element, in_U in most)
    if elements:
        shown = dmc.Stack([shown, facts(
            [(message("pages-mismatch-fact.moved"), elements)], view)], gap="xs")  # fmt: skip
    text = dmc.Text(view.say(finding.statement), size="sm", c="dimmed")
    parts = [head, shown, text, *_touched(carried.papers, carried.query, view)]
    return dmc.Card(dmc.Stack(parts, gap="xs"), withBorder=True, className="carried")


def _size(touched: Touched) -> float:
    return abs(touched.in_U)


def _parameter(parameter: FoundParameter, view: View) -> str:
    return view.say(parameter_text(parameter))


def _touched(papers: Papers | None, query: dict[str, str] | None, view: View) -> list[Component]:
    """The certificates that may be wrong, with the way to their runs."""
    if papers is None:
        return []
    listed = ", ".join(papers.numbers) + (" …" if papers.issued > len(papers.numbers) else "")
    counted = message("pages-mismatch-touched", issued=papers.issued, drafts=papers.drafts)
    parts: list[Component] = [dmc.Text(view.say(counted), size="sm", fw="bold")]
    if query:
        way = view.say(message("pages-mismatch-their-runs"))
        parts.append(link(way, "/runs", **query))
    return [dmc.Group(parts), dmc.Text(listed, size="sm")]


def _effect(seen: EffectSeen, view: View) -> Component:
    names = ("station", "model", "unit")
    carriers = [
        (message(f"pages-mismatch-level.{name}"), _shares(getattr(seen, f"by_{name}")))
        for name in names
    ]
    days = f"{seen.since} … {seen.until}" if seen.since else None
    moved = ", ".join(f"{symbol(m.item, m.element)} {multiple(m.in_U)} U" for m in seen.moved)
    head = dmc.Group([
        dmc.Title(view.say(seen.title), order=4), dmc.Code(seen.effect),
        dmc.Text(view.say(message("pages-mismatch-in-runs", count=seen.runs))),
    ])  # fmt: skip
    shown = facts(
        [(message("pages-mismatch-fact.days"), days), *carriers,
         (message("pages-mismatch-fact.moved"), moved or None)],
        view,
    )  # fmt: skip
    touched = _touched(seen.papers, None, view)
    return dmc.Card(dmc.Stack([head, shown, *touched], gap="xs"), withBorder=True)


def _shares(shares: Sequence[Shown]) -> Component:
    lines = [f"{each.name}: {each.shown} / {each.of}" for each in shares[:FEW]]
    lines += ["…"] if len(shares) > FEW else []
    return dmc.Stack([dmc.Text(line, size="sm") for line in lines], gap=0)


def _runs(runs: Sequence[ExplainedRun], view: View) -> Component:
    names = ("run", "day", "station", "unit", "verdict", "findings", "report")
    headings = [message(f"pages-mismatch-column.{name}") for name in names]
    return table(headings, [_run(run, view) for run in runs], view)


def _run(run: ExplainedRun, view: View) -> tuple[Cell, ...]:
    found = [
        dmc.Text(f"{view.say(f.title)} ({100 * f.share:.0f} %): " + ", ".join(
            _parameter(p, view) for p in f.parameters[:3]), size="sm")
        for f in run.findings
    ]  # fmt: skip
    report = html.A(
        view.say(message("pages-mismatch-report")), href=f"/explained/{run.run}.html",
        className="whole",
        target="_blank",
    )  # fmt: skip
    return (
        html.Span(link(run.run, "/run", id=run.run), className="whole"),
        str(run.day) if run.day else None,
        html.Span(run.station, className="whole"),
        f"{run.model} {run.serial}",
        badge(_state(run.verdict), view),
        dmc.Stack(found, gap=2) if found else None,
        report,
    )


PAGE = Page("mismatch", MismatchQuestion, MismatchShown, data, layout)
