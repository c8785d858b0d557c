"""The end of the two days: reminders, yield, review, verification, backup, and history again."""

import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import httpx
import psycopg
from psycopg import sql

from tests.proof.factory.judge import Facts, Row, facts, none_of, row
from tests.proof.factory.laboratory import Person
from tests.proof.factory.works import PASSWORD, Works

UNFINISHED = ("SCHEDULED", "PENDING", "RUNNING", "PAUSED", "CANCELLING")
BEFORE_DUE_DAYS = 25  # from now: within a week of what is due in a month, before what is in a year
# A client is not reminded of a certificate just received, and two days are too short for the next
# occasion: the clock of the reminders is put forward in their place.
REMIND = f"""
import sys
from datetime import UTC, datetime, timedelta
from storage.home import home
from tasks.stages.remind import remind
sys.exit("; ".join(remind(home(), datetime.now(UTC) + timedelta(days={BEFORE_DUE_DAYS}))) or 0)
"""
KILLED = "dask worker 1"  # while history is made again
TABLES = "SELECT tablename FROM pg_tables WHERE schemaname = 'public'"


def closed(works: Works) -> Iterator[Row]:
    """What each promise of the end came to; one that breaks off is a row, too."""
    for promise, made in (
        ("Reminders are sent, and no second time", _reminded),
        ("Yield", _yields),
        ("Review of all runs", _reviewed),
        ("Everything that is kept is intact", _verified),
        ("History is made again on dask", _made_again),
        ("Backup and restore", _restored),
    ):
        try:
            yield from made(works)
        except (RuntimeError, httpx.HTTPError, KeyError, ValueError) as error:
            yield Row(promise, "done", str(error)[-300:], holds=False)


def read(works: Works) -> Facts:
    """The facts as they stand."""
    with works.database.connected("mimucal") as connection:
        found = facts(connection, works.objects, works.home, works.mails)
    return replace(found, unfinished=_unfinished(works))


def _unfinished(works: Works) -> dict[str, int]:
    """Flow runs that have not ended but those that a schedule has yet to begin."""
    asked = {"flow_runs": {"state": {"type": {"any_": list(UNFINISHED)}}}, "limit": 200}
    found = works.prefect_api("POST", "/flow_runs/filter", json=asked)
    return dict(Counter(each["state_name"] for each in found if not each["auto_scheduled"]))


def _reminded(works: Works) -> Iterator[Row]:
    works.command("remind", "--within", 400, "--json")
    works.python(REMIND)
    before = len(list(works.mails.glob("*.eml")))
    works.python(REMIND)
    after = len(list(works.mails.glob("*.eml")))
    yield row("Asked to remind again, nothing is sent", before, after)


def _yields(works: Works) -> Iterator[Row]:
    """The yield of the pages: of all runs, an invalid one among them, those that passed."""
    with works.database.connected("mimucal") as connection:
        verdicts = Counter(
            verdict
            for (verdict,) in connection.execute("SELECT verdict FROM certificates").fetchall()
        )
        (runs,) = connection.execute("SELECT count(*) FROM runs").fetchone() or (0,)
    person = Person("Li Na", PASSWORD, works.pages_url)
    person.log_in()
    shown = person.shown("quality")
    person.close()
    total: dict[str, Any] = shown["total"] or {}
    got = {name: total.get(name) for name in ("passed", "of")}
    expected = {"passed": verdicts["pass"], "of": runs}
    invalid = sum(
        each["failed"]
        for each in shown["failing"]
        if each["item"] is None and "invalid" in each["title"]["en"].lower()
    )
    with works.database.connected("mimucal") as connection:
        asked = "SELECT count(DISTINCT run) FROM outcomes WHERE verdict = 'invalid'"
        (in_book,) = connection.execute(asked).fetchone() or (0,)
    yield row("The Pareto chart has every invalid run", in_book, invalid)
    yield row("Yield on the pages is that of runs and certificates", expected, got)


def _reviewed(works: Works) -> Iterator[Row]:
    answer = json.loads(works.command("review", "--json"))
    statement = answer["statement"]["en"]
    yield Row("Review of all runs ends in an answer", "an answer", statement[:200], bool(statement))


def _verified(works: Works) -> Iterator[Row]:
    answer = json.loads(works.command("verify", "--json"))
    faults = (f"{fault['what']}: {fault['why']}" for fault in answer["faults"])
    yield none_of("`mimucal verify` finds no fault", faults)


def _made_again(works: Works) -> Iterator[Row]:
    """With a worker killed meanwhile."""
    with works.database.connected("mimucal") as connection:
        (runs,) = connection.execute("SELECT count(DISTINCT run) FROM results").fetchone() or (0,)
    worker = works.parts[KILLED]
    worker.kill()
    words = ("reprocess", "--engine", "dask", "--scheduler", works.scheduler, "--json")
    worker.begin()
    report = json.loads(works.command(*words))
    got = {name: report[name] for name in ("done", "failed")} | {"changed": len(report["changed"])}
    expected = {"done": runs, "failed": 0, "changed": 0}
    yield row("Made again on dask, every result is as before", expected, got)


def _restored(works: Works) -> Iterator[Row]:
    """Into an empty home and an empty database."""
    backup, home = works.folder / "backup", works.folder / "restored"
    works.command("backup", backup, "--json")
    elsewhere = {
        "MIMUCAL_HOME": str(home), "MIMUCAL_DATABASE": works.database.url("restored"),
        "MIMUCAL_STORE": "",
    }  # fmt: skip
    answer = json.loads(works.command("restore", backup, "--json", **elsewhere))
    yield none_of(
        "Restored onto an empty home and database, nothing is at fault",
        (f"{fault['what']}: {fault['why']}" for fault in answer["faults"]),
    )
    counts = {}
    for name in ("mimucal", "restored"):
        with works.database.connected(name) as connection:
            counts[name] = _counted(connection)
    wrong = (
        f"{table}: {rows} rows, restored {counts['restored'].get(table)}"
        for table, rows in counts["mimucal"].items()
        if rows != counts["restored"].get(table)
    )
    yield none_of("Every table has as many rows as it had", wrong)


def _counted(connection: psycopg.Connection) -> dict[str, int]:
    counted = {}
    for (name,) in connection.execute(TABLES).fetchall():
        rows = sql.SQL("SELECT count(*) FROM {}").format(sql.Identifier(name))
        (counted[name],) = connection.execute(rows).fetchone() or (0,)
    return counted
