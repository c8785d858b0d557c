"""Results in the store: each new one supersedes the previous one of its kind, and says why.

Alike are results of one run by one method with the same terms adopted beside the standard's: a
result with a further term stands beside the one without it, and neither supersedes the other.
"""

import hashlib
import json
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


def add_result(connection: sql.Connection, calibration: Calibration, why: str | None) -> str:
    """`save` within a transaction; one writer at a time for each run."""
    run = tables.runs.c
    mine = sql.select(run.id).where(run.id == calibration.run, run.digest == calibration.digest)
    if connection.execute(mine.with_for_update()).one_or_none() is None:
        raise Unusable(
            f"Run {calibration.run} of recording {calibration.recording_id} is not in the store "
            "with this content; import the recording first."
        )
    document = calibration.model_dump_json()
    latest = _latest(connection, calibration, document)
    if latest is not None and latest.document == document:
        return str(latest.id)
    before = None if latest is None else str(latest.id)
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
        "why": why if latest is None else why or _why(latest, calibration),
    }
    connection.execute(sql.insert(tables.results).values(row))
    result_rows.add(connection, result, calibration, now)
    return result


def of_run(run: Run, home: Home) -> list[Result]:
    """Every result of a run, the oldest first."""
    return _results(home, tables.results.c.run == run.id)


def chain(result: str | None, home: Home) -> list[str]:
    """A result and those it supersedes, newest first."""
    table, found = tables.results.c, list[str]()
    while result is not None:
        found.append(result)
        rows = database.rows(home, sql.select(table.supersedes).where(table.id == result))
        result = rows[0].supersedes if rows else None
    return found


def newest(kept: Sequence[Result]) -> Result | None:
    """The one that speaks for a run: made last with the standard's terms alone."""
    return next((each for each in reversed(kept) if not each.calibration.terms), None)


def find(reference: str, home: Home) -> Result:
    """The result with this id, or the newest of the run with this id; Unusable for neither.

    Of a run that has only results with further terms, the last of them.
    """
    table = tables.results.c
    kept = _results(home, sql.or_(table.id == reference, table.run == reference))
    if kept:
        return newest(kept) or kept[-1]
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


def _latest(connection: sql.Connection, calibration: Calibration, document: str) -> sql.Row | None:
    """The result of the same run, method and adopted terms that is not yet superseded."""
    table = tables.results
    mine = (table.c.run == calibration.run, table.c.method == calibration.method)
    adopted = [term.name for term in calibration.terms]
    for row in connection.execute(sql.select(table).where(*mine, database.newest_results())):
        if row.document == document or _terms_of(row) == adopted:
            return row
    return None


def _terms_of(row: sql.Row) -> list[str]:
    """The names of the terms in a document, none for one that cannot be read."""
    try:
        return [str(term["name"]) for term in json.loads(row.document).get("terms", ())]
    except (ValueError, TypeError, KeyError, AttributeError):
        return []


def _results(home: Home, which: sql.ColumnElement[bool]) -> list[Result]:
    statement = sql.select(tables.results).where(which).order_by(tables.results.c.made_at)
    columns = [name for name in Result.model_fields if name in tables.results.c]
    return [
        Result(calibration=calibration_of(row), **{name: row._mapping[name] for name in columns})
        for row in database.rows(home, statement)
    ]


def _why(latest: sql.Row, calibration: Calibration) -> str:
    """What differs in how the new result was made."""
    try:
        before = calibration_of(latest)
    except Unusable:
        return "the document before cannot be read any more"
    differs = [n for n in CIRCUMSTANCES if getattr(before, n) != getattr(calibration, n)]
    if "code_version" in differs:
        differs[0] = f"code_version ({before.code_version} to {calibration.code_version})"
    return f"made with another {', '.join(differs)}" if differs else "other values, made the same"
