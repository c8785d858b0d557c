"""The runs in the catalogue: listed, and found by what a person calls them.

Apart from `runs`, which reads and writes recordings and loads numpy and their formats for it.
"""

from datetime import datetime

import sqlalchemy as sql

from schemas.base import Frozen, Unusable
from storage.catalogue import database, tables
from storage.home import Home


class Run(Frozen):
    """A recording in the store. `seconds`: from its first row to its last one."""

    id: str
    digest: str
    recording_id: str
    manufacturer: str
    model: str
    serial: str
    standard: str
    taken_in_at: datetime
    seconds: float
    rows: int


def find(reference: str, home: Home) -> Run:
    """The run with this id, digest or recording_id, or the only one that begins so.

    Raises Unusable for none and for several.
    """
    table = tables.runs.c
    begins = [column.startswith(reference, autoescape=True) for column in (table.id, table.digest)]
    for meant in (
        sql.or_(table.id == reference, table.digest == reference),
        table.recording_id == reference,
        sql.or_(*begins),
    ):
        matching = _runs(home, meant) if reference else []
        if len(matching) > 1:
            raise Unusable(
                f"{reference!r} means {len(matching)} runs ({_listed(matching)}); give the id of "
                "one, as `mimucal runs` lists them."
            )
        if matching:
            return matching[0]
    raise Unusable(f"There is no run {reference!r} in {home.path}; `mimucal runs` lists them.")


def _listed(several: list[Run]) -> str:
    ids = [run.id for run in several]
    return ", ".join(ids if len(ids) <= 4 else [*ids[:4], "…"])


def all_runs(home: Home) -> list[Run]:
    """Every run, in the order of import."""
    return _runs(home, sql.true())


def _runs(home: Home, which: sql.ColumnElement[bool]) -> list[Run]:
    return database.with_units(home, Run, tables.runs, which, tables.runs.c.taken_in_at)
