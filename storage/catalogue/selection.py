"""Selects runs by what the catalogue knows about them."""

from datetime import UTC, datetime, time, timedelta

import sqlalchemy as sql

from schemas.base import Unusable
from schemas.history import AffectedCertificate, AffectedResult, AffectedRun, Impact
from schemas.orders import Selection
from storage.catalogue import certificates, database, tables
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


def impact_of(selection: Selection, home: Home) -> Impact:
    """Everything that depends on the runs of a selection by equipment.

    Raises Unusable for equipment that no run in the store used: it may be misspelt.
    """
    equipment = selection.equipment or ""
    runs = select(selection, home)
    if not runs and not select(Selection(equipment=equipment), home):
        raise Unusable(f"no run in {home.path} used {equipment!r}; {_known(home)}")
    ids, documents = {run.id for run in runs}, _documents(equipment, home)
    return Impact(
        equipment=equipment,
        since=selection.since,
        until=selection.until,
        runs=tuple(_run(run, documents.get(run.id, ())) for run in runs),
        results=tuple(each for each in _results(home) if each.run in ids),
        certificates=tuple(_certificates(runs, home)),
    )


def _run(run: Run, documents: tuple[str, ...]) -> AffectedRun:
    return AffectedRun(
        run=run.id,
        recording_id=run.recording_id,
        unit=f"{run.manufacturer} {run.model} {run.serial}",
        station=run.station,
        recorded_on=run.recorded_on,
        documents=documents,
    )


def _certificates(runs: list[Run], home: Home) -> list[AffectedCertificate]:
    """Certificates of one of the runs, and those that print one as found."""
    ids = {run.id for run in runs}
    units = {(run.manufacturer, run.model, run.serial) for run in runs}
    fields = set(AffectedCertificate.model_fields)
    return [
        AffectedCertificate.model_validate(entry.model_dump(include=fields))
        for entry in certificates.register(home)
        if (entry.manufacturer, entry.model, entry.serial) in units
        and (entry.run in ids or certificates.found_of(entry, home) in ids)
    ]


def _documents(equipment: str, home: Home) -> dict[str, tuple[str, ...]]:
    """The documents that name the equipment, by run."""
    used, found = tables.equipment.c, dict[str, tuple[str, ...]]()
    asked = sql.select(used.run, used.document).where(named_by(equipment)).distinct()
    for row in database.rows(home, asked.order_by(used.document)):
        found[row.run] = (*found.get(row.run, ()), row.document)
    return found


def _results(home: Home) -> list[AffectedResult]:
    table = tables.results.c
    newest = database.newest_results().label("newest")
    asked = sql.select(table.id.label("result"), table.run, table.method, newest)
    rows = database.rows(home, asked.order_by(table.made_at, table.id))
    return [AffectedResult.model_validate(row, from_attributes=True) for row in rows]


def _known(home: Home) -> str:
    """What could have been meant."""
    used = tables.equipment.c
    rows = database.rows(home, sql.select(used.name, used.serial).distinct().limit(8))
    if not rows:
        return "no run or certificate there names a measurement standard"
    return "known are " + ", ".join(f"{row.name} ({row.serial})" for row in rows)
