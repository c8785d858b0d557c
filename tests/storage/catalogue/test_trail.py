"""The trail: chained, refused to change by the database, and every change found all the same."""

import hashlib
import json
from datetime import UTC, datetime

import pytest
import sqlalchemy as sql

from storage.catalogue import audit_trail, database, tables
from storage.home import Home
from tests.keep import by_force

DAY = datetime(2026, 11, 23, 8, tzinfo=UTC)
TRAIL = tables.trail


@pytest.fixture
def written(fresh) -> Home:
    """A home with a trail of four entries."""
    with database.changing(fresh) as connection:
        for number in range(1, 5):
            audit_trail.add(
                connection, "Wang 王", "check", f"A-{number}", at=DAY, reason="ok", n=number
            )
    return fresh


def test_entries_are_numbered_and_each_holds_the_hash_of_the_one_before(written):
    entries = audit_trail.entries(written)
    assert [entry.number for entry in entries] == [1, 2, 3, 4]
    assert [entry.previous_hash for entry in entries[1:]] == [entry.hash for entry in entries[:-1]]
    assert entries[0].details == '{"n":1,"reason":"ok"}'
    assert (entries[0].at, entries[0].person) == (DAY, "Wang 王")
    assert list(audit_trail.faults(written)) == []


def test_an_entry_is_gone_with_the_transaction_that_fails(written):
    def fail() -> None:
        with database.changing(written) as connection:
            audit_trail.add(connection, "Li", "issue", "A-1")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert len(audit_trail.entries(written)) == 4
    assert list(audit_trail.faults(written)) == []


@pytest.mark.parametrize(
    "statement", [sql.update(TRAIL).values(person="Li"), sql.delete(TRAIL)], ids=["edit", "delete"]
)
def test_the_database_refuses_to_change_an_entry(either, statement):
    with database.changing(either) as connection:
        audit_trail.add(connection, "Wang 王", "check", "A-1")
    with (
        pytest.raises(sql.exc.DatabaseError, match="append-only"),
        database.changing(either) as connection,
    ):
        connection.execute(statement)
    assert [entry.person for entry in audit_trail.entries(either)] == ["Wang 王"]
    assert list(audit_trail.faults(either)) == []


@pytest.mark.parametrize(
    ("statement", "says"),
    [
        (sql.update(TRAIL).values(person="Li").where(TRAIL.c.number == 2), "entry 2 was changed"),
        (sql.update(TRAIL).values(details="{}").where(TRAIL.c.number == 4), "entry 4 was changed"),
        (sql.delete(TRAIL).where(TRAIL.c.number == 1), "entry 1 is missing"),
        (sql.delete(TRAIL).where(TRAIL.c.number == 3), "entry 3 is missing"),
        (sql.delete(TRAIL).where(TRAIL.c.number == 4), "does not end with entry 4"),
        (sql.delete(TRAIL), "does not end with entry 4"),
    ],
)
def test_a_change_by_somebody_who_may_do_everything_is_found(written, statement, says):
    by_force(written, statement)
    (fault,) = audit_trail.faults(written)
    assert says in fault
    assert "\n" not in fault


def test_an_entry_written_anew_with_its_own_hash_breaks_the_chain(written):
    second = audit_trail.entries(written)[1].model_dump()
    forged = second | {"person": "Li"}
    dated = forged | {"at": forged["at"].astimezone(UTC).isoformat(timespec="microseconds")}
    del dated["hash"]
    text = json.dumps(dated, ensure_ascii=False, sort_keys=True, separators=(",", ":"))
    forged["hash"] = hashlib.sha256(text.encode()).hexdigest()
    by_force(written, sql.update(TRAIL).where(TRAIL.c.number == 2).values(**forged))
    (fault,) = audit_trail.faults(written)
    assert "entry 3 does not follow" in fault


def test_entries_written_at_once_are_one_chain(fresh, at_once):
    script = """
from storage.catalogue import audit_trail, database
for each in range(10):
    with database.changing(home) as connection:
        audit_trail.add(connection, "Li", "check", f"A-{each}")
"""
    at_once(script, fresh, processes=3)
    assert [entry.number for entry in audit_trail.entries(fresh)] == list(range(1, 31))
    assert list(audit_trail.faults(fresh)) == []
