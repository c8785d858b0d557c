"""Which results were re-processed under which circumstances, each once.

Circumstances: the code and the laboratory, as a digest. What is noted here lets a command that was
broken off go on, and tells the report what was before.
"""

from collections.abc import Sequence
from datetime import UTC, datetime

import sqlalchemy as sql

from schemas.base import Frozen
from schemas.calibration import Calibration
from storage.catalogue import database, tables
from storage.catalogue.results import add_result
from storage.catalogue.run_index import Run
from storage.home import Home


class ToMake(Frozen):
    """A result to be re-processed, or the first one of a run that has none (`before` is null)."""

    run: Run
    before: str | None

    @property
    def key(self) -> str:
        return self.before or self.run.id


class Made(Frozen):
    """A re-processed result, or `fault`: why there is none."""

    made_again: str
    run: str
    before: str | None
    after: str | None
    fault: str | None
    seconds: float


def to_make(runs: Sequence[Run], circumstances: str, home: Home) -> list[ToMake]:
    """The newest results of each run, and runs without any, that are still to be re-processed."""
    table = tables.results.c
    newest = database.rows(
        home, sql.select(table.id, table.run).where(database.newest_results()).order_by(table.id)
    )
    of_run: dict[str, list[str | None]] = {}
    for row in newest:
        of_run.setdefault(row.run, []).append(row.id)
    made = made_under(circumstances, home)
    done = {each.after for each in made} | {each.made_again for each in made if not each.fault}
    every = (
        ToMake(run=run, before=before) for run in runs for before in of_run.get(run.id, [None])
    )
    return [each for each in every if each.key not in done]


def made_under(circumstances: str, home: Home) -> list[Made]:
    """What was re-processed under given circumstances, in order."""
    table = tables.reprocessed
    columns = [table.c[name] for name in Made.model_fields]
    mine = sql.select(*columns).where(table.c.circumstances == circumstances)
    found = database.rows(home, mine.order_by(table.c.done_at, table.c.made_again))
    return [Made.model_validate(row, from_attributes=True) for row in found]


def made_from(code_version: str, circumstances: str, home: Home) -> set[str]:
    """Ids of the runs of which a result by a version, or its beginning, was re-processed."""
    made, result = tables.reprocessed, tables.results
    asked = sql.select(made.c.run).join_from(made, result, made.c.before == result.c.id)
    begins = result.c.code_version.startswith(code_version, autoescape=True)
    mine = made.c.after.is_not(None) & (made.c.circumstances == circumstances)
    return {row.run for row in database.rows(home, asked.where(mine, begins))}


def keep(
    made: ToMake, calibration: Calibration, circumstances: str, seconds: float, home: Home
) -> str:
    """Stores a result beside the earlier one and records it, both or neither; returns its id."""
    with database.changing(home) as connection:
        after = add_result(connection, calibration, None)
        _note(connection, made, circumstances, after=after, seconds=seconds)
    return after


def keep_fault(made: ToMake, why: str, circumstances: str, seconds: float, home: Home) -> None:
    """Records why a result could not be re-processed; the same command tries it again."""
    with database.changing(home) as connection:
        _note(connection, made, circumstances, fault=why, seconds=seconds)


def _note(
    connection: sql.Connection,
    made: ToMake,
    circumstances: str,
    *,
    seconds: float,
    after: str | None = None,
    fault: str | None = None,
) -> None:
    table = tables.reprocessed
    mine = (table.c.circumstances == circumstances, table.c.made_again == made.key)
    connection.execute(sql.delete(table).where(*mine, table.c.fault.is_not(None)))
    database.add_new(
        connection,
        table,
        circumstances=circumstances,
        made_again=made.key,
        run=made.run.id,
        before=made.before,
        after=after,
        fault=fault,
        seconds=seconds,
        done_at=datetime.now(UTC),
    )
