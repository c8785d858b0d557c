"""Many runs at once, from the catalogue: outcomes, values, limits, renewals, and their counts."""

from dataclasses import dataclass
from datetime import date, datetime
from typing import Any

import sqlalchemy as sql

from schemas.text import Statement
from storage.catalogue import database, tables
from storage.catalogue.certificates import reasons_in
from storage.catalogue.database import cached_until_commit
from storage.catalogue.run_states import (
    LAST_CERTIFICATE,
    LAST_RESULT,
    complete_certificates,
    complete_results,
    complete_runs,
)
from storage.home import Home

# Outcomes, values, limits and renewals of many runs at once, from the catalogue.
#
# Of a run count the result made last with the standard's terms alone and the certificate kept
# last, as in `run_list`.

RUN, UNIT, MADE = tables.runs.c, tables.units.c, tables.outcomes.c
PAPER, DECIDED, ELEMENT = tables.certificates.c, tables.decisions.c, tables.elements.c
Rows = list[tuple[Any, ...]]  # in the order of the fields that are named


def ended(home: Home) -> Rows:
    """Every run in the order of import: id, unit, model, serial, station, recorded_on, imported_at
    (where nothing says when it was recorded), validity (null: no result), missing, verdict (null:
    no certificate) and purpose.
    """
    complete_runs(home)
    complete_results(home)
    joined = (
        tables.runs.join(tables.units)
        .outerjoin(tables.outcomes, MADE.result == LAST_RESULT)
        .outerjoin(tables.certificates, PAPER.number == LAST_CERTIFICATE)
    )
    asked = sql.select(
        RUN.id, RUN.unit, UNIT.model, UNIT.serial, RUN.station, RUN.recorded_on,
        sql.case((RUN.recorded_on.is_(None), RUN.imported_at)).label("imported_at"),
        MADE.verdict.label("validity"), MADE.missing,
        PAPER.verdict, PAPER.purpose,
    ).select_from(joined)  # fmt: skip
    return _plain(home, asked.order_by(RUN.imported_at, RUN.id))


def values(model: str, item: str, element: str, home: Home) -> Rows:
    """run, value and expanded of an element in the runs of a model."""
    joined = tables.runs.join(tables.units).join(tables.outcomes, MADE.result == LAST_RESULT)
    of_element = (ELEMENT.result == MADE.result, ELEMENT.item == item, ELEMENT.element == element)
    asked = (
        sql.select(RUN.id.label("run"), ELEMENT.value, ELEMENT.expanded)
        .select_from(joined.join(tables.elements, sql.and_(*of_element)))
        .where(UNIT.model == model)
    )
    return _plain(home, asked)


def items(model: str, home: Home) -> Rows:
    """item, element and unit, in the order of the result of a model that was made last."""
    newest = (
        sql.select(MADE.result)
        .select_from(tables.outcomes.join(tables.runs).join(tables.units))
        .where(UNIT.model == model, MADE.terms == "")
        .order_by(MADE.made_at.desc(), MADE.result)
        .limit(1)
        .scalar_subquery()
    )
    asked = sql.select(ELEMENT.item, ELEMENT.element, ELEMENT.unit)
    return _plain(home, asked.where(ELEMENT.result == newest))


@cached_until_commit(8)
def decided_items(model: str, home: Home) -> Rows:
    """run, item, and in how many of its elements the run's certificate does not pass it."""
    complete_certificates(home)
    not_passed = sql.func.sum(sql.case((DECIDED.verdict == "pass", 0), else_=1))
    asked = (
        sql.select(PAPER.run, DECIDED.item, not_passed.label("not_passed"))
        .select_from(_papers().join(tables.decisions, DECIDED.certificate == PAPER.number))
        .where(UNIT.model == model)
        .group_by(PAPER.run, DECIDED.item)
    )
    return _plain(home, asked)


@cached_until_commit(8)
def not_passed(model: str, home: Home) -> Rows:
    """run, item, element and verdict of each limit that a run's certificate does not pass."""
    complete_certificates(home)
    asked = (
        sql.select(PAPER.run, DECIDED.item, DECIDED.element, DECIDED.verdict)
        .select_from(_papers().join(tables.decisions, DECIDED.certificate == PAPER.number))
        .where(UNIT.model == model, DECIDED.verdict != "pass")
        .order_by(PAPER.run, DECIDED.number)
    )
    return _plain(home, asked)


