"""Where a run was recorded and with which measurement standards, as the catalogue keeps it.

The measurement standards of a run are those that its manifest names, and those of the laboratory
on each certificate that stands on the run.
"""

from collections.abc import Iterable, Mapping
from datetime import date, datetime
from typing import TYPE_CHECKING, Any

import sqlalchemy as sql

from schemas.base import Frozen
from storage.catalogue import database, tables

if TYPE_CHECKING:
    from schemas.recording import Manifest

MANIFEST = "manifest"  # the document that names a standard; else the number of a certificate


class Used(Frozen):
    """A measurement standard, and the calibration certificate under which a run used it."""

    name: str
    serial: str
    certificate: str


def provenance(manifest: "Manifest") -> dict[str, Any]:
    """station, procedure and recorded_on of a manifest; None where it states none.

    The day is that of the station's own clock (`recorded_at`), else of the first row
    (`acquired_at` of mimu-recording/1).
    """
    free = manifest.model_extra or {}
    procedure = free.get("procedure")
    return {
        "station": manifest.station.id,
        "procedure": procedure if isinstance(procedure, str) else None,
        "recorded_on": stated_day(free.get("recorded_at")) or stated_day(free.get("acquired_at")),
    }


def equipment_of(manifest: "Manifest") -> list[Used]:
    """The measurement standards of a manifest; incomplete entries are left out."""
    listed = (manifest.model_extra or {}).get("equipment")
    records = listed if isinstance(listed, list | tuple) else ()
    named = [each for each in records if isinstance(each, Mapping)]
    return [
        Used(**{name: str(each.get(name) or "") for name in Used.model_fields}) for each in named
    ]


def add_equipment(
    connection: sql.Connection, run: str, document: str, used: Iterable[Used]
) -> None:
    """Records the measurement standards that a document names for a run."""
    for each in used:
        row = {"run": run, "document": document, **each.model_dump()}
        database.add_new(connection, tables.equipment, **row)


def named_by(name: str) -> sql.ColumnElement[bool]:
    """The condition on `equipment` that a name, serial number or certificate is the given one."""
    used = tables.equipment.c
    return sql.or_(used.name == name, used.serial == name, used.certificate == name)


def stated_day(moment: object) -> date | None:
    """The day of a moment in ISO 8601, in the time zone of that text; None where it is none."""
    try:
        return datetime.fromisoformat(moment).date() if isinstance(moment, str) else None
    except ValueError:
        return None
