"""The list of runs with the state of each step, filtered and sorted by the database.

A run is joined with the outcome of the result made of it last with the standard's terms alone, the
certificate kept last, and the fault of its last re-processing where that failed. The tables that
neither condition nor order names are joined for the rows that are shown alone: each adds one row
or none to a run.
"""

from collections.abc import Collection, Sequence
from contextlib import suppress
from datetime import date, datetime, time, timedelta
from typing import Any, Literal

import sqlalchemy as sql
from sqlalchemy.sql import visitors

from schemas.base import Finite, Frozen, Unusable
from schemas.certificate import State
from schemas.text import RunVerdict
from schemas.tolerance import Verdict
from storage.catalogue import certificates, database, results, runs, tables
from storage.catalogue.database import cached_until_commit
from storage.catalogue.results import calibration_of
from storage.home import Home

# Completes what earlier versions stored with what the catalogue now keeps about it.

AT_ONCE = 50  # documents of results completed in one transaction


def complete_runs(home: Home) -> None:
    """Fills in station, procedure, day and measurement standards where they are not yet known.

    Reads the manifests of those runs, once. A run whose manifest cannot be read stays as it is.
    """
    unknown = tables.runs.c.station.is_(None)
    ids = {row.id for row in database.rows(home, sql.select(tables.runs.c.id).where(unknown))}
    if not ids:
        return
    register = certificates.register(home)
    for run in runs.all_runs(home):
        if run.id not in ids:
            continue
        try:
            manifest = runs.manifest(run, home)
            printed = [
                (entry.number, certificates.standards_of(certificates.record_of(entry, home)))
                for entry in register
                if entry.run == run.id
            ]
        except Unusable:
            continue
        used = [(runs.STANDARD_DOCUMENT, runs.equipment_of(manifest)), *printed]
        with database.changing(home) as connection:
            known = runs.provenance(manifest)
            connection.execute(
                sql.update(tables.runs).where(tables.runs.c.id == run.id).values(**known)
            )
            for document, standards in used:
                runs.add_equipment(connection, run.id, document, standards)


def complete_results(home: Home) -> None:
    """Adds the rows that summarise results (`summaries`) where they are missing.

    A document that cannot be read gets none.
    """
    result = tables.results.c.id
    known = sql.exists().where(tables.outcomes.c.result == result)
    waiting = [row.id for row in database.rows(home, sql.select(result).where(~known))]
    for start in range(0, len(waiting), AT_ONCE):
        some = result.in_(waiting[start : start + AT_ONCE])
        documents = database.rows(home, sql.select(tables.results).where(some))
        with database.changing(home) as connection:
            for row in documents:
                try:
                    results.add(connection, row.id, calibration_of(row), row.made_at)
                except Unusable:
                    continue


def complete_certificates(home: Home) -> None:
    """Adds the rows that summarise decisions (`summaries`) where they are missing.

    A certificate whose record cannot be read is left unchanged.
    """
    table = tables.certificates
    waiting = database.rows(home, sql.select(table.c.number).where(table.c.limits.is_(None)))
    for number in (row.number for row in waiting):
        with suppress(Unusable):
            decision = certificates.find(number, home).decision
            with database.changing(home) as connection:
                results.add_decision(connection, number, decision)
                counted = sql.update(table).where(table.c.number == number)
                connection.execute(counted.values(limits=len(decision.limits)))


ResultState = Literal["whole", "partial", "missing", "failed"]
Comparison = Literal[
    "contains", "not_contains", "begins", "ends", "equals", "not_equals", "blank", "not_blank",
    "less", "less_or_equal", "greater", "greater_or_equal", "between", "among",
]  # fmt: skip

RUN, UNIT, PAPER = tables.runs.c, tables.units.c, tables.certificates.c
MADE = tables.outcomes.c
DAY = timedelta(days=1)


class Condition(Frozen):
    """What a column must meet. `to`: the end of `between`; values: those of `among`.

    any_of, all_of: other conditions on the column, of which one or all must be met in its place.
    """

    column: str
    kind: Comparison = "equals"
    value: date | Finite | str | None = None
    to: date | Finite | None = None
    values: tuple[str | None, ...] = ()
    any_of: tuple["Condition", ...] = ()
    all_of: tuple["Condition", ...] = ()


