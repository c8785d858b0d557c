"""Which runs, results and certificates used a measurement standard or a station."""

import sqlalchemy as sql

from schemas.base import Unusable
from schemas.history import AffectedCertificate, AffectedResult, AffectedRun, Impact
from schemas.orders import Selection
from storage.catalogue import certificates, database, tables
from storage.catalogue.lineage import named_by
from storage.catalogue.run_index import Run
from storage.catalogue.selection import select
from storage.home import Home


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
