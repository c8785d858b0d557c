"""What a play left behind, by database, bucket and mails, held against what was promised."""

import email
import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from email import policy
from pathlib import Path
from typing import Any

import psycopg
from psycopg.rows import dict_row

from tests.proof.factory.draw import EVERY_MONTH, OrderedUnit

SENT = "SELECT certificate FROM reminders WHERE sent_at IS NOT NULL"
STEPS = ("draft", "check", "issue")  # of the trail, in their sequence


@dataclass(frozen=True)
class Order:
    """An order of the catalogue. process: that began it last."""

    number: str
    serial: str
    state: str
    runs: tuple[str, ...]
    drafts: tuple[str, ...]
    attempts: int
    fault: str
    process: int | None = None


@dataclass(frozen=True)
class Run:
    """A run of the catalogue. is_kept: its raw recording is in the bucket, with that content."""

    id: str
    serial: str
    is_kept: bool


@dataclass(frozen=True)
class Paper:
    """A certificate. draft: the key that it had before; persons: of its steps, in sequence."""

    number: str
    draft: str
    run: str
    state: str
    verdict: str
    persons: tuple[str, ...]
    is_reminded: bool


@dataclass(frozen=True)
class Facts:
    """mails: how many name each certificate. reminders: rows of the catalogue, sent and not.
    interrupted: recordings that a station still has. unfinished: flow runs of Prefect's, by state.
    """

    orders: tuple[Order, ...]
    runs: tuple[Run, ...]
    papers: tuple[Paper, ...]
    mails: Mapping[str, int]
    reminders: Mapping[str, int]
    interrupted: tuple[str, ...]
    unfinished: Mapping[str, int] = field(default_factory=dict)


def facts(connection: psycopg.Connection, objects: Path, home: Path, mails: Path) -> Facts:
    """Read everything; connection: to the catalogue."""
    papers = papers_of(connection)
    return Facts(
        orders=tuple(orders_of(connection)),
        runs=tuple(runs_of(connection, objects)),
        papers=papers,
        mails=_mails(mails, [each.number for each in papers]),
        reminders=Counter(
            row["certificate"]
            for row in _rows(connection, SENT)
        ),
        interrupted=tuple(
            sorted(path.name for path in (home / "acquiring").rglob("*")
                if path.is_file() and path.stat().st_size)
        ),
    )  # fmt: skip


def _rows(connection: psycopg.Connection, asked: str) -> list[dict[str, Any]]:
    with connection.cursor(row_factory=dict_row) as cursor:
        return cursor.execute(asked).fetchall()


def orders_of(connection: psycopg.Connection) -> Sequence[Order]:
    return [
        Order(
            row["number"], json.loads(row["units"])[0]["serial"], row["state"],
            tuple(json.loads(row["runs"])), tuple(json.loads(row["certificates"])),
            row["attempts"], _sentence(row["fault"] or ""),
            row["process"],
        )
        for row in _rows(connection, "SELECT * FROM orders ORDER BY ordered_at, number")
    ]  # fmt: skip


def _sentence(fault: str) -> str:
    """Of a fault that is kept with its cause for the pages, the sentence."""
    return str(json.loads(fault)["fault"]) if fault.startswith('{"fault"') else fault


def runs_of(connection: psycopg.Connection, objects: Path) -> Sequence[Run]:
    asked = "SELECT runs.id, digest, serial FROM runs JOIN units ON units.id = runs.unit"
    return [
        Run(row["id"], row["serial"], _is_kept(objects / "raw" / f"{row['digest']}.mcap"))
        for row in _rows(connection, asked)
    ]


def _is_kept(raw: Path) -> bool:
    """Whether it is there; its content is what its name says as `mimucal verify` sees it."""
    return raw.is_file() and raw.stat().st_size > 0


def papers_of(connection: psycopg.Connection) -> tuple[Paper, ...]:
    """Each with the persons of its steps: of one that was taken again, whoever took it last."""
    persons = {
        (row["action"], row["subject"]): row["person"]
        for row in _rows(connection, "SELECT person, action, subject FROM trail ORDER BY number")
    }
    papers = []
    for row in _rows(connection, "SELECT * FROM certificates ORDER BY number"):
        draft = row["draft"] or row["number"]
        steps = [persons.get((step, row["number"] if step == "issue" else draft)) for step in STEPS]
        papers.append(Paper(
            row["number"], draft, row["run"], row["state"], row["verdict"],
            tuple(filter(None, steps)), row["due"] is not None,
        ))  # fmt: skip
    return tuple(papers)


def _mails(folder: Path, numbers: Sequence[str]) -> Counter[str]:
    """How many messages name each certificate."""
    found: Counter[str] = Counter()
    for path in folder.glob("*.eml"):
        letter = email.message_from_bytes(path.read_bytes(), policy=policy.default)
        body = letter.get_body(("plain", "html"))
        text = body.get_content() if body is not None else ""
        found.update(number for number in numbers if number in text)
    return found


# What was promised, and what came of it.

LIVE = ("draft", "checked", "issued")
SHOWN = 4  # of what is wrong


@dataclass(frozen=True)
class Row:
    """A promise, what was to come, what came, and whether that is the same."""

    promise: str
    expected: str
    got: str
    holds: bool


def row(promise: str, expected: object, got: object) -> Row:
    """The row of what is to be equal."""
    return Row(promise, str(expected), str(got), expected == got)


