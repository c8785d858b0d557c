"""Lays the Mismatch page out."""

from collections.abc import Sequence

import dash_mantine_components as dmc
from dash import dcc, html
from dash.development.base_component import Component

from flows.pages.discrepancy.data import (
    Carried,
    DiscrepancyQuestion,
    DiscrepancyShown,
    EffectSeen,
    ExplainedRun,
    PaperMoved,
    Papers,
    ReviewShown,
    Shown,
    UncertainTime,
)
from flows.pages.parts import (
    Cell,
    StepState,
    View,
    badge,
    choice,
    day_in,
    facts,
    heading,
    link,
    note,
    second_of,
    table,
    validity_state,
)
from schemas.discrepancy import FoundParameter, Moved, Verdict
from schemas.review import Moment, ReviewFinding
from tasks.explain.report.statements import parameter_text
from tasks.model.term import effect_name, next_step, separating_recording
from tasks.review.report import deciding_run
from tasks.specifications.estimate import symbol
from tasks.words import Sayable, message
from tasks.words.numbers import multiple, plain

EVERY = "pages-mismatch-all"
FEW, MOST_PAPERS = 8, 50  # carriers and certificates listed


def layout(shown: DiscrepancyShown, view: View, question: DiscrepancyQuestion) -> Component:
    """The last review, then what the explained runs show one by one."""
    none = view.text("pages-mismatch-no-review")
    review = _review(shown.review, view) if shown.review else [dmc.Text(none)]
    counted = view.text(
        "pages-mismatch-explained", explained=shown.explained, runs=shown.runs,
        invalid=shown.invalid,
    )  # fmt: skip
    return dmc.Stack(
        [
            heading("pages-mismatch-review", view),
            *review,
            heading("pages-mismatch-own", view),
            _choices(shown, view, question),
            note(counted),
            *(_effect(each, view) for each in shown.effects),
            heading("pages-mismatch-runs", view),
            _runs(shown.newest, view),
        ],
        gap="sm",
    )


def _choices(shown: DiscrepancyShown, view: View, question: DiscrepancyQuestion) -> Component:
    values = {"effect": shown.known, "station": shown.stations, "model": shown.models,
              "serial": shown.serials}  # fmt: skip
    controls = [
        choice(name, f"pages-mismatch-asked.{name}", of, getattr(question, name), view, EVERY)
        for name, of in values.items()
    ]
    return dmc.SimpleGrid(controls, cols={"base": 2, "sm": 4}, spacing="xs")


def _review(review: ReviewShown, view: View) -> list[Component]:
    asked = ", ".join(_asked(name, value, view) for name, value in review.asked.items())
    days = f"{review.days[0]} … {review.days[1]}" if review.days else None
    about = facts(
        {
            "pages-mismatch-fact.at": second_of(review.at),
            "pages-mismatch-fact.asked": asked or view.text(EVERY),
            "pages-mismatch-fact.runs": f"{review.runs} (+ {review.skipped})",
            "pages-mismatch-fact.days": days,
        },
        view,
    )
    state = _state(review.verdict)
    summary = dmc.Group([badge(state, view), dmc.Text(view.say(review.statement))])
    carriers: dict[tuple[str, str], list[Carried]] = {}
    for each in review.findings:
        carriers.setdefault((each.finding.level, each.finding.carrier), []).append(each)
    return [about, summary, *(_carrier(of, view) for of in carriers.values())]


def _asked(name: str, value: str, view: View) -> str:
    """A part of what a review was asked of, in words."""
    if name == "paths":
        return view.text("pages-mismatch-recordings", count=int(value))
    kind = "fact" if name in ("since", "until") else "asked"
    return f"{view.text(f'pages-mismatch-{kind}.{name}')} {value}"


def _state(verdict: Verdict) -> StepState:
    """A mismatch is never good, explained or not: a named cause is a reason to act."""
    words = message(f"pages-mismatch-verdict.{verdict.replace('_', '-')}")
    return StepState(words, "good" if verdict == "no_mismatch" else "bad")


