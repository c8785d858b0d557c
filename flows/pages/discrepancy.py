"""The Mismatch page: which physics is missing, on which station, unit and model, and since when."""

from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import date, timedelta
from typing import Any

import dash_mantine_components as dmc
import sqlalchemy as sql
from dash import dcc, html
from dash.development.base_component import Component
from pydantic import AwareDatetime, Field

from flows.pages.parts import (
    Cell,
    Page,
    StepState,
    badge,
    choice,
    day_in,
    facts,
    heading,
    link,
    note,
    said,
    say,
    second_of,
    table,
    validity_state,
)
from schemas.base import Finite, Frozen
from schemas.certificate import LIVE
from schemas.discrepancy import FoundParameter, Moment, Moved, ReviewFinding, Touched, Verdict
from schemas.text import RunVerdict, Statement
from storage import run_statistics
from storage.catalogue import database, tables
from storage.catalogue.discrepancies import explained_runs
from storage.catalogue.run_states import complete_runs
from storage.catalogue.runs import stated_day
from storage.home import Home
from tasks.explain.report.statements import parameter_text
from tasks.model.term import effect_name, next_step, separating_recording
from tasks.review.report import deciding_run
from tasks.specifications.estimate import symbol
from tasks.words import Sayable, message, statement
from tasks.words.numbers import multiple, plain

# Which effects many runs show, by the last review and by each run's own findings.


class DiscrepancyQuestion(Frozen):
    """Which of the explained runs. Null: all of them. The review is the last one in any case."""

    effect: str | None = Field(default=None, max_length=200)
    station: str | None = Field(default=None, max_length=200)
    model: str | None = Field(default=None, max_length=200)
    serial: str | None = Field(default=None, max_length=200)


class Papers(Frozen):
    """The certificates on runs that an effect touches. numbers: of issued ones, the newest first,
    so many of them as are listed; issued and drafts: how many there are of either.
    """

    issued: int = 0
    drafts: int = 0
    numbers: tuple[str, ...] = ()


class UncertainTime(Frozen):
    """The days in which an effect may have been there already, or still. query: the fields of the
    list of runs that name the carrier's runs of that time; papers: certificates on these.
    """

    query: dict[str, str]
    papers: Papers


class PaperMoved(Frozen):
    """A certificate on a reviewed run, and its elements that the effect moves, the most first."""

    number: str
    run: str
    moved: tuple[Moved, ...]


class Carried(Frozen):
    """What a review found. query: the fields of the list of runs that name the carrier's runs; null
    where the catalogue does not tell them. papers: certificates on these. moved: those of reviewed
    runs with what it changes in them, the most first.
    """

    title: Statement
    finding: ReviewFinding
    query: dict[str, str] | None
    papers: Papers | None
    uncertain: tuple[UncertainTime, ...]
    moved: tuple[PaperMoved, ...]


class ReviewShown(Frozen):
    """The last review. asked: what it was asked of; skipped: runs that it could not use."""

    at: AwareDatetime
    asked: dict[str, str]
    days: tuple[date, date] | None
    runs: int
    skipped: int
    verdict: Verdict
    statement: Statement
    findings: tuple[Carried, ...]


class Shown(Frozen):
    """In how many of its explained runs a station, unit or model shows an effect.

    model: of a unit.
    """

    name: str
    model: str | None = None
    shown: int
    of: int
    since: date | None


class EffectSeen(Frozen):
    """An effect that `explain` named in runs. since, until: the days of its first and last run.

    moved: the elements that it moves most, in the run that it moves most.
    """

    effect: str
    title: Statement
    runs: int
    since: date | None
    until: date | None
    by_station: tuple[Shown, ...]
    by_model: tuple[Shown, ...]
    by_unit: tuple[Shown, ...]
    moved: tuple[Moved, ...]
    papers: Papers


class FoundShown(Frozen):
    """A finding in one run."""

    effect: str
    title: Statement
    share: Finite
    parameters: tuple[FoundParameter, ...]
    others: tuple[str, ...]


class ExplainedRun(Frozen):
    """A run that was explained, with what was found in it."""

    run: str
    day: date | None
    station: str
    model: str
    serial: str
    validity: RunVerdict | None = None
    verdict: Verdict
    findings: tuple[FoundShown, ...]


