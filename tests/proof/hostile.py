"""Requests of people who may not: none acts, each is refused, and each is a line of the log.

Sessions, tokens, proxies, passwords and signatures are held one by one by `tests/flows`.
"""

import hashlib
import logging
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import httpx
import sqlalchemy as sql
from argon2 import PasswordHasher

from flows import execute
from flows.orders.signed_orders import accepted, sign
from flows.pages.answers import PAGES
from schemas.access import ROLES
from schemas.base import Unusable
from schemas.orders import CheckOrder, IssueOrder, StepOrder, WithdrawOrder
from storage.catalogue import database, tables, users
from storage.home import Home
from tests.drafts import draft
from tests.pages_server import served
from tests.proof.study import Out, Write, hold, table

PASSWORD = "correct horse battery"
QUICK = PasswordHasher(time_cost=1, memory_cost=64, parallelism=1)
WHAT_COUNTS = (
    tables.certificates, tables.decisions, tables.series, tables.results, tables.runs,
    tables.orders, tables.users,
)  # fmt: skip
METHODS = ("GET", "POST", "PUT", "DELETE", "PATCH", "TRACE", "PROPFIND")
TRICKS = (
    "/assets/../orders.key", "/assets/..%2forders.key", "/assets/%00", "/assets//etc/passwd",
    "/certificate/..%2f..%2forders.key", "/explained/..%2f..%2fpages.key.html", "//api/v1/runs",
    "/login/../api/v1/runs", "/login%2f..%2fapi%2fv1%2fruns", "/API/V1/RUNS", "/api/v1/..;/runs",
    "/orders.key", "/catalog.sqlite", "/pages.toml", "/_favicon.ico/../api/v1/runs",
)  # fmt: skip
HEADERS = (
    {"X-Remote-User": "administrator"}, {"Authorization": "Basic !!!"}, {"Cookie": "session=eyJ9"},
    {"X-Remote-User": "administrator", "X-Forwarded-For": "127.0.0.1"},
    {"Authorization": "Basic YWRtaW5pc3RyYXRvcjp3cm9uZw=="},
)  # fmt: skip


@dataclass(frozen=True)
class Tried:
    """One request, and what became of it."""

    kind: str
    what: str
    refused: bool
    logged: bool


def hostile(out: Out = None, write: Write = False) -> None:
    """Hostile requests of the pages, and forged orders."""
    hold("hostile", {"all": 0}, _attack, lambda found: _page(found[0]), out, write=write,
         at_once=0, faults=_faults)  # fmt: skip


def _attack(_: int) -> tuple[list[Tried], bool]:
    """Everything that was tried, and whether tables and files are as they were."""
    with TemporaryDirectory(prefix="mimucal-hostile-") as name:
        home = Home(Path(name))
        for role in ROLES:
            users.add(role, role, QUICK.hash(PASSWORD), home, "Admin")
        drafts = [draft(home, serial).certificate.number for serial in "123"]
        for key in drafts[1:]:
            execute.check(CheckOrder(certificate=key, by="verifier", home=name))
        issue = IssueOrder(certificate=drafts[2], by="issuer", home=name)
        number = execute.issue(issue).certificate.number
        before = _stand(home)
        with _log() as lines:
            with served(home) as address:
                tried = list(_requests(address, number, lines))
            orders = (
                CheckOrder(certificate=drafts[0], by="verifier", home=name),
                IssueOrder(certificate=drafts[1], by="issuer", home=name),
                WithdrawOrder(certificate=number, by="issuer", why="hostile", home=name),
            )
            for flow, order in zip(("check", "issue", "withdraw"), orders, strict=True):
                tried += _forged(flow, order, lines)
        return tried, _stand(home) == before