def _carrier(of: Sequence[Carried], view: View) -> Component:
    """A station, unit, model, lot or site once, with everything that was found of it."""
    finding = of[0].finding
    name = view.text(f"pages-mismatch-level.{finding.level}") + f" {finding.carrier}"
    parts = [part for each in of for part in _carried(each, view)]
    head = dmc.Title(name, order=4)
    return dmc.Card(dmc.Stack([head, *parts], gap="xs"), withBorder=True, className="carried")


def _carried(carried: Carried, view: View) -> list[Component]:
    """An effect: since when, in how many runs, how large and how clear; what to do about it, and
    what it touches.
    """
    finding = carried.finding
    evidence = finding.evidence
    sizes = dmc.Stack([dmc.Text(_parameter(p, view)) for p in finding.parameters], gap=0)
    shown = facts(
        {
            "pages-mismatch-fact.since": _moment(finding.since, view),
            "pages-mismatch-fact.until": _moment(finding.until, view),
            "pages-mismatch-fact.shown": f"{evidence.runs_that_show_it} / {evidence.runs}",
            "pages-mismatch-fact.sizes": sizes,
            "pages-mismatch-fact.clear": view.text(
                "pages-mismatch-clear", z=plain(evidence.per_run_z_median, 2)
            ),
        },
        view,
    )
    parts = [dmc.Text(view.say(carried.title), fw="bold"), shown, _to_do(finding, view)]
    parts += _touched(carried.papers, carried.query, view)
    parts += [_uncertain(each, view) for each in carried.uncertain]
    return parts + _moved(carried.moved, view)


def _to_do(finding: ReviewFinding, view: View) -> Component:
    """What separates it from other carriers and effects, else what removes it; and where."""
    steps: list[Sayable] = [
        deciding_run(finding.level, finding.carrier, each) for each in finding.alternatives
    ]
    if finding.indistinguishable_from:
        names = tuple(map(effect_name, finding.indistinguishable_from))
        separated = separating_recording(finding.effect)
        steps.append(message("review-other-names", names=names))
        steps += [message("review-separated-by", recording=separated)] if separated else []
    step = next_step(finding.effect)
    steps += [step] if step and not steps else []
    texts = [dmc.Text(f"→ {view.say(each)}") for each in steps]
    order = dcc.Link(view.text("pages-action.acquire"), href="/do", className="button")
    return dmc.Stack([*texts, dmc.Group(order)], gap=4)


def _moment(moment: Moment | None, view: View) -> str | None:
    """The day, and the days between which the change lies with 95 %."""
    if moment is None:
        return None
    at, earliest, latest, without = map(
        day_in, (moment.at, moment.earliest, moment.latest, moment.without)
    )
    if not without:
        return f"{at} (95 %: {earliest} … {latest})"
    low, high = (without, latest) if without < earliest else (earliest, without)
    return view.text("pages-mismatch-between", at=at, low=low, high=high)


def _uncertain(time: UncertainTime, view: View) -> Component:
    counted = view.text(
        "pages-mismatch-uncertain", issued=time.papers.issued, since=time.query["since"],
        until=time.query["until"],
    )  # fmt: skip
    return dmc.Group([dmc.Text(counted, size="sm"), _runs_link(time.query, view)])


def _moved(papers: Sequence[PaperMoved], view: View) -> list[Component]:
    """What it changes in the certificates of reviewed runs, element by element."""
    if not papers:
        return []
    rows = [
        (
            link(paper.number, "/runs", certificate=paper.number),
            link(paper.run, "/run", id=paper.run),
            ", ".join(_in_U(each) for each in paper.moved),
        )
        for paper in papers[:MOST_PAPERS]
    ]
    about = view.text("pages-mismatch-moved", count=len(papers), listed=len(rows))
    return [
        dmc.Text(about, size="sm", fw="bold"),
        table("pages-mismatch-moved", "paper run elements", rows, view),
    ]