class DiscrepancyShown(Frozen):
    """review: null where none was made. runs: how many there are; explained: how many of these were
    explained and are asked for; invalid: of these the runs that are invalid, whose findings count
    for no effect; newest: the last ones. stations, models, serials, effects: what may be asked for.
    """

    review: ReviewShown | None
    runs: int
    explained: int
    invalid: int = 0
    effects: tuple[EffectSeen, ...]
    newest: tuple[ExplainedRun, ...]
    stations: tuple[str, ...]
    models: tuple[str, ...]
    serials: tuple[str, ...]
    known: tuple[str, ...]


NEWEST, LISTED, MOST_MOVED = 100, 12, 4
RUN, UNIT, PAPER = tables.runs.c, tables.units.c, tables.certificates.c
CARRIED_BY = {"station": "station", "unit": "serial", "model": "model"}  # fields of the run list
DAY = timedelta(days=1)
Explained = dict[str, Any]


def data(question: DiscrepancyQuestion, home: Home) -> DiscrepancyShown:
    """The last review, and the findings of the explained runs that are asked for."""
    complete_runs(home)
    every = explained_runs(home)
    chosen = [run for run in every if _is_asked(run, question)]
    valid = [run for run in chosen if run["validity"] != "invalid"]
    counted = database.rows(home, sql.select(sql.func.count()).select_from(tables.runs))
    return DiscrepancyShown(
        review=_review(home), runs=counted[0][0] if counted else 0, explained=len(chosen),
        invalid=len(chosen) - len(valid), effects=tuple(_effects(valid, question, home)),
        newest=tuple(ExplainedRun(
        run=run["run"], day=run["recorded_on"], station=run["station"] or "", model=run["model"],
        serial=run["serial"], validity=run["validity"], verdict=run["verdict"],
        findings=tuple(
            FoundShown(effect=f["effect"], title=f["brief"].title, share=f["share"],
                       parameters=f["brief"].parameters, others=f["brief"].others)
            for f in run["findings"]
        ),
    ) for run in reversed(chosen[-NEWEST:])),
        stations=_names(every, "station"), models=_names(every, "model"),
        serials=_names(every, "serial"),
        known=tuple(sorted({found["effect"] for run in every for found in run["findings"]})),
    )  # fmt: skip


def _is_asked(run: Explained, question: DiscrepancyQuestion) -> bool:
    asked = ((name, getattr(question, name)) for name in ("station", "model", "serial"))
    shown = {found["effect"] for found in run["findings"]}
    of_effect = question.effect is None or question.effect in shown
    return of_effect and all(wanted in (None, run[name]) for name, wanted in asked)


def _names(runs: Iterable[Explained], field: str) -> tuple[str, ...]:
    return tuple(sorted({run[field] for run in runs if run[field]}))


def _review(home: Home) -> ReviewShown | None:
    kept = run_statistics.last(home)
    if kept is None:
        return None
    review = kept.review
    return ReviewShown(
        at=kept.at, asked=kept.asked, days=kept.days, runs=review.runs,
        skipped=len(review.skipped), verdict=review.verdict, statement=review.statement,
        findings=tuple(_carried(finding, home) for finding in review.findings),
    )  # fmt: skip


def _carried(finding: ReviewFinding, home: Home) -> Carried:
    title, moved = statement(effect_name(finding.effect)), _moved(finding.touched, home)
    field = CARRIED_BY.get(finding.level)
    if field is None:
        return Carried(
            title=title, finding=finding, query=None, papers=None, uncertain=(), moved=moved
        )
    model, _, serial = finding.carrier.rpartition(" ") if field == "serial" else ("", "", "")
    own = {field: serial or finding.carrier} | ({"model": model} if model else {})
    since, until = (
        stated_day(each.at) if each else None for each in (finding.since, finding.until)
    )
    return Carried(
        title=title, finding=finding, query=own | _asked_days(since, until),
        papers=_papers(_papers_of(_which(own, since, until), home)),
        uncertain=tuple(_uncertain(own, finding, home)), moved=moved,
    )  # fmt: skip


def _moved(touched: Sequence[Touched], home: Home) -> tuple[PaperMoved, ...]:
    """By certificate, under the number that it has by now."""
    by_name: dict[str, list[Moved]] = {}
    for each in touched:
        moved = Moved(item=each.item, element=each.element, in_U=each.in_U)
        by_name.setdefault(each.certificate, []).append(moved)
    is_named = sql.or_(PAPER.number.in_(by_name), PAPER.draft.in_(by_name))
    rows = database.rows(home, sql.select(PAPER.number, PAPER.draft, PAPER.run).where(is_named))
    found = [
        PaperMoved(number=row.number, run=row.run, moved=tuple(moved))
        for row in rows
        for name, moved in by_name.items()
        if name in (row.number, row.draft)
    ]
    return tuple(sorted(found, key=lambda paper: -max(abs(m.in_U) for m in paper.moved)))


