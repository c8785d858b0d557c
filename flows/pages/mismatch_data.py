"""Which effects appear on which station, unit and model, since when, and what they touch."""

from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import date
from typing import Any

import sqlalchemy as sql

from schemas.certificate import LIVE
from schemas.pages.mismatch import (
    Carried,
    EffectSeen,
    ExplainedRun,
    FoundShown,
    MismatchQuestion,
    MismatchShown,
    Papers,
    ReviewShown,
    Shown,
)
from schemas.review import Moment, ReviewFinding
from storage import last_review
from storage.catalogue import database, tables
from storage.catalogue.completion import complete_runs
from storage.catalogue.explanations import explained_runs
from storage.home import Home
from tasks.model.effect import effect_name
from tasks.words import statement

NEWEST, LISTED, MOST_MOVED = 100, 12, 4
RUN, UNIT, PAPER = tables.runs.c, tables.units.c, tables.certificates.c
CARRIED_BY = {"station": "station", "unit": "serial", "model": "model"}  # fields of the run list
Explained = dict[str, Any]


def data(question: MismatchQuestion, home: Home) -> MismatchShown:
    """The last review, and the findings of the explained runs that are asked for."""
    complete_runs(home)
    every = explained_runs(home)
    chosen = [run for run in every if _is_asked(run, question)]
    counted = database.rows(home, sql.select(sql.func.count()).select_from(tables.runs))
    return MismatchShown(
        review=_review(home), runs=counted[0][0] if counted else 0, explained=len(chosen),
        effects=tuple(_effects(chosen, question, home)),
        newest=tuple(_run(run) for run in reversed(chosen[-NEWEST:])),
        stations=_names(every, "station"), models=_names(every, "model"),
        serials=_names(every, "serial"),
        known=tuple(sorted({found["effect"] for run in every for found in run["findings"]})),
    )  # fmt: skip


def _is_asked(run: Explained, question: MismatchQuestion) -> bool:
    asked = ((name, getattr(question, name)) for name in ("station", "model", "serial"))
    shown = {found["effect"] for found in run["findings"]}
    of_effect = question.effect is None or question.effect in shown
    return of_effect and all(wanted in (None, run[name]) for name, wanted in asked)


def _names(runs: Iterable[Explained], field: str) -> tuple[str, ...]:
    return tuple(sorted({run[field] for run in runs if run[field]}))


def _review(home: Home) -> ReviewShown | None:
    kept = last_review.last(home)
    if kept is None:
        return None
    review = kept.review
    return ReviewShown(
        at=kept.at, asked=kept.asked, days=kept.days, runs=review.runs,
        skipped=len(review.skipped), verdict=review.verdict, statement=review.statement,
        findings=tuple(_carried(finding, home) for finding in review.findings),
    )  # fmt: skip


def _carried(finding: ReviewFinding, home: Home) -> Carried:
    field, since, until = CARRIED_BY.get(finding.level), _day(finding.since), _day(finding.until)
    title = statement(effect_name(finding.effect))
    if field is None:
        return Carried(title=title, finding=finding, query=None, papers=None)
    model, _, serial = finding.carrier.rpartition(" ") if field == "serial" else ("", "", "")
    query = {field: serial or finding.carrier} | ({"model": model} if model else {})
    days = {name: str(day) for name, day in (("since", since), ("until", until)) if day}
    own = {"station": RUN.station, "serial": UNIT.serial, "model": UNIT.model}
    which = [own[name] == value for name, value in query.items()]
    which += [RUN.recorded_on >= since] if since else []
    which += [RUN.recorded_on <= until] if until else []
    return Carried(title=title, finding=finding, query=query | days,
                   papers=_papers(sql.and_(*which), home))  # fmt: skip


def _day(moment: Moment | None) -> date | None:
    """The day of a moment; None for one that is the name of a recording."""
    try:
        return date.fromisoformat(moment.at[:10]) if moment else None
    except ValueError:
        return None


def _papers(which: sql.ColumnElement[bool], home: Home) -> Papers:
    asked = (
        sql.select(PAPER.number, PAPER.state)
        .select_from(tables.certificates.join(tables.runs, RUN.id == PAPER.run))
        .join(tables.units, UNIT.id == RUN.unit)
        .where(which, PAPER.state.in_(LIVE))
        .order_by(PAPER.kept_at.desc())
    )
    rows = database.rows(home, asked)
    issued = [row.number for row in rows if row.state == "issued"]
    return Papers(
        issued=len(issued), drafts=len(rows) - len(issued), numbers=tuple(issued[:LISTED])
    )


def _effects(
    runs: Sequence[Explained], question: MismatchQuestion, home: Home
) -> Iterable[EffectSeen]:
    """Each effect that the runs show, that of the most runs first."""
    with_effect: dict[str, list[Explained]] = {}
    for run in runs:
        for effect in dict.fromkeys(found["effect"] for found in run["findings"]):
            with_effect.setdefault(effect, []).append(run)
    for effect, own in sorted(with_effect.items(), key=lambda each: (-len(each[1]), each[0])):
        if question.effect in (None, effect):
            yield _effect(effect, own, runs, home)


def _effect(
    effect: str, own: Sequence[Explained], runs: Sequence[Explained], home: Home
) -> EffectSeen:
    briefs = [f["brief"] for run in own for f in run["findings"] if f["effect"] == effect]
    most = max(briefs, key=lambda brief: max((abs(m.in_U) for m in brief.moved), default=0.0))
    days = [run["recorded_on"] for run in own if run["recorded_on"]]
    ids = [run["run"] for run in own]
    return EffectSeen(
        effect=effect, title=briefs[-1].title, runs=len(own), since=min(days, default=None),
        until=max(days, default=None), by_station=_by("station", own, runs),
        by_model=_by("model", own, runs), by_unit=_by("serial", own, runs),
        moved=most.moved[:MOST_MOVED], papers=_papers(RUN.id.in_(ids), home),
    )  # fmt: skip


def _by(field: str, own: Sequence[Explained], runs: Sequence[Explained]) -> tuple[Shown, ...]:
    """Those that show it, the largest share first."""
    of, shown = (Counter(run[field] or "" for run in each) for each in (runs, own))
    first: dict[str, date] = {}
    for run in own:
        if run["recorded_on"]:
            first.setdefault(run[field] or "", run["recorded_on"])
    found = [
        Shown(name=name, shown=count, of=of[name], since=first.get(name))
        for name, count in shown.items()
    ]
    return tuple(sorted(found, key=lambda each: (-each.shown / each.of, -each.shown, each.name)))


def _run(run: Explained) -> ExplainedRun:
    return ExplainedRun(
        run=run["run"], day=run["recorded_on"], station=run["station"] or "", model=run["model"],
        serial=run["serial"], verdict=run["verdict"],
        findings=tuple(
            FoundShown(effect=f["effect"], title=f["brief"].title, share=f["share"],
                       parameters=f["brief"].parameters, others=f["brief"].others)
            for f in run["findings"]
        ),
    )  # fmt: skip