def _in_U(moved: Moved) -> str:
    """“B_ax −1.5 U”; a no-break space keeps them together."""
    return f"{symbol(moved.item, moved.element)} {multiple(moved.in_U)} U".replace(" ", "\u00a0")


def _parameter(parameter: FoundParameter, view: View) -> str:
    return view.say(parameter_text(parameter))


def _touched(papers: Papers | None, query: dict[str, str] | None, view: View) -> list[Component]:
    """The certificates that may be wrong, with the way to their runs."""
    if papers is None:
        return []
    counted = view.text("pages-mismatch-touched", issued=papers.issued, drafts=papers.drafts)
    parts: list[Component] = [dmc.Text(counted, size="sm", fw="bold")]
    parts += [_runs_link(query, view)] if query else []
    listed = [link(number, "/runs", certificate=number) for number in papers.numbers]
    listed += [dmc.Text("…")] if papers.issued > len(papers.numbers) else []
    return [dmc.Group(parts), dmc.Group(listed, gap="xs", className="small")]


def _runs_link(query: dict[str, str], view: View) -> Component:
    return link(view.text("pages-mismatch-their-runs"), "/runs", **query)


def _effect(seen: EffectSeen, view: View) -> Component:
    carriers = {
        f"pages-mismatch-level.{level}": _shares(getattr(seen, f"by_{level}"), seen, field)
        for level, field in (("station", "station"), ("model", "model"), ("unit", "serial"))
    }
    days = f"{seen.since} … {seen.until}" if seen.since else None
    moved = ", ".join(map(_in_U, seen.moved))
    counted = view.text("pages-mismatch-in-runs", count=seen.runs)
    head = dmc.Group([
        dmc.Title(view.say(seen.title), order=4), dmc.Code(seen.effect),
        link(counted, "/mismatch", effect=seen.effect),
    ])  # fmt: skip
    shown = facts(
        {"pages-mismatch-fact.days": days, **carriers,
         "pages-mismatch-fact.moved": dmc.Text(moved, size="sm") if moved else None},
        view,
    )  # fmt: skip
    touched = _touched(seen.papers, None, view)
    return dmc.Card(dmc.Stack([head, shown, *touched], gap="xs"), withBorder=True)


def _shares(shares: Sequence[Shown], seen: EffectSeen, field: str) -> Component:
    """Each carrier leads to its runs with the effect."""
    lines = [
        link(f"{each.name}: {each.shown} / {each.of}", "/mismatch", effect=seen.effect,
             **{field: each.name}, **({"model": each.model} if each.model else {}))
        for each in shares[:FEW]
    ]  # fmt: skip
    lines += [dmc.Text("…")] if len(shares) > FEW else []
    return dmc.Stack(lines, gap=0, className="small")


def _runs(runs: Sequence[ExplainedRun], view: View) -> Component:
    names = "run day station unit validity verdict findings report"
    return table("pages-mismatch-column", names, [_run(run, view) for run in runs], view)


def _run(run: ExplainedRun, view: View) -> tuple[Cell, ...]:
    found = [
        dmc.Text(f"{view.say(f.title)} ({100 * f.share:.0f} %): " + ", ".join(
            _parameter(p, view) for p in f.parameters[:3]), size="sm")
        for f in run.findings
    ]  # fmt: skip
    report = html.A(
        view.text("pages-mismatch-report"), href=f"/explained/{run.run}.html",
        className="whole",
        target="_blank",
    )  # fmt: skip
    return (
        link(run.run, "/run", id=run.run),
        str(run.day) if run.day else None,
        run.station,
        f"{run.model} {run.serial}",
        badge(validity_state(run.validity), view),
        badge(_state(run.verdict), view),
        dmc.Stack(found, gap=2) if found else None,
        report,
    )