def _requests(address: str, number: str, lines: list[str]) -> Iterator[Tried]:
    """Of everything that somebody could look at, by nobody in particular."""
    names = [page.name for page in PAGES]
    paths = [
        *(f"/{each}" for each in names), *(f"/api/v1/{each}" for each in names),
        "/api/v1/openapi.json", "/_dash-layout", "/_dash-dependencies", "/_dash-update-component",
        f"/certificate/{number}.pdf", "/explained/r1.html",
    ]  # fmt: skip
    calls = [
        *(("no login", method, path, {}) for method, path in product(METHODS, paths)),
        *(("path trick", "GET", path, {}) for path in TRICKS),
        *(("forged name", "GET", path, each) for each, path in product(HEADERS, paths)),
    ]
    with httpx.Client(base_url=address, trust_env=False, timeout=60.0) as client:
        for kind, method, path, headers in calls:
            logged = len(lines)
            answer = client.request(method, path, headers=headers)
            leads_away = answer.headers.get("Location", "").startswith("/login")
            refused = 400 <= answer.status_code < 500 or (answer.is_redirect and leads_away)
            yield Tried(kind, f"{method} {path}", refused, len(lines) > logged)


def _forged(flow: str, order: StepOrder, lines: list[str]) -> Iterator[Tried]:
    """Orders as whoever reaches Prefect's server could give them."""
    good = sign(flow, order)
    assert good.signature is not None
    forged = {
        "a name alone": order,
        "signed for another role": sign(flow, order.model_copy(update={"by": "viewer"})),
        "another person's signature": good.model_copy(update={"by": "administrator"}),
        "another order's signature": good.model_copy(update={"certificate": "LAB-2026-9999"}),
        "a made-up signature": good.model_copy(
            update={"signature": good.signature.model_copy(update={"mac": "0" * 64})}
        ),
    }
    for what, each in forged.items():
        logged, refused = len(lines), False
        try:
            with accepted(flow, each):
                pass
        except Unusable:
            refused = True
        yield Tried(f"order: {what}", flow, refused, len(lines) > logged)


def _stand(home: Home) -> dict[str, str]:
    """A digest of each table that counts, and of the files of certificates."""
    found = {
        table.name: repr(database.rows(home, sql.select(table).order_by(*table.primary_key)))
        for table in WHAT_COUNTS
    }
    for file in sorted(home.certificates.rglob("*")):
        found[file.name] = hashlib.sha256(file.read_bytes()).hexdigest()
    return found


@contextmanager
def _log() -> Iterator[list[str]]:
    """The lines that the pages and the flows of this process log meanwhile."""
    lines: list[str] = []
    logger, kept = logging.getLogger("mimucal.access"), logging.Handler()
    kept.emit = lambda record: lines.append(record.getMessage())  # type: ignore[method-assign]
    level, logger.propagate = logger.level, False
    logger.setLevel(logging.INFO)
    logger.addHandler(kept)
    try:
        yield lines
    finally:
        logger.removeHandler(kept)
        logger.setLevel(level)
        logger.propagate = True


def _faults(attack: tuple[Sequence[Tried], bool]) -> Iterator[str]:
    tried, unchanged = attack
    yield from (f"{one.kind}: {one.what}" for one in tried if not (one.refused and one.logged))
    if not unchanged:
        yield "something acted"


def _page(attack: tuple[Sequence[Tried], bool]) -> str:
    tried, unchanged = attack
    counts = (
        Counter(one.kind for one in tried if holds(one))
        for holds in (lambda _: True, lambda one: one.refused, lambda one: one.logged)
    )
    calls, refused, logged = counts
    rows = ((kind, calls[kind], refused[kind], logged[kind]) for kind in calls)
    return "\n".join([
        "# Hostile calls", "",
        '`make prove ARGS="hostile"`: the pages of a home with a user of each role and a draft, a '
        "checked and an issued certificate, and orders with forged signatures. Afterwards "
        "certificates, their files, results, runs, orders and users were "
        f"{'as before' if unchanged else 'CHANGED'}.", "",
        *table(("what was tried", "calls", "refused", "logged"), rows), "",
    ])  # fmt: skip
