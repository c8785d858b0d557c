"""The runs in the catalogue: listed, and found by what a person calls them.

Apart from `runs`, which reads and writes recordings and loads numpy and their formats for it.
"""

import os
from datetime import date, datetime

import sqlalchemy as sql

from schemas.base import Frozen, Unusable
from schemas.text import Message
from storage.catalogue import database, tables
from storage.home import Home


class Run(Frozen):
    """A recording in the store. `seconds`: from its first row to its last one.

    station, procedure and recorded_on are what the manifest says; null where it says nothing, and
    until `lineage.complete` for a run of an earlier version.
    """

    id: str
    digest: str
    recording_id: str
    manufacturer: str
    model: str
    serial: str
    standard: str
    imported_at: datetime
    seconds: float
    rows: int
    station: str | None = None
    procedure: str | None = None
    recorded_on: date | None = None


def find(reference: str, home: Home) -> Run:
    """The run with this id, digest or recording_id, or the only one with this beginning.

    Raises Unusable for none and for several.
    """
    table = tables.runs.c
    begins = [column.startswith(reference, autoescape=True) for column in (table.id, table.digest)]
    for meant in (
        sql.or_(table.id == reference, table.digest == reference),
        table.recording_id == reference,
        sql.or_(*begins),
    ):
        matching = runs_where(home, meant) if reference else []
        if len(matching) > 1:
            raise Unusable(
                f"{reference!r} means {len(matching)} runs ({_listed(matching)}); give the id of "
                "one, as `mimucal runs` lists them.",
                Message("cause-several-runs", (("name", reference), ("count", len(matching)))),
            )
        if matching:
            return matching[0]
    path = ", and no file or folder of that name" if os.sep in reference else ""
    raise Unusable(
        f"There is no run {reference!r} in {home.path}{path}; `mimucal runs` lists them.",
        Message("cause-none.run", (("name", reference),)),
    )


def _listed(several: list[Run]) -> str:
    ids = [run.id for run in several]
    return ", ".join(ids if len(ids) <= 4 else [*ids[:4], "…"])


def all_runs(home: Home) -> list[Run]:
    """Every run, in the order of import."""
    return runs_where(home, sql.true())


def runs_where(home: Home, which: sql.ColumnElement[bool]) -> list[Run]:
    """The runs that meet a condition on `runs` and `units`, in the order of import."""
    return database.with_units(home, Run, tables.runs, which, tables.runs.c.imported_at)