@cached_until_commit(8)
def reasons(model: str, home: Home) -> list[tuple[str, Statement]]:
    """run and reason, for each reason why a run's certificate decides on nothing.

    They stand in the record alone, which is read of the certificates that do not decide.
    """
    asked = (
        sql.select(PAPER.run, PAPER.record)
        .select_from(_papers())
        .where(UNIT.model == model, PAPER.verdict == "inconclusive")
        .order_by(PAPER.kept_at)
    )
    return [(row.run, reason) for row in database.rows(home, asked)
            for reason in reasons_in(row.record, home)]  # fmt: skip


def limits(model: str, item: str, element: str, home: Home) -> Rows:
    """run, lower and upper that certificates put on the value of an element, the newest last."""
    of_element = (DECIDED.item == item, DECIDED.element == element, DECIDED.applied_to == "value")
    asked = (
        sql.select(PAPER.run, DECIDED.lower, DECIDED.upper)
        .select_from(_papers().join(tables.decisions, DECIDED.certificate == PAPER.number))
        .where(UNIT.model == model, *of_element)
        .order_by(PAPER.kept_at)
    )
    return _plain(home, asked)


def renewals(station: str, home: Home) -> list[tuple[date, str]]:
    """When each standard that was used at a station was calibrated, with its serial number."""
    used, standard = tables.equipment.c, tables.standards.c
    there = (
        sql.select(used.serial)
        .join_from(tables.equipment, tables.runs)
        .where(RUN.station == station, used.serial != "")
        .distinct()
    )
    asked = sql.select(standard.calibrated_on, standard.serial).where(
        standard.serial.in_(there), standard.calibrated_on.is_not(None)
    )
    return [(row.calibrated_on, row.serial) for row in database.rows(home, asked)]


def _plain(home: Home, asked: sql.Select[Any]) -> Rows:
    return [tuple(row) for row in database.rows(home, asked)]


def _papers() -> sql.FromClause:
    """Runs with their units and the certificate kept last."""
    joined = tables.runs.join(tables.units)
    return joined.join(tables.certificates, PAPER.number == LAST_CERTIFICATE)


# Counts of what the catalogue holds, for monitoring, by a few short queries.

Counted = dict[tuple[str, ...], int]


@dataclass(frozen=True)
class LineCounts:
    """Runs by the verdict on the run, certificates by state, orders that wait by station.

    reminders_failed: those whose last try failed. last_run_at: when the newest was imported.
    """

    runs: Counted
    certificates: Counted
    orders_waiting: Counted
    reminders_failed: int
    last_run_at: datetime | None


def line_counts(home: Home) -> LineCounts:
    """Counts; raises Unusable for a catalogue that cannot be read."""
    outcome, paper, reminder = tables.outcomes.c, tables.certificates.c, tables.reminders.c
    newest = sql.select(outcome.verdict, sql.func.count(sql.distinct(outcome.run)))
    newest = newest.join_from(
        tables.outcomes, tables.results, tables.results.c.id == outcome.result
    )
    failed = sql.select(sql.func.count()).where(
        reminder.sent_at.is_(None), reminder.fault.isnot(None)
    )
    last = database.rows(home, sql.select(sql.func.max(tables.runs.c.imported_at)))
    return LineCounts(
        runs=_counted(home, newest.where(database.newest_results()).group_by(outcome.verdict)),
        certificates=_counted(
            home, sql.select(paper.state, sql.func.count()).group_by(paper.state)
        ),
        orders_waiting=_orders(home),
        reminders_failed=sum(row[0] for row in database.rows(home, failed)),
        last_run_at=last[0][0] if last else None,
    )


def _orders(home: Home) -> Counted:
    orders = tables.metadata.tables.get("orders")
    if orders is None:
        return {}
    waiting = sql.select(orders.c.station, sql.func.count()).where(orders.c.state == "waiting")
    return _counted(home, waiting.group_by(orders.c.station))


def _counted(home: Home, asked: sql.Select[tuple[str, int]]) -> Counted:
    return {tuple(row[:-1]): row[-1] for row in database.rows(home, asked)}
