"""Completes what earlier versions stored with what the catalogue now keeps about it."""

from contextlib import suppress

import sqlalchemy as sql

from schemas.base import Unusable
from storage.catalogue import certificates, database, lineage, result_rows, run_index, runs, tables
from storage.catalogue.results import calibration_of
from storage.formats.manifest import manifest_of
from storage.home import Home

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
    for run in run_index.all_runs(home):
        if run.id not in ids:
            continue
        try:
            kept = runs.manifest_bytes(run, home)
            manifest = manifest_of(kept, run.id) if kept else runs.load(run, home).manifest
            printed = [
                (entry.number, certificates.standards_of(certificates.record_of(entry, home)))
                for entry in register
                if entry.run == run.id
            ]
        except Unusable:
            continue
        used = [(lineage.MANIFEST, lineage.equipment_of(manifest)), *printed]
        with database.changing(home) as connection:
            known = lineage.provenance(manifest)
            connection.execute(
                sql.update(tables.runs).where(tables.runs.c.id == run.id).values(**known)
            )
            for document, standards in used:
                lineage.add_equipment(connection, run.id, document, standards)


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
                    result_rows.add(connection, row.id, calibration_of(row), row.made_at)
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
                result_rows.add_decision(connection, number, decision)
                counted = sql.update(table).where(table.c.number == number)
                connection.execute(counted.values(limits=len(decision.limits)))
