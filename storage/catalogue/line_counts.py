"""Counts of what the catalogue holds, for monitoring, by a few short queries."""

from dataclasses import dataclass
from datetime import datetime

import sqlalchemy as sql

from storage.catalogue import database, tables
from storage.home import Home

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
