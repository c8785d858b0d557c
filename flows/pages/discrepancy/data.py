"""Reads which effects appear on which station, unit and model, since when, and what they touch."""

from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import date, timedelta
from typing import Any

import sqlalchemy as sql
from pydantic import AwareDatetime, Field

from schemas.base import Finite, Frozen
from schemas.certificate import LIVE
from schemas.discrepancy import FoundParameter, Moved, Verdict
from schemas.review import ReviewFinding, Touched
from schemas.text import RunVerdict, Statement
from storage import run_statistics
from storage.catalogue import database, tables
from storage.catalogue.discrepancies import explained_runs
from storage.catalogue.run_states import complete_runs
from storage.catalogue.runs import stated_day
from storage.home import Home
from tasks.model.term import effect_name
from tasks.words import statement

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
        newest=tuple(_run(run) for run in reversed(chosen[-NEWEST:])),
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
    effect: str, own: Sequence[Explained], runs: Sequence[Explained],
    papers: Sequence[sql.Row[Any]],
) -> EffectSeen:  # fmt: skip
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
    of, shown = (Counter(tuple(run[f] or "" for f in fields) for run in each)
                 for each in (runs, own))  # fmt: skip
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


def _run(run: Explained) -> ExplainedRun:
    return ExplainedRun(
        run=run["run"], day=run["recorded_on"], station=run["station"] or "", model=run["model"],
        serial=run["serial"], validity=run["validity"], verdict=run["verdict"],
        findings=tuple(
            FoundShown(effect=f["effect"], title=f["brief"].title, share=f["share"],
                       parameters=f["brief"].parameters, others=f["brief"].others)
            for f in run["findings"]
        ),
    )  # fmt: skip