def none_of(promise: str, wrong: Iterable[str]) -> Row:
    """The row of what is to be none."""
    found = sorted(wrong)
    shown = "; ".join(found[:SHOWN]) + (f"; … ({len(found)})" if len(found) > SHOWN else "")
    return Row(promise, "none", shown or "none", not found)


def judged(ordered: Sequence[OrderedUnit], facts: Facts) -> list[Row]:
    """Orders, runs, certificates and reminders against each other."""
    return [
        *_orders(ordered, facts),
        *_runs(ordered, facts),
        *_certificates(ordered, facts),
        *_reminders(ordered, facts),
    ]


def _orders(ordered: Sequence[OrderedUnit], facts: Facts) -> list[Row]:
    states = Counter(order.state for order in facts.orders)
    rejected = sum(unit.is_rejected for unit in ordered)
    asked = {unit.number: unit.serial for unit in ordered}
    there = {order.number: order.serial for order in facts.orders}
    differing = {n for n in asked.keys() | there.keys() if asked.get(n) != there.get(n)}
    return [
        none_of("Every order of the file is in the queue, and no other", differing),
        row("Orders of sound units are done", len(ordered) - rejected, states["done"]),
        row("Orders of faulty units have failed, with a reason", rejected, sum(
            order.state == "failed" and bool(order.fault) for order in facts.orders
        )),
        none_of("No order waits or runs", (
            f"{order.number} {order.state}"
            for order in facts.orders
            if order.state in ("waiting", "running")
        )),
        none_of("No flow run of Prefect's is late, pending or running", (
            f"{count} {state}" for state, count in facts.unfinished.items()
        )),
    ]  # fmt: skip


def _runs(ordered: Sequence[OrderedUnit], facts: Facts) -> list[Row]:
    asked = Counter(unit.serial for unit in ordered)
    of_serial = Counter(run.serial for run in facts.runs)
    used = Counter(run for order in facts.orders for run in order.runs)
    return [
        none_of("Each order measured its unit, and once", (
            f"{serial}: {of_serial[serial]} runs"
            for serial, orders in asked.items()
            if of_serial[serial] != orders
        )),
        none_of("No run is of a unit that was not ordered",
                of_serial.keys() - asked.keys()),
        none_of("Each run is that of one order", (
            f"{run.id} ({run.serial}): {used[run.id]} orders"
            for run in facts.runs
            if used[run.id] != 1
        )),
        none_of("No order names a run that is not there", used.keys() - {r.id for r in facts.runs}),
        none_of("Every raw recording is in the bucket",
                (run.id for run in facts.runs if not run.is_kept)),
        none_of("No recording is left at a station", facts.interrupted),
    ]  # fmt: skip


def _certificates(ordered: Sequence[OrderedUnit], facts: Facts) -> list[Row]:
    rejected = {unit.number for unit in ordered if unit.is_rejected}
    live = [paper for paper in facts.papers if paper.state in LIVE]
    of_run = Counter(paper.run for paper in live)
    issued = [paper for paper in facts.papers if paper.state == "issued"]
    wrong = [
        f"{order.number}: {count} certificates"
        for order in facts.orders
        if (count := _count(order, of_run)) != (order.number not in rejected)
    ]
    serials = Counter(int(paper.number.rpartition("-")[2]) for paper in issued)
    due = Counter(range(1, len(issued) + 1))
    serial_of = {run.id: run.serial for run in facts.runs}
    verdicts = {serial_of.get(paper.run): paper.verdict for paper in live}
    unlike = [
        f"{unit.serial}: {verdicts.get(unit.serial)}, planted {unit.verdict}"
        for unit in ordered
        if unit.verdict is not None and verdicts.get(unit.serial) != unit.verdict
    ]
    return [
        none_of("Units pass, fail and stay inconclusive as they were planted", unlike),
        none_of("Each order that is done has one certificate, and no other order has one", wrong),
        none_of("Each certificate is issued",
                (f"{paper.number} {paper.state}" for paper in live if paper.state != "issued")),
        none_of("The serial numbers of certificates are 1, 2, 3 …, none twice",
                map(str, ((serials - due) + (due - serials)).keys())),
        none_of("Drafted, checked and issued by three persons", (
            f"{paper.number}: {', '.join(paper.persons)}"
            for paper in issued
            if len(set(paper.persons)) != 3
        )),
    ]  # fmt: skip


def _count(order: Order, of_run: "Counter[str]") -> int:
    return sum(of_run[run] for run in order.runs)


def _reminders(ordered: Sequence[OrderedUnit], facts: Facts) -> list[Row]:
    """Of units that come back in a month; the others are due long after."""
    reminded = {u.serial for u in ordered if u.client == EVERY_MONTH and not u.is_rejected}
    serial = {run.id: run.serial for run in facts.runs}
    wrong = []
    for paper in facts.papers:
        if paper.state == "issued":
            due = int(serial.get(paper.run) in reminded)
            mails, noted = facts.mails.get(paper.number, 0), facts.reminders.get(paper.number, 0)
            if (mails, noted) != (due, due):
                wrong.append(f"{paper.number}: {mails} mails, {noted} noted, {due} due")
    return [
        row(
            "Reminders that are due came to their clients", len(reminded), sum(facts.mails.values())
        ),
        none_of("Each reminder came once, and is noted once", wrong),
    ]
