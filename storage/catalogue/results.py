"""Results in the store: each new one supersedes the previous one of its kind, and says why.

Alike are results of one run by one method with the same terms adopted beside the standard's: a
result with a further term stands beside the one without it, and neither supersedes the other.
"""

import hashlib
from collections.abc import Sequence
from datetime import UTC, datetime

import sqlalchemy as sql
from pydantic import ValidationError

from schemas.base import Frozen, Unusable, first_fault
from schemas.calibration import Calibration, Method
from storage.catalogue import database, result_rows, tables
from storage.catalogue.run_index import Run
from storage.home import Home

ID_DIGITS = 12  # hex digits in a result's id
CIRCUMSTANCES = ("code_version", "procedure", "settings", "segments")


class Result(Frozen):
    """A stored result with its place in the series of its run and method."""

    id: str
    run: str
    method: Method
    code_version: str
    made_at: datetime
    supersedes: str | None
    why: str | None
    calibration: Calibration


def save(calibration: Calibration, home: Home, *, why: str | None = None) -> str:
    """Stores a result and returns its id; one equal to the latest is that result.

    A result that supersedes another says why: `why`, or what differs in how it was made. Raises
    Unusable for a run that is not in the store.
    """
    with database.changing(home) as connection:
        return add_result(connection, calibration, why)


def add_result(
    connection: sql.Connection,
    calibration: Calibration,
    why: str | None,
    known: Result | None = None,
) -> str:
    """`save` within a transaction; one writer at a time for each run.

    known: a result that was read already, and is not read once more.
    """
    _lock_run(connection, calibration)
    document = calibration.model_dump_json()
    before: str | None = None
    for newest in _newest(connection, calibration):
        same = newest.id == result_id(newest.supersedes, document)
        if same and _row(connection, newest.id).document == document:
            return str(newest.id)
        if before is None:
            read = known is not None and known.id == newest.id
            earlier = known.calibration if known and read else _readable(connection, newest.id)
            if _adopted(earlier) == _adopted(calibration):
                before, why = str(newest.id), why or _why(earlier, calibration)
    result = result_id(before, document)
    now = datetime.now(UTC)
    row = {
        "id": result,
        "run": calibration.run,
        "method": calibration.method,
        "code_version": calibration.code_version,
        "made_at": now,
        "document": document,
        "supersedes": before,
        "why": why,
    }
    connection.execute(sql.insert(tables.results).values(row))
    result_rows.add(connection, result, calibration, now)
    return result


def of_run(run: Run, home: Home) -> list[Result]:
    """Every result of a run, the oldest first."""
    return _results(home, tables.results.c.run == run.id)


def all_results(home: Home) -> list[Result]:
    """Every result of every run, the oldest first."""
    return _results(home, sql.true())


def chain(result: str | None, home: Home) -> list[str]:
    """A result and those it supersedes, newest first."""
    table, found = tables.results.c, list[str]()
    while result is not None:
        found.append(result)
        rows = database.rows(home, sql.select(table.supersedes).where(table.id == result))
        result = rows[0].supersedes if rows else None
    return found


def find(reference: str, home: Home) -> Result:
    """The result with this id, or the newest of the run with this id; Unusable for neither."""
    table = tables.results.c
    for result in reversed(_results(home, sql.or_(table.id == reference, table.run == reference))):
        return result
    raise Unusable(
        f"There is no result {reference!r} in {home.path} and no such file; give a file that "
        "`mimucal calibrate RUN --json` printed, the id of a run that was calibrated, or a "
        "result's id, as `mimucal show RUN --json` lists them."
    )


def result_id(supersedes: str | None, document: str) -> str:
    """The id of a document in its series; it changes with either."""
    return "c" + hashlib.sha256(f"{supersedes}\n{document}".encode()).hexdigest()[:ID_DIGITS]


def calibration_of(row: sql.Row) -> Calibration:
    """The document in a row of results; raises Unusable if it is not one."""
    try:
        return Calibration.model_validate_json(row.document)
    except ValidationError as error:
        raise Unusable(
            f"The document of result {row.id} cannot be read ({first_fault(error)}); "
            f"calibrate run {row.run} again."
        ) from error


def _newest(connection: sql.Connection, calibration: Calibration) -> Sequence[sql.Row]:
    """Id and predecessor of what is not superseded of the same run and method."""
    table = tables.results.c
    mine = (table.run == calibration.run, table.method == calibration.method)
    newest = sql.select(table.id, table.supersedes).where(*mine, database.newest_results())
    return connection.execute(newest).all()


def _row(connection: sql.Connection, result: str) -> sql.Row:
    table = tables.results.c
    asked = sql.select(table.id, table.run, table.document).where(table.id == result)
    return connection.execute(asked).one()


def _readable(connection: sql.Connection, result: str) -> Calibration | None:
    """The document of a result, None for one that cannot be read."""
    try:
        return calibration_of(_row(connection, result))
    except Unusable:
        return None


def _adopted(calibration: Calibration | None) -> list[str]:
    """The names of the terms beside the standard's; none where nothing can be read."""
    return [term.name for term in calibration.terms] if calibration else []


def _results(home: Home, which: sql.ColumnElement[bool]) -> list[Result]:
    statement = sql.select(tables.results).where(which).order_by(tables.results.c.made_at)
    columns = [name for name in Result.model_fields if name in tables.results.c]
    return [
        Result(calibration=calibration_of(row), **{name: row._mapping[name] for name in columns})
        for row in database.rows(home, statement)
    ]


def _lock_run(connection: sql.Connection, calibration: Calibration) -> None:
    run = tables.runs.c
    mine = sql.select(run.id).where(run.id == calibration.run, run.digest == calibration.digest)
    if connection.execute(mine.with_for_update()).one_or_none() is None:
        raise Unusable(
            f"Run {calibration.run} of recording {calibration.recording_id} is not in the store "
            "with this content; import the recording first."
        )


def _why(before: Calibration | None, calibration: Calibration) -> str:
    """What differs in how the new result was made."""
    if before is None:
        return "the document before cannot be read any more"
    differs = [n for n in CIRCUMSTANCES if getattr(before, n) != getattr(calibration, n)]
    if "code_version" in differs:
        differs[0] = f"code_version ({before.code_version} to {calibration.code_version})"
    return f"made with another {', '.join(differs)}" if differs else "other values, made the same"