class RunLine(Frozen):
    """A run with the state of its steps; null: that step was not taken.

    unit: the unit's number in the catalogue. result, method, made_at: the result made last;
    validity: its verdict on the run; missing: how many elements it could not determine. fault: why
    the last re-processing failed. result_state: partial where elements are missing, failed where
    there is a fault. certificate (a draft's key before its issue), state, verdict,
    due: of the certificate kept last.
    """

    id: str
    recording_id: str
    unit: int
    manufacturer: str
    model: str
    serial: str
    station: str | None
    procedure: str | None
    standard: str
    recorded_on: date | None
    imported_at: datetime
    seconds: float
    result: str | None
    method: str | None
    made_at: datetime | None
    validity: RunVerdict | None
    missing: int | None
    fault: str | None
    result_state: ResultState
    certificate: str | None
    state: State | None
    verdict: Verdict | None
    due: date | None


def _last(table: sql.Table, column: str, moment: str, **having: str) -> sql.ScalarSelect[Any]:
    """Of the rows of a run the last one that has these values."""
    row = table.alias().c
    which = (row.run == RUN.id, *(row[name] == value for name, value in having.items()))
    mine = sql.select(row[column]).where(*which).order_by(row[moment].desc())
    return mine.limit(1).scalar_subquery().correlate(tables.runs)


LAST_RESULT = _last(tables.outcomes, "result", "made_at", terms="")
LAST_CERTIFICATE = _last(tables.certificates, "number", "kept_at")
FAULT = _last(tables.reprocessed, "fault", "done_at")
COLUMNS: dict[str, sql.ColumnElement[Any]] = {
    **{name: RUN[name] for name in ("id", "recording_id", "station", "procedure", "standard")},
    **{name: RUN[name] for name in ("recorded_on", "imported_at", "seconds")},
    "unit": UNIT.id,
    **{name: UNIT[name] for name in ("manufacturer", "model", "serial")},
    **{name: MADE[name] for name in ("result", "method", "made_at", "missing")},
    "validity": MADE.verdict,
    "fault": FAULT,
    "result_state": sql.case(
        (FAULT.is_not(None), "failed"),
        (MADE.result.is_(None), "missing"),
        (sql.func.coalesce(MADE.missing, 1) > 0, "partial"),
        else_="whole",
    ),
    "certificate": PAPER.number,
    "state": PAPER.state,
    "verdict": PAPER.verdict,
    "due": PAPER.due,
}
LATER: dict[sql.Table, sql.ColumnElement[bool]] = {  # what a run may have, and which of them
    tables.outcomes: MADE.result == LAST_RESULT,
    tables.certificates: PAPER.number == LAST_CERTIFICATE,
}


def run_list(
    conditions: Sequence[Condition],
    order: Sequence[tuple[str, bool]],
    start: int,
    count: int,
    home: Home,
) -> tuple[int, list[RunLine]]:
    """How many runs meet all conditions, and `count` of them after the first `start`.

    order: columns and whether each is descending; then the run that was imported last comes first.
    Raises Unusable for a column that the list does not have.
    """
    total, found = _run_list(tuple(conditions), tuple(order), start, count, home)
    return total, list(found)


@cached_until_commit(64)
def _run_list(
    conditions: tuple[Condition, ...],
    order: tuple[tuple[str, bool], ...],
    start: int,
    count: int,
    home: Home,
) -> tuple[int, tuple[RunLine, ...]]:
    complete_runs(home)
    complete_results(home)
    met = sql.and_(sql.true(), *map(_met, conditions))
    named = {name for name, _ in order} | {each.column for each in conditions}
    of = sql.select(sql.func.count()).select_from(_joined(named)).where(met)
    counted = database.rows(home, of)
    sorting = [_column(name).desc() if down else _column(name) for name, down in order]
    newest = (*sorting, RUN.imported_at.desc(), RUN.id)
    chosen = sql.select(RUN.id).select_from(_joined(named)).where(met).order_by(*newest)
    rows = (
        sql.select(*(column.label(name) for name, column in COLUMNS.items()))
        .select_from(_joined(COLUMNS))
        .where(RUN.id.in_(chosen.offset(start).limit(count)))
        .order_by(*newest)
    )
    found = tuple(RunLine(**row._mapping) for row in database.rows(home, rows))
    return (counted[0][0] if counted else 0), found


