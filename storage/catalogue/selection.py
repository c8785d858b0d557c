"""Selects runs by what the catalogue knows about them."""

from collections.abc import Sequence
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

MAX_SUGGESTIONS = 8  # of what could have been meant


def select(selection: Selection, home: Home) -> list[Run]:
    """The runs of a selection in the order of import; all of them for an empty one."""
    complete_runs(home)
    return runs_where(home, sql.and_(sql.true(), *_conditions(selection)))


def check_known(selection: Selection, home: Home) -> None:
    """Raises Unusable for a name of the selection that no run in the store has: it is misspelt."""
    runs, units = tables.runs.c, tables.units.c
    columns = {
        "station": (runs.station,), "model": (units.model,), "serial": (units.serial,),
        "procedure": (runs.procedure, runs.standard),
    }  # fmt: skip
    for name in (*columns, "equipment"):
        value = getattr(selection, name)
        if value is None or select(Selection.model_validate({name: value}), home):
            continue
        known = _known(home) if name == "equipment" else _values(columns[name], home)
        raise Unusable(f"--{name} {value}: no run in {home.path} has it; {known}")


def _values(columns: Sequence[sql.ColumnElement[str | None]], home: Home) -> str:
    """What the columns hold, as what could have been meant."""
    joined = tables.runs.join(tables.units)
    found = {
        value
        for column in columns
        for (value,) in database.rows(home, sql.select(column).select_from(joined).distinct())
        if value
    }
    shown = sorted(found)[:MAX_SUGGESTIONS]
    if not shown:
        return "`mimucal runs` lists what is there"
    return "known are " + ", ".join(shown) + (", …" if len(found) > len(shown) else "")


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
        found.append(_recorded(runs.recorded_on >= selection.since, runs.imported_at >= begins))
    if selection.until is not None:
        ends = datetime.combine(selection.until + timedelta(days=1), time(), UTC)
        found.append(_recorded(runs.recorded_on <= selection.until, runs.imported_at < ends))
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
    undated = _of_unknown_day(selection, runs, home)
    ids, documents = {run.id for run in runs}, _documents(equipment, home)
    return Impact(
        equipment=equipment,
        since=selection.since,
        until=selection.until,
        runs=tuple(_run(run, documents.get(run.id, ())) for run in runs),
        results=tuple(each for each in _results(home) if each.run in ids),
        certificates=tuple(_certificates(runs, home)),
        undated=tuple(run.id for run in undated),
    )


def _of_unknown_day(selection: Selection, chosen: list[Run], home: Home) -> list[Run]:
    """Runs that the days left out by the day of their import: they may have been recorded then."""
    whenever = selection.model_copy(update={"since": None, "until": None})
    ids = {run.id for run in chosen}
    every = select(whenever, home) if selection.since or selection.until else []
    return [run for run in every if run.recorded_on is None and run.id not in ids]


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
    rows = database.rows(home, sql.select(used.name, used.serial).distinct().limit(MAX_SUGGESTIONS))
    if not rows:
        return "no run or certificate there names a measurement standard"
    return "known are " + ", ".join(f"{row.name} ({row.serial})" for row in rows)
