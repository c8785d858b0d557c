"""Selects runs by what the catalogue knows about them."""

from collections.abc import Sequence
from datetime import UTC, date, datetime, time, timedelta
from typing import Any

import sqlalchemy as sql

from schemas.base import Frozen, Unusable
from schemas.history import AffectedCertificate, AffectedResult, AffectedRun, Impact
from schemas.orders import Selection
from schemas.text import Message
from schemas.tolerance import Verdict
from storage.catalogue import certificates, database, tables
from storage.catalogue.run_states import (
    LAST_CERTIFICATE,
    LAST_RESULT,
    complete_certificates,
    complete_results,
    complete_runs,
)
from storage.catalogue.runs import Run, named_by, runs_where
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
    used = tables.equipment.c
    rows = database.rows(home, sql.select(used.name, used.serial).distinct().limit(MAX_SUGGESTIONS))
    if not rows:
        return "no run or certificate there names a measurement standard"
    return "known are " + ", ".join(f"{row.name} ({row.serial})" for row in rows)


# The units of the catalogue, each with everything that its calibrations found.

RUN, UNIT, MADE = tables.runs.c, tables.units.c, tables.outcomes.c
PAPER, DECIDED, ELEMENT = tables.certificates.c, tables.decisions.c, tables.elements.c
Rows = list[tuple[Any, ...]]  # in the order of the fields that are named


class UnitLine(Frozen):
    """A unit with its runs; certificate, verdict, due: of its newest issued certificate."""

    id: int
    manufacturer: str
    model: str
    serial: str
    runs: int
    last_run: date | None
    certificate: str | None = None
    verdict: Verdict | None = None
    due: date | None = None


def unit_list(search: str, count: int, home: Home) -> tuple[int, list[UnitLine]]:
    """How many units have all words of a search in maker, model and serial number, and the first
    `count` of them; each with its runs and the issued certificate that counts.
    """
    named = UNIT.manufacturer + " " + UNIT.model + " " + UNIT.serial
    met = [named.icontains(word, autoescape=True) for word in search.split()]
    return _lines(sql.and_(sql.true(), *met), count, home)


def unit_line(unit: int, home: Home) -> UnitLine:
    """One unit by its number in the catalogue; raises Unusable where there is none."""
    _, found = _lines(UNIT.id == unit, 1, home)
    if not found:
        raise Unusable(
            f"There is no unit {unit} in {home.path}; the list of units has them all.",
            Message("cause-none.unit", (("name", str(unit)),)),
        )
    return found[0]


def _lines(met: sql.ColumnElement[bool], count: int, home: Home) -> tuple[int, list[UnitLine]]:
    complete_runs(home)
    counted = database.rows(home, sql.select(sql.func.count()).select_from(tables.units).where(met))
    asked = (
        sql.select(
            UNIT.id, UNIT.manufacturer, UNIT.model, UNIT.serial,
            sql.func.count(RUN.id).label("runs"), sql.func.max(RUN.recorded_on).label("last_run"),
        )
        .select_from(tables.units.outerjoin(tables.runs))
        .where(met)
        .group_by(UNIT.id, UNIT.manufacturer, UNIT.model, UNIT.serial)
        .order_by(UNIT.manufacturer, UNIT.model, UNIT.serial)
        .limit(count)
    )  # fmt: skip
    found = database.rows(home, asked)
    valid = certificates.newest_issued(home, PAPER.unit.in_([row.id for row in found]))
    lines = [
        UnitLine.model_validate(dict(row._mapping) | _paper(valid.get(row.id))) for row in found
    ]
    return (counted[0][0] if counted else 0), lines


def _paper(row: sql.Row[Any] | None) -> dict[str, Any]:
    return (
        {} if row is None else {"certificate": row.number, "verdict": row.verdict, "due": row.due}
    )


def runs_of(unit: int, home: Home) -> Rows:
    """Each run of a unit in the order of time: id, day, station, validity (null: no result) and
    purpose of its certificate (null: none), by the result made last and the certificate kept last.
    """
    complete_runs(home)
    complete_results(home)
    joined = tables.runs.outerjoin(tables.outcomes, MADE.result == LAST_RESULT).outerjoin(
        tables.certificates, PAPER.number == LAST_CERTIFICATE
    )
    asked = sql.select(
        RUN.id, RUN.recorded_on, RUN.imported_at, RUN.station, MADE.verdict, PAPER.purpose
    ).select_from(joined).where(RUN.unit == unit).order_by(RUN.imported_at, RUN.id)  # fmt: skip
    rows = [
        (row.id, row.recorded_on or row.imported_at.date(), *row[3:])
        for row in database.rows(home, asked)
    ]
    return sorted(rows, key=_day)


def _day(row: tuple[Any, ...]) -> date:
    day: date = row[1]
    return day


def readings_of(unit: int, home: Home) -> Rows:
    """run, item, element, value, u, expanded, k and unit of each element of each of its runs."""
    joined = tables.runs.join(tables.outcomes, MADE.result == LAST_RESULT).join(
        tables.elements, ELEMENT.result == MADE.result
    )
    columns = (ELEMENT.item, ELEMENT.element, ELEMENT.value, ELEMENT.u, ELEMENT.expanded,
               ELEMENT.k, ELEMENT.unit)  # fmt: skip
    asked = sql.select(RUN.id, *columns).select_from(joined).where(RUN.unit == unit)
    return [tuple(row) for row in database.rows(home, asked)]


def limits_of(certificate: str, home: Home) -> dict[tuple[str, str], tuple[Any, Any]]:
    """Lower and upper limit on the value of each element that a certificate decides on."""
    complete_certificates(home)
    asked = sql.select(DECIDED.item, DECIDED.element, DECIDED.lower, DECIDED.upper).where(
        DECIDED.certificate == certificate, DECIDED.applied_to == "value"
    )
    return {(row.item, row.element): (row.lower, row.upper) for row in database.rows(home, asked)}