def _joined(named: Collection[str]) -> sql.FromClause:
    """Runs with their units and with the tables of the columns that are named."""
    joined: sql.FromClause = tables.runs.join(tables.units)
    for table, is_last in LATER.items():
        if any(_reads(name, table) for name in named):
            joined = joined.outerjoin(table, is_last)
    return joined


def _reads(name: str, table: sql.Table) -> bool:
    """Whether a column of the list is one of the table, or is made of some."""
    parts = visitors.iterate(COLUMNS[name]) if name in COLUMNS else ()
    return any(getattr(part, "table", None) is table for part in parts)


def _column(name: str) -> sql.ColumnElement[Any]:
    if name not in COLUMNS:
        raise Unusable(f"runs have no column {name!r}; there are {', '.join(COLUMNS)}.")
    return COLUMNS[name]


def _met(condition: Condition) -> sql.ColumnElement[bool]:
    """A condition in SQL; texts are compared without regard to case."""
    column = _column(condition.column)
    if condition.any_of:
        return sql.or_(*map(_met, condition.any_of))
    if condition.all_of:
        return sql.and_(*map(_met, condition.all_of))
    if condition.kind == "among":
        known = column.in_([value for value in condition.values if value is not None])
        return sql.or_(known, column.is_(None)) if None in condition.values else known
    if condition.kind in ("blank", "not_blank"):
        return column.is_(None) if condition.kind == "blank" else column.is_not(None)
    return _compared(column, condition)


def _compared(column: sql.ColumnElement[Any], condition: Condition) -> sql.ColumnElement[bool]:
    if isinstance(condition.value, date):
        return _by_day(column, condition)
    if isinstance(condition.value, str):
        return _by_text(column, condition.kind, condition.value)
    return _by_number(column, condition)


def _by_text(column: sql.ColumnElement[Any], kind: str, text: str) -> sql.ColumnElement[bool]:
    folded, sought = sql.func.lower(column), text.lower()
    found = {
        "contains": folded.contains(sought, autoescape=True),
        "begins": folded.startswith(sought, autoescape=True),
        "ends": folded.endswith(sought, autoescape=True),
        "equals": folded == sought,
    }
    if kind == "not_contains":
        return sql.or_(column.is_(None), ~found["contains"])
    if kind == "not_equals":
        return sql.or_(column.is_(None), ~found["equals"])
    return _known(kind, found)


def _by_number(column: sql.ColumnElement[Any], condition: Condition) -> sql.ColumnElement[bool]:
    value, to = condition.value, condition.to
    comparisons = {
        "equals": column == value,
        "not_equals": column != value,
        "less": column < value,
        "less_or_equal": column <= value,
        "greater": column > value,
        "greater_or_equal": column >= value,
        "between": sql.and_(column >= value, column <= to) if to is not None else column >= value,
    }
    return _known(condition.kind, comparisons)


def _by_day(column: sql.ColumnElement[Any], condition: Condition) -> sql.ColumnElement[bool]:
    """Days as the catalogue keeps them; of a moment its day where this program runs."""
    first, last = condition.value, condition.to or condition.value
    assert isinstance(first, date)
    assert isinstance(last, date)
    lower, upper = _start_of(first, column), _start_of(first + DAY, column)
    comparisons = {
        "equals": sql.and_(column >= lower, column < upper),
        "not_equals": sql.or_(column < lower, column >= upper),
        "less": column < lower,
        "greater": column >= upper,
        "between": sql.and_(column >= lower, column < _start_of(last + DAY, column)),
    }
    return _known(condition.kind, comparisons)


def _start_of(day: date, column: sql.ColumnElement[Any]) -> Any:
    of_moments = isinstance(column.type, tables.Utc)
    return datetime.combine(day, time()).astimezone() if of_moments else day


def _known(kind: str, comparisons: dict[str, sql.ColumnElement[bool]]) -> sql.ColumnElement[bool]:
    if kind not in comparisons:
        raise Unusable(
            f"such a column cannot be compared by {kind!r}; use {', '.join(comparisons)}."
        )
    return comparisons[kind]
