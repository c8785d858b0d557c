"""Results in the store: each new one supersedes the previous one of its kind, and says why.

Alike are results of one run by one method with the same terms adopted beside the standard's: a
result with a further term stands beside the one without it, and neither supersedes the other.
"""

import hashlib
import json
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sql
from pydantic import ValidationError

from schemas.base import Frozen, Unusable, first_fault
from schemas.calibration import Calibration, Method
from schemas.tolerance import Decision
from storage.catalogue import database, tables
from storage.catalogue.runs import Run
from storage.home import Home

# The content of every result and certificate as rows, so that queries open no documents.
#
# They are made of the documents alone, and can be made again from them.


def add(
    connection: sql.Connection, result: str, calibration: Calibration, made_at: datetime
) -> None:
    """Adds the rows of a result; existing ones stay."""
    for table, rows in (
        (tables.elements, elements_of(calibration)),
        (tables.segments, segments_of(calibration)),
        (tables.outcomes, [outcome_of(calibration) | {"made_at": made_at}]),
    ):
        database.add_all_new(connection, table, [{"result": result} | row for row in rows])


def outcome_of(calibration: Calibration) -> dict[str, Any]:
    """Terms beside the standard's, validity of the run, and how many elements have no value."""
    values = [value for item in calibration.items.values() for value in item.value.values()]
    return {
        "run": calibration.run,
        "method": calibration.method,
        "terms": " ".join(term.name for term in calibration.terms),
        "verdict": calibration.validity.verdict,
        "missing": values.count(None),
    }


def elements_of(calibration: Calibration) -> list[dict[str, Any]]:
    """A row for each element of each item."""
    return [
        {"item": name, "element": element, "value": value}
        | {"u": item.u.get(element), "expanded": item.U.get(element)}
        | {"k": item.k, "unit": item.unit}
        for name, item in calibration.items.items()
        for element, value in item.value.items()
    ]


def segments_of(calibration: Calibration) -> list[dict[str, Any]]:
    """A row for each segment that was used, with the mean and deviation of each channel."""
    return [
        {"number": number}
        | segment.model_dump(exclude={"mean", "deviation"})
        | {f"mean_{name}": segment.mean.get(name) for name in tables.CHANNELS}
        | {f"deviation_{name}": segment.deviation.get(name) for name in tables.CHANNELS}
        for number, segment in enumerate(calibration.segments)
    ]


def add_decision(connection: sql.Connection, certificate: str, decision: Decision) -> None:
    """Adds the rows of what a certificate decides; those that are there stay."""
    rows = [{"certificate": certificate} | row for row in decisions_of(decision)]
    database.add_all_new(connection, tables.decisions, rows)


def decisions_of(decision: Decision) -> list[dict[str, Any]]:
    """A row for each limit on each element, in the order of the record."""
    names = ("item", "element", "applied_to", "lower", "upper", "verdict")
    return [
        {"number": number} | {name: getattr(limit, name) for name in names}
        for number, limit in enumerate(decision.limits)
    ]


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
    add(connection, result, calibration, now)
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


# Which results were re-processed under which circumstances, each once.
#
# Circumstances: the code and the laboratory, as a digest. What is noted here lets a command that
# was broken off go on, and tells the report what was before.


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
