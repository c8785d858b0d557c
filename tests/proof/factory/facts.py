"""What a play left behind, read from the database, the bucket and the mails themselves."""

import email
import hashlib
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from email import policy
from pathlib import Path
from typing import Any

import psycopg
from psycopg.rows import dict_row

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

    @property
    def mails_total(self) -> int:
        """How many messages name a certificate."""
        return sum(self.mails.values())


def facts(connection: psycopg.Connection, objects: Path, home: Path, mails: Path) -> Facts:
    """Read everything; connection: to the catalogue."""
    papers = papers_of(connection)
    return Facts(
        orders=tuple(orders_of(connection)),
        runs=tuple(_runs(connection, objects)),
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


def _runs(connection: psycopg.Connection, objects: Path) -> Sequence[Run]:
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


def digest_of(folder: Path) -> str:
    """Of every file below a folder, by name and content."""
    digest = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        digest.update(str(path.relative_to(folder)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()
