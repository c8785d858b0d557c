"""A home under attack: users of every role, certificates in every state, and what they are."""

import hashlib
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import sqlalchemy as sql
from argon2 import PasswordHasher

from flows import run_orders
from schemas.access import ROLES
from schemas.certificate_orders import CheckOrder, IssueOrder
from storage import secret_files
from storage.catalogue import database, tables, trail, users
from storage.home import Home
from tests.drafts import draft

PASSWORD = "correct horse battery"
QUICK = PasswordHasher(time_cost=1, memory_cost=64, parallelism=1)
WHAT_COUNTS = (
    tables.certificates, tables.decisions, tables.series, tables.results, tables.runs,
    tables.orders, tables.users,
)  # fmt: skip
HARMLESS = ("refuse ", "log in", "log out")  # how entries begin that a hostile call may leave
PROXY = """[proxy]
addresses = ["127.0.0.1"]
header = "X-Remote-User"
secret_file = "proxy.secret"
"""


@dataclass
class Attacked:
    """A home, its certificates by state, and how it was before the attack."""

    home: Home
    certificates: dict[str, str]
    before: dict[str, str] = field(default_factory=dict)
    entries: int = 0

    def look(self) -> None:
        """Remember how it stands now."""
        self.before, self.entries = stand(self.home), len(trail.entries(self.home))

    def acted(self) -> list[str]:
        """What an attack changed: tables, files, and entries of the trail that do more than log."""
        now = stand(self.home)
        changed = [name for name in now if now[name] != self.before.get(name)]
        return changed + [
            f"{entry.person} {entry.action} {entry.subject}"
            for entry in trail.entries(self.home)[self.entries :]
            if not entry.action.startswith(HARMLESS)
        ]


def attacked(home: Home) -> Attacked:
    """A home with a user of each role (by its name) and a draft, a checked and an issued one."""
    for role in ROLES:
        users.add(role, role, QUICK.hash(PASSWORD), home, "Admin")
    keys = [draft(home, serial).certificate.number for serial in ("1", "2", "3")]
    place = str(home.path)
    for key in keys[1:]:
        run_orders.check(CheckOrder(certificate=key, by="verifier", home=place))
    issued = run_orders.issue(IssueOrder(certificate=keys[2], by="issuer", home=place))
    secret_files.made(home.path / "proxy.secret")
    (home.path / "pages.toml").write_text(PROXY, encoding="utf-8")
    made = Attacked(
        home, {"draft": keys[0], "checked": keys[1], "issued": issued.certificate.number}
    )
    made.look()
    return made


def stand(home: Home) -> dict[str, str]:
    """A digest of each table that counts, and of the files of certificates."""
    found = {}
    for table in WHAT_COUNTS:
        rows = database.rows(home, sql.select(table).order_by(*table.primary_key))
        found[table.name] = hashlib.sha256(repr([tuple(row) for row in rows]).encode()).hexdigest()
    for file in sorted(home.certificates.rglob("*")):
        found[file.name] = hashlib.sha256(file.read_bytes()).hexdigest()
    return found


@contextmanager
def log_lines() -> Iterator[list[str]]:
    """The lines that the pages and the flows of this process log meanwhile."""
    lines: list[str] = []

    class Kept(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            lines.append(record.getMessage())

    logger, kept = logging.getLogger("mimucal.access"), Kept()
    level, up = logger.level, logger.propagate
    logger.setLevel(logging.INFO)
    logger.propagate = False
    logger.addHandler(kept)
    try:
        yield lines
    finally:
        logger.removeHandler(kept)
        logger.setLevel(level)
        logger.propagate = up