def _uncertain(own: dict[str, str], finding: ReviewFinding, home: Home) -> Iterable[UncertainTime]:
    """The days between the last run that is surely without the effect and the first that shows it,
    and those between the last that shows it and the next without.
    """
    ends = [(moment.without, moment.at) for moment in [finding.since] if moment]
    ends += [(moment.at, moment.without) for moment in [finding.until] if moment]
    for before, after in ends:
        first, last = stated_day(before), stated_day(after)
        if first is not None and last is not None and last - first > DAY:
            days = first + DAY, last - DAY
            papers = _papers(_papers_of(_which(own, *days), home))
            yield UncertainTime(query=own | _asked_days(*days), papers=papers)


def _asked_days(since: date | None, until: date | None) -> dict[str, str]:
    return {name: str(day) for name, day in (("since", since), ("until", until)) if day}


def _which(own: dict[str, str], since: date | None, until: date | None) -> sql.ColumnElement[bool]:
    columns = {"station": RUN.station, "serial": UNIT.serial, "model": UNIT.model}
    which = [columns[name] == value for name, value in own.items()]
    which += [RUN.recorded_on >= since] if since else []
    which += [RUN.recorded_on <= until] if until else []
    return sql.and_(*which)


def _papers_of(which: sql.ColumnElement[bool], home: Home) -> Sequence[sql.Row[Any]]:
    """run, number and state of the certificates that count on such runs, the newest first."""
    asked = (
        sql.select(PAPER.run, PAPER.number, PAPER.state)
        .select_from(tables.certificates.join(tables.runs, RUN.id == PAPER.run))
        .join(tables.units, UNIT.id == RUN.unit)
        .where(which, PAPER.state.in_(LIVE))
        .order_by(PAPER.kept_at.desc(), PAPER.number)
    )
    return database.rows(home, asked)


def _papers(rows: Sequence[sql.Row[Any]]) -> Papers:
    issued = [row.number for row in rows if row.state == "issued"]
    return Papers(
        issued=len(issued), drafts=len(rows) - len(issued), numbers=tuple(issued[:LISTED])
    )


def _effects(
    runs: Sequence[Explained], question: DiscrepancyQuestion, home: Home
) -> Iterable[EffectSeen]:
    """Each effect that the runs show, that of the most runs first."""
    with_effect: dict[str, list[Explained]] = {}
    for run in runs:
        for effect in dict.fromkeys(found["effect"] for found in run["findings"]):
            with_effect.setdefault(effect, []).append(run)
    of_explained = RUN.id.in_(sql.select(tables.explained.c.run))
    papers = _papers_of(of_explained, home) if with_effect else []
    for effect, own in sorted(with_effect.items(), key=lambda each: (-len(each[1]), each[0])):
        if question.effect in (None, effect):
            yield _effect(effect, own, runs, papers)


def _effect(
    effect: str, own: Sequence[Explained], runs: Sequence[Explained], papers: Sequence[sql.Row[Any]]
) -> EffectSeen:
    briefs = [f["brief"] for run in own for f in run["findings"] if f["effect"] == effect]
    most = max(briefs, key=lambda brief: max((abs(m.in_U) for m in brief.moved), default=0.0))
    days = [run["recorded_on"] for run in own if run["recorded_on"]]
    ids = {run["run"] for run in own}
    return EffectSeen(
        effect=effect, title=briefs[-1].title, runs=len(own), since=min(days, default=None),
        until=max(days, default=None), by_station=_by(own, runs, "station"),
        by_model=_by(own, runs, "model"), by_unit=_by(own, runs, "serial", "model"),
        moved=most.moved[:MOST_MOVED], papers=_papers([row for row in papers if row.run in ids]),
    )  # fmt: skip


def _by(own: Sequence[Explained], runs: Sequence[Explained], *fields: str) -> tuple[Shown, ...]:
    """Those that show it, the largest share first; by name, and a unit by its model as well."""
    of, shown = (
        Counter(tuple(run[f] or "" for f in fields) for run in each) for each in (runs, own)
    )
    first: dict[tuple[str, ...], date] = {}
    for run in own:
        if run["recorded_on"]:
            first.setdefault(tuple(run[f] or "" for f in fields), run["recorded_on"])
    found = [
        Shown(name=key[0], model=next(iter(key[1:]), None), shown=count, of=of[key],
              since=first.get(key))
        for key, count in shown.items()
    ]  # fmt: skip
    return tuple(sorted(found, key=lambda each: (-each.shown / each.of, -each.shown, each.name)))


