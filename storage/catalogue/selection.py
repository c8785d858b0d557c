"""Selects runs by what the catalogue knows about them."""

from datetime import UTC, datetime, time, timedelta

import sqlalchemy as sql

from schemas.orders import Selection
from storage.catalogue import database, tables
from storage.catalogue.completion import complete_runs
from storage.catalogue.lineage import named_by
from storage.catalogue.run_index import Run, runs_where
from storage.home import Home


def select(selection: Selection, home: Home) -> list[Run]:
    """The runs of a selection in the order of import; all of them for an empty one."""
    complete_runs(home)
    return runs_where(home, sql.and_(sql.true(), *_conditions(selection)))


def _conditions(selection: Selection) -> list[sql.ColumnElement[bool]]:
    runs, units = tables.runs.c, tables.units.c
    equal = (
        (units.model, selection.model),
        (units.serial, selection.serial),
        (runs.station, selection.station),
    )
    found = [column == value for column, value in equal if value is not None]
    if selection.procedure is not None:
        named = selection.procedure
        found.append(sql.or_(runs.procedure == named, runs.standard == named))
    if selection.since is not None:
        begins = datetime.combine(selection.since, time(), UTC)
        found.append(_recorded(runs.recorded_on >= selection.since, runs.taken_in_at >= begins))
    if selection.until is not None:
        ends = datetime.combine(selection.until + timedelta(days=1), time(), UTC)
        found.append(_recorded(runs.recorded_on <= selection.until, runs.taken_in_at < ends))
    if selection.equipment is not None:
        found.append(_used(selection.equipment))
    if selection.code_version is not None:
        found.append(runs.id.in_(_made_by(selection.code_version)))
    return found


def _recorded(
    by_day: sql.ColumnElement[bool], by_import: sql.ColumnElement[bool]
) -> sql.ColumnElement[bool]:
    """By the day of the recording; by that of the import where the manifest gives none."""
    unknown = tables.runs.c.recorded_on.is_(None)
    return sql.or_(by_day, sql.and_(unknown, by_import))


def _used(named: str) -> sql.ColumnElement[bool]:
    runs, used = tables.runs.c, tables.equipment.c.run
    return sql.or_(runs.station == named, runs.id.in_(sql.select(used).where(named_by(named))))


def _made_by(code_version: str) -> sql.Select[tuple[str]]:
    table = tables.results.c
    begins = table.code_version.startswith(code_version, autoescape=True)
    return sql.select(table.run).where(begins, database.newest_results())
