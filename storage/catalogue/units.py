"""The units of the catalogue, each with everything that its calibrations found."""

from datetime import date
from typing import Any

import sqlalchemy as sql

from schemas.base import Frozen, Unusable
from schemas.decision import Verdict
from schemas.text import Message
from storage.catalogue import certificates, database, tables
from storage.catalogue.completion import complete_certificates, complete_results, complete_runs
from storage.catalogue.run_states import LAST_CERTIFICATE, LAST_RESULT
from storage.home import Home

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
    return {} if row is None else {
        "certificate": row.number, "verdict": row.verdict, "due": row.due
    }  # fmt: skip


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