# Lays the Mismatch page out.


EVERY = "pages-mismatch-all"
FEW, MOST_PAPERS = 8, 50  # carriers and certificates listed


def layout(shown: DiscrepancyShown, question: DiscrepancyQuestion) -> Component:
    """The last review, then what the explained runs show one by one."""
    none = said("pages-mismatch-no-review")
    review = _review_parts(shown.review) if shown.review else [dmc.Text(none)]
    counted = said(
        "pages-mismatch-explained", explained=shown.explained, runs=shown.runs,
        invalid=shown.invalid,
    )  # fmt: skip
    values = {"effect": shown.known, "station": shown.stations, "model": shown.models,
              "serial": shown.serials}  # fmt: skip
    controls = [
        choice(name, f"pages-mismatch-asked.{name}", of, getattr(question, name), EVERY)
        for name, of in values.items()
    ]
    names = "run day station unit validity verdict findings report"
    return dmc.Stack(
        [
            heading("pages-mismatch-review"),
            *review,
            heading("pages-mismatch-own"),
            dmc.SimpleGrid(controls, cols={"base": 2, "sm": 4}, spacing="xs"),
            note(counted),
            *(_effect_card(each) for each in shown.effects),
            heading("pages-mismatch-runs"),
            table("pages-mismatch-column", names, [_run_row(run) for run in shown.newest]),
        ],
        gap="sm",
    )


def _review_parts(review: ReviewShown) -> list[Component]:
    asked = ", ".join(_asked(name, value) for name, value in review.asked.items())
    days = f"{review.days[0]} … {review.days[1]}" if review.days else None
    about = facts(
        {
            "pages-mismatch-fact.at": second_of(review.at),
            "pages-mismatch-fact.asked": asked or said(EVERY),
            "pages-mismatch-fact.runs": f"{review.runs} (+ {review.skipped})",
            "pages-mismatch-fact.days": days,
        },
    )
    state = _state(review.verdict)
    summary = dmc.Group([badge(state), dmc.Text(say(review.statement))])
    carriers: dict[tuple[str, str], list[Carried]] = {}
    for each in review.findings:
        carriers.setdefault((each.finding.level, each.finding.carrier), []).append(each)
    return [about, summary, *(_carrier(of) for of in carriers.values())]


def _asked(name: str, value: str) -> str:
    """A part of what a review was asked of, in words."""
    if name == "paths":
        return said("pages-mismatch-recordings", count=int(value))
    kind = "fact" if name in ("since", "until") else "asked"
    return f"{said(f'pages-mismatch-{kind}.{name}')} {value}"


def _state(verdict: Verdict) -> StepState:
    """A mismatch is never good, explained or not: a named cause is a reason to act."""
    words = message(f"pages-mismatch-verdict.{verdict.replace('_', '-')}")
    return StepState(words, "good" if verdict == "no_mismatch" else "bad")


def _carrier(of: Sequence[Carried]) -> Component:
    """A station, unit, model, lot or site once, with everything that was found of it."""
    finding = of[0].finding
    name = said(f"pages-mismatch-level.{finding.level}") + f" {finding.carrier}"
    parts = [part for each in of for part in _carried_parts(each)]
    head = dmc.Title(name, order=4)
    return dmc.Card(dmc.Stack([head, *parts], gap="xs"), withBorder=True, className="carried")


def _carried_parts(carried: Carried) -> list[Component]:
    """An effect: since when, in how many runs, how large and how clear; what to do about it, and
    what it touches.
    """
    finding = carried.finding
    evidence = finding.evidence
    sizes = dmc.Stack([dmc.Text(_parameter(p)) for p in finding.parameters], gap=0)
    shown = facts(
        {
            "pages-mismatch-fact.since": _moment(finding.since),
            "pages-mismatch-fact.until": _moment(finding.until),
            "pages-mismatch-fact.shown": f"{evidence.runs_that_show_it} / {evidence.runs}",
            "pages-mismatch-fact.sizes": sizes,
            "pages-mismatch-fact.clear": said(
                "pages-mismatch-clear", z=plain(evidence.per_run_z_median, 2)
            ),
        },
    )
    parts = [dmc.Text(say(carried.title), fw="bold"), shown, _to_do(finding)]
    parts += _touched(carried.papers, carried.query)
    parts += [_uncertain_line(each) for each in carried.uncertain]
    return parts + _moved_parts(carried.moved)


def _to_do(finding: ReviewFinding) -> Component:
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
    texts = [dmc.Text(f"→ {say(each)}") for each in steps]
    order = dcc.Link(said("pages-action.acquire"), href="/do", className="button")
    return dmc.Stack([*texts, dmc.Group(order)], gap=4)


def _moment(moment: Moment | None) -> str | None:
    """The day, and the days between which the change lies with 95 %."""
    if moment is None:
        return None
    at, earliest, latest, without = map(
        day_in, (moment.at, moment.earliest, moment.latest, moment.without)
    )
    if not without:
        return f"{at} (95 %: {earliest} … {latest})"
    low, high = (without, latest) if without < earliest else (earliest, without)
    return said("pages-mismatch-between", at=at, low=low, high=high)


def _uncertain_line(time: UncertainTime) -> Component:
    counted = said(
        "pages-mismatch-uncertain", issued=time.papers.issued, since=time.query["since"],
        until=time.query["until"],
    )  # fmt: skip
    return dmc.Group([dmc.Text(counted, size="sm"), _runs_link(time.query)])


def _moved_parts(papers: Sequence[PaperMoved]) -> list[Component]:
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
    about = said("pages-mismatch-moved", count=len(papers), listed=len(rows))
    return [
        dmc.Text(about, size="sm", fw="bold"),
        table("pages-mismatch-moved", "paper run elements", rows),
    ]


def _in_U(moved: Moved) -> str:
    """“B_ax −1.5 U”; a no-break space keeps them together."""
    return f"{symbol(moved.item, moved.element)} {multiple(moved.in_U)} U".replace(" ", "\u00a0")


def _parameter(parameter: FoundParameter) -> str:
    return say(parameter_text(parameter))


def _touched(papers: Papers | None, query: dict[str, str] | None) -> list[Component]:
    """The certificates that may be wrong, with the way to their runs."""
    if papers is None:
        return []
    counted = said("pages-mismatch-touched", issued=papers.issued, drafts=papers.drafts)
    parts: list[Component] = [dmc.Text(counted, size="sm", fw="bold")]
    parts += [_runs_link(query)] if query else []
    listed = [link(number, "/runs", certificate=number) for number in papers.numbers]
    listed += [dmc.Text("…")] if papers.issued > len(papers.numbers) else []
    return [dmc.Group(parts), dmc.Group(listed, gap="xs", className="small")]


def _runs_link(query: dict[str, str]) -> Component:
    return link(said("pages-mismatch-their-runs"), "/runs", **query)


def _effect_card(seen: EffectSeen) -> Component:
    carriers = {
        f"pages-mismatch-level.{level}": _shares(getattr(seen, f"by_{level}"), seen, field)
        for level, field in (("station", "station"), ("model", "model"), ("unit", "serial"))
    }
    days = f"{seen.since} … {seen.until}" if seen.since else None
    moved = ", ".join(map(_in_U, seen.moved))
    counted = said("pages-mismatch-in-runs", count=seen.runs)
    head = dmc.Group([
        dmc.Title(say(seen.title), order=4), dmc.Code(seen.effect),
        link(counted, "/mismatch", effect=seen.effect),
    ])  # fmt: skip
    shown = facts(
        {"pages-mismatch-fact.days": days, **carriers,
         "pages-mismatch-fact.moved": dmc.Text(moved, size="sm") if moved else None},
    )  # fmt: skip
    touched = _touched(seen.papers, None)
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


def _run_row(run: ExplainedRun) -> tuple[Cell, ...]:
    found = [
        dmc.Text(f"{say(f.title)} ({100 * f.share:.0f} %): " + ", ".join(
            _parameter(p) for p in f.parameters[:3]), size="sm")
        for f in run.findings
    ]  # fmt: skip
    report = html.A(
        said("pages-mismatch-report"),
        href=f"/explained/{run.run}.html",
        className="whole",
        target="_blank",
    )
    return (
        link(run.run, "/run", id=run.run),
        str(run.day) if run.day else None,
        run.station,
        f"{run.model} {run.serial}",
        badge(validity_state(run.validity)),
        badge(_state(run.verdict)),
        dmc.Stack(found, gap=2) if found else None,
        report,
    )


PAGE = Page("mismatch", DiscrepancyQuestion, DiscrepancyShown, data, layout)
